"""A process that dies."""

import os

os.abort()
