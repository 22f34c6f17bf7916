"""Line-foot biped walking on Drake: ECD MPC, whole-body control, contact estimation.

Importing the package limits the linear-algebra library to one thread: the matrices of
a walking controller are small, and more threads make them several times slower.
"""

from importlib import metadata

from drake_linefoot import _environment as _environment

try:
    __version__ = metadata.version("drake_linefoot")  # from the tags of git, at installation
except metadata.PackageNotFoundError:  # a folder on the path that was not installed
    __version__ = "0+unknown"
