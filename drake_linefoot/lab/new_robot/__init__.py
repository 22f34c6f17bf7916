"""A description of a robot from its model alone: what `linefoot new-robot` finds and writes."""
