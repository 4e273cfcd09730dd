"""Records of simple bodies and meshes for the call of the core with several meshes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload import _core
from tests.support.pressed_cylinders import arc

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Flank of one of two cylinders that press each other at a distance of 72 mm of the axes.
CYLINDER = arc((36.0, -20.0), 20.0, np.pi / 2 + 0.3, np.pi / 2 - 0.3)


def body_record(n_sites: int, smooth: NDArray[np.float64], **changes: Any) -> NDArray[np.float64]:
    """Record of a body, a cylinder by default; all of its sites are one tooth.

    `smooth` (m, m, 2): block of a site itself, and between sites.
    """
    block = np.full((n_sites, n_sites), 2, dtype=np.intc, order="F")
    np.fill_diagonal(block, 1)
    arguments: dict[str, Any] = {
        "breaks": CYLINDER.breaks,
        "coefficients": np.asfortranarray(CYLINDER.coefficients.transpose(2, 1, 0)),
        "corners": np.zeros(CYLINDER.breaks.size, dtype=np.intc),
        "site_angles": np.zeros(n_sites),
        "deviations": np.zeros(n_sites),
        "mode_range": np.array([0.0, CYLINDER.length_mm]),
        "kernel": 2.8e-7,
        "smooth": np.asfortranarray(smooth),
        "block": block,
    }
    values = (arguments | changes).values()
    record = np.empty(_core.flankload_pack_body(*values, np.empty(0)))
    assert _core.flankload_pack_body(*values, record) == 0
    return record


def mesh_record(
    level: float, distance_mm: float = 72.0, steps: int = 0, n_sites: int = 1, twist: float = 0.0
) -> NDArray[np.float64]:
    """Record of a mesh; `steps` of finite forces."""
    axes = np.array([[0.0, distance_mm], [0.0, 0.0]], order="F")
    arguments = (n_sites, axes, twist, np.array([10.0, 30.0, 2.5, level, steps]))
    record = np.empty(_core.flankload_pack_mesh(*arguments, np.empty(0)))
    assert _core.flankload_pack_mesh(*arguments, record) == 0
    return record
