"""Types that the studies share."""

from typing import Any

from drake_linefoot.types import Array, Flags

__all__ = ["Array", "Data", "Flags"]

Data = dict[str, Any]  # as JSON can hold it
