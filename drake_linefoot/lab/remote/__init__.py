"""The controller in a process of its own: messages of LCM, and both ends of them."""
