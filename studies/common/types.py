"""Types that the studies share."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Data = dict[str, Any]  # as JSON can hold it
