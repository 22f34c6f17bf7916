"""Drake's solvers of programs with friction cones, as parameters name them."""

MOST_ITERATIONS = 1_000_000
SOLVERS = ("osqp", "clarabel")
