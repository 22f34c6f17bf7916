"""The paper's figures and claims, reproduced: `python -m studies.paper`."""
