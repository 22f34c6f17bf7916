"""Studies made with the package: the paper's results, robustness, contact, envelope, speed."""
