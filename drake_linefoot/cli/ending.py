"""How a command ends: the exit status, and what is said of it."""

FINE, FELL, BAD_INPUT, BROKE_OFF, INTERRUPTED = 0, 1, 2, 3, 130
STATUS = (
    "Exit status: 0 fine; 1 the robot fell (everything is written); 2 bad input; "
    "3 the run broke off; 130 interrupted. Nothing is ever half-written."
)
