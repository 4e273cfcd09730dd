"""Named tolerances of the tests; tolerances of models stand in the test that states them."""

import numpy as np

# Identities: nothing but rounding may stand between both sides.
ROUND_OFF = 100 * float(np.finfo(float).eps)
# Solvers, on the scale of the problem.
SOLVER = 1e-9
