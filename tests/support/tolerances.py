"""Named tolerances of the tests; model tolerances are defined in the test that uses them."""

import numpy as np

# Identities: both sides differ by rounding only.
ROUND_OFF = 100 * float(np.finfo(float).eps)
# Solvers, relative to the scale of the problem.
SOLVER = 1e-9
#: The ring closure compared with the meshed ring: identical except for rounding.
CLOSURE = 1e-10
#: Velocities per rad of the contact point on each body individually, at a hundredth of the nominal
#: load, whose deflection shifts the point, mm.
SPEED_MM = 5e-3
#: Sliding speed of the surfaces along their own flanks, as used for friction, compared with that of
#: rigid bodies at one point; relative, and in mm/rad.
RUBBING = 2e-2
