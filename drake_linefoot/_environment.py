"""What has to be in the environment before numpy and Numba are loaded."""

import codecs
import locale
import os
import sys

LOCALE = "must be one with UTF-8, for Drake: set LC_ALL=C.UTF-8, or PYTHONUTF8=1"
VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",  # numpy's wheels for macOS
)


def limit_blas_threads() -> None:
    """Limit BLAS to one thread, before or after numpy has been loaded.

    The environment variables work only until a library loads its BLAS, and they reach the
    worker processes too; what is loaded already is limited through threadpoolctl. A number
    set in the environment beforehand is left there.
    """
    for name in VARIABLES:
        os.environ.setdefault(name, "1")
    if "numpy" in sys.modules:
        import threadpoolctl

        threadpoolctl.threadpool_limits(1)


def is_without_utf8() -> bool:
    """Return whether the locale has ASCII alone, with which Drake cannot be loaded."""
    return codecs.lookup(locale.getencoding()).name == "ascii" and not sys.flags.utf8_mode


# Numba optimises at level 1: the machine code is as fast, and made in 4/5 of the time. A level
# set in the environment beforehand is left there.
os.environ.setdefault("NUMBA_OPT", "1")
limit_blas_threads()
