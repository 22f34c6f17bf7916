"""The functions that build each diagram."""
