"""Records of bodies and meshes taken apart, by the layout of fortran/position/body_record.f90."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flankload.contact.body_record import PARTS

#: All parts in the order of their numbers.
NAMES = (
    *PARTS,
    *("breaks", "coefficients", "corners", "site_angles", "deviations"),
    *("mode_range", "kernel", "smooth", "block"),
    "mesh",
)
COUNTS = ("breaks", "powers", "sites", "modes", "blocks")
#: Numbers before the places of the parts, and before the parts.
N_FIRST = 7
N_HEADER = N_FIRST + 2 * len(NAMES)


def counts_of(record: NDArray[np.float64]) -> dict[str, int]:
    """Sizes of a body."""
    return dict(zip(COUNTS, record[2:N_FIRST].astype(int).tolist(), strict=True))


def parts_of(record: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Values of each part; empty if the part is absent. `smooth` has its shape."""
    places = record[N_FIRST:N_HEADER].astype(int).reshape(-1, 2)
    found = {
        name: record[first - 1 : first - 1 + length]
        for name, (first, length) in zip(NAMES, places, strict=True)
    }
    n = counts_of(record)
    shape = (n["modes"], n["modes"], n["blocks"])
    return found | {"smooth": found["smooth"].reshape(shape, order="F")}
