"""What Drake says on its own."""

import logging


def silence_drake() -> None:
    """Keep Drake from announcing ports, and that half spaces touch no deformable bodies.

    Works only once pydrake has been imported.
    """
    logging.getLogger("drake").setLevel(logging.ERROR)
