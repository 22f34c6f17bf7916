"""The paper's results, reproduced: a module for each figure, and the report of them all."""
