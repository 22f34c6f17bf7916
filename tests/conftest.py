"""What every test shares."""

from hypothesis import settings

import drake_linefoot  # noqa: F401  before numpy: one BLAS thread in every test process

settings.register_profile("linefoot", derandomize=True, deadline=None)
settings.load_profile("linefoot")
