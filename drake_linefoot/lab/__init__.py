"""What runs, shows and judges the controller: `drake_linefoot[lab]`."""
