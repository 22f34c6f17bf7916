"""Ring 0: rotations, discretisation, polynomials; numpy only."""
