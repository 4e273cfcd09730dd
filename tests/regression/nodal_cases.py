"""Points of flanks and compliances between them, as old programs have them."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.support.nodal_position import DATA, read_data
from tests.support.nodal_sweep import SWEEP_DATA, read_sweep

from .cases import Case
from .quantities import NODAL

#: Pairs of a position, of which each has some numbers.
SOME = slice(None, None, 4)


def _position() -> dict[str, Any]:
    flank, _, gap_angle, lever, torque_lever, torque_lever_2, matrix = read_data(DATA).pairs()
    return {
        "pairs": [(flank == f).sum() for f in (1, 2)],
        "gap_angle": gap_angle[SOME],
        "levers": [lever[SOME], torque_lever[SOME], torque_lever_2[SOME]],
        "influence": matrix[SOME, SOME],
    }


def _sweep(**changes: Any) -> dict[str, Any]:
    found = read_sweep(SWEEP_DATA).solve(**changes)
    return {
        "status": found["status"],
        "pairs": found["n_pairs"],
        "rotation": found["rotation"],
        "tangent": found["tangent"],
        "torque_2": found["torque_2"],
        "flank_force": found["flank_force"],
        "largest_force": np.nanmax(found["force"], axis=0),
    }


def nodal_cases() -> dict[str, Case]:
    """All cases by name."""
    file = "examples/legacy_fortran/"
    return {
        "nodal_position": Case(
            inputs={"file": file + DATA.name},
            provenance="the external gear half a pitch on; scipy's splines and root finder in "
            "tests/unit/contact/test_nodal_position.py",
            solve=_position,
            known=NODAL,
        ),
        "nodal_sweep": Case(
            inputs={"file": file + SWEEP_DATA.name, "circles": "through the points of body 1"},
            provenance="the external gear over a pitch; the sweep of the scene itself in "
            "tests/unit/contact/test_nodal_sweep.py",
            solve=_sweep,
            known=NODAL,
        ),
        "nodal_sweep_circles": Case(
            inputs={"file": file + SWEEP_DATA.name, "circles": "20 to a flank"},
            provenance="the same on circles evenly spread",
            solve=lambda: _sweep(n_circles=20),
            known=NODAL,
        ),
    }
