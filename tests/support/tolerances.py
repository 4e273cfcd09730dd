"""Named tolerances of the tests; tolerances of models stand in the test that states them."""

import numpy as np

# Identities: nothing but rounding may stand between both sides.
ROUND_OFF = 100 * float(np.finfo(float).eps)
# Solvers, on the scale of the problem.
SOLVER = 1e-9
#: The ring closure beside the meshed ring: identical but for rounding.
CLOSURE = 1e-10
#: Velocities per rad of the point of contact on each body alone at a hundredth of the nominal load,
#: which the flanks' approach shifts, mm.
SPEED_MM = 5e-3
#: Sliding of surfaces that run each along its own flank, as friction takes it, against that of
#: rigid bodies at one place; relative, and in mm/rad.
RUBBING = 2e-2
