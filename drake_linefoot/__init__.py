"""Line-foot biped walking on Drake: ECD MPC, whole-body control, contact estimation.

Importing the package limits the linear-algebra library to one thread: the matrices of
a walking controller are small, and more threads make them several times slower.
"""

from drake_linefoot import _environment as _environment

__version__ = "0.1.0"
