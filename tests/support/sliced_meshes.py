"""Records of twisted bodies in slices and of their meshes, for the call of the core."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flankload.contact.body_record import packed_parts
from flankload.contact.meshes import Members, with_members
from tests.support.packed_meshes import body_record, mesh_record

#: Ends of the slices, mm, and rotation of the sections, rad/mm.
EDGES = np.array([-4.0, -1.5, 0.5, 2.0, 4.0])
TWIST = 2e-3
SLICES = EDGES.size - 1
#: Modes along the profile and polynomials over the width.
MODES, AXIAL = 2, 3


def sliced_roller(
    meshes: int = 1, *, hand: int = 1, coupling: float = 0.0, **parts: Any
) -> NDArray[np.float64]:
    """A twisted cylinder in one or more meshes, leaning against its mates.

    `hand` -1: the twist of its mate; `coupling`: part of its compliance between different meshes.
    """
    n = MODES * AXIAL
    random = np.random.default_rng(5).standard_normal((n, n))
    own = 3e-7 * (np.eye(n) + random @ random.T / n)
    middles = 0.5 * (EDGES[1:] + EDGES[:-1])
    of_mesh = np.repeat(np.arange(meshes), SLICES)
    record = body_record(
        SLICES * meshes,
        np.stack([own, coupling * own], axis=2),
        site_angles=hand * TWIST * np.tile(middles, meshes),
        deviations=np.tile(1e-3 * middles, meshes),
        kernel=9e-6,
        block=np.asfortranarray(1 + (of_mesh[:, np.newaxis] != of_mesh), dtype=np.intc),
    )
    # ends of the body, twist, images behind both ends for working and for coast flanks
    axial = [AXIAL, -5.0, 4.0, hand * TWIST, 0.3, 0.9, 0.5, 1.1]
    return packed_parts(record, [("axial", np.array(parts.pop("axial", axial))), *parts.items()])


def sliced_mesh(level: float, twist: float = TWIST, **members: Any) -> NDArray[np.float64]:
    """Mesh of two of them."""
    record = mesh_record(level, n_sites=SLICES, twist=twist)
    record = packed_parts(record, [("slices", EDGES)])
    return with_members(record, Members(**members)) if members else record


def shaft(compliance: NDArray[np.float64], place_mm: float = 0.7) -> NDArray[np.float64]:
    """Part of a body whose section at a place has a compliance (6, 6), symmetric up to rounding."""
    return np.append(0.5 * (compliance + compliance.T).ravel(), place_mm)
