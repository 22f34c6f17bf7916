"""The tasks of the whole-body controller, one file each, and their stack."""
