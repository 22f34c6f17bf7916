"""Ring 0: rotations, discretisation, polynomials; numpy, scipy and Numba only."""
