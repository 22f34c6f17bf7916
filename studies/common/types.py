"""Types that the studies share."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Data = dict[str, Any]  # as JSON can hold it
Progress = Callable[[float, str], None]  # share that is done, from 0 to 1; what goes on
