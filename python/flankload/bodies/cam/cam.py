"""Bodies of kind "cam": a disc with a closed profile, fixed at its bore."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_up
from flankload.bodies.body import Body, Material, WholeMesh
from flankload.bodies.cam.cam_profile import cam_profile
from flankload.meshes.blocks import (
    MOST_NODES,
    MOST_PARTS,
    BlockMesh,
    check_count,
    growing_breaks,
    with_middles,
)

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Numbers
    from flankload.bodies.cam.cam_profile import CamProfile
    from flankload.scene import Cam

#: Default number of elements around the profile: at least the first number; per wall thickness of
#: length; per radian of the sharpest nose; at most the last number.
LEAST_ELEMENTS, ELEMENTS_PER_WALL, ELEMENTS_PER_RADIAN, MOST_ELEMENTS = 96.0, 4.0, 1.2, 400.0
#: Pressure modes relative to those of a gear's flank, per element: five elements per harmonic.
MODES_PER_ELEMENT = 8.2 / 96
#: First layer relative to the length of the elements, and growth of the layers towards the bore.
#: The first layer is thin, since short waves of pressure decay within a third of the element length
#: (a factor of 1 leaves 0.5 % of the wind-up of a thin cam).
FIRST_LAYER, GROWTH = 0.3, 1.4
LEAST_LAYERS = 3


def build_cam(
    spec: Cam, key: str, *, folder: Path, flank_element_mm: float | None, fineness: float
) -> Body:
    """Build a cam; one that is impossible is refused.

    Parameters as of `build_body`; `fineness`: number of elements along the profile relative to the
    default, if `flank_element_mm` is None.
    """
    profile = cam_profile(spec, key, folder=folder)
    bore_radius = 0.5 * spec.bore_diameter_mm
    length = profile.curve.length_mm
    elements = _elements(profile, bore_radius)
    mesh = None
    if not spec.rigid:
        element_mm = flank_element_mm or length / (elements * fineness)
        mesh = cam_mesh(profile, bore_radius_mm=bore_radius, flank_element_mm=element_mm)
    turn = np.linspace(0.0, length, 721)
    return Body(
        kind=spec.kind,
        curve=profile.curve,
        teeth=1,
        material=Material(spec.young_modulus_MPa, spec.poisson_ratio),
        rigid=spec.rigid,
        mesh=mesh,
        mode_range_mm=(0.0, length),
        reference_radius_mm=profile.least_radius_mm,
        outline=profile.curve.point(turn)[::-1],
        bore_radius_mm=bore_radius,
        modes_part=MODES_PER_ELEMENT * elements,
        turns_clockwise=spec.sense == "clockwise",
    )


def _elements(profile: CamProfile, bore_radius: float) -> float:
    """Number of elements around the profile in the default discretization."""
    curve, wall = profile.curve, profile.least_radius_mm - bore_radius
    sharpest = float(curve.curvature(curve.breaks).max())
    wanted = curve.length_mm * max(ELEMENTS_PER_WALL / wall, ELEMENTS_PER_RADIAN * sharpest)
    return min(max(wanted, LEAST_ELEMENTS), MOST_ELEMENTS)


def cam_mesh(profile: CamProfile, *, bore_radius_mm: float, flank_element_mm: float) -> WholeMesh:
    """Mesh a cam: rays from the bore to the profile, layers that grow inwards.

    It has one closed flank, along which no element is longer than `flank_element_mm`.
    """
    length = profile.curve.length_mm
    parts = 0.5 * length / flank_element_mm
    check_count(parts, MOST_PARTS, "elements along a line")
    half = max(8, round_up(parts))
    wall = profile.least_radius_mm - bore_radius_mm
    first = min(FIRST_LAYER * length / (2 * half), wall / LEAST_LAYERS)
    depth = growing_breaks(wall, first, GROWTH, None)
    up = 1.0 - with_middles(depth)[::-1]
    check_count(2.0 * half * up.size, MOST_NODES, "nodes")
    blocks = BlockMesh()
    ends: dict[str, Numbers] = {}
    halves = [with_middles(np.linspace(k, k + 1, half + 1)) * 0.5 * length for k in (0, 1)]
    rows, fixed = [], []
    for s in halves:
        top = profile.curve.point(s)
        bottom = bore_radius_mm * top / np.hypot(*top.T)[:, None]
        numbers = blocks.add(bottom + up[:, None, None] * (top - bottom), ends)
        ends = {"left": numbers[:, -1], "right": numbers[:, 0]}
        rows.append(numbers[-1])
        fixed.append(numbers[0])
    flank = np.append(rows[0], rows[1][1:])
    s = np.append(halves[0], halves[1][1:])
    return WholeMesh.of_blocks(blocks, np.concatenate(fixed), flank, s)
