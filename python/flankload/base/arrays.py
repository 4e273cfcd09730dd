"""Types of arrays in annotations."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Complexes = NDArray[np.complex128]
#: Elements of a mesh: kind and nodes (E, k) of each block.
Cells = tuple[tuple[str, Numbers], ...]
