"""Structured mesh of a follower: hub, arm, and a roller bonded to it or a flat along it.

All blocks are quadrilaterals with common edges. The hub is a ring in two parts, one of which is as
wide as the arm. A roller is a core with four blocks around it, one of which joins the arm.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.base.rounding import round_up
from flankload.bodies.body import WholeMesh
from flankload.meshes.blocks import BlockMesh, coons, growing_breaks, symmetric_breaks, with_middles

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.cam.lever import Lever


#: Half the angle of the roller's outer block, rad, and size of its core over its radius.
OUTER_ANGLE = 0.9
CORE_RATIO = 0.5
#: Largest inner elements over those along the flank; least number of elements across an arm.
INNER_RATIO = 1.6
LEAST_ACROSS = 8
#: Size of the first element at the sharp corners of arm, hub and roller, over the width of the arm,
#: and growth from there; equal elements leave an error of 1 % in the wind-up of a flat follower.
#: Both decrease with finer elements, so that the error of the corners converges.
CORNER_RATIO, CORNER_GROWTH = 0.01, 1.6
#: First layer below the flank over the length of its elements, and growth of the layers.
FIRST_LAYER, GROWTH = 0.4, 1.4


def roller_mesh(lever: Lever, *, flank_element_mm: float, finer: float = 1.0) -> WholeMesh:
    """Mesh a lever with a roller; the flank runs from the arm to the outermost point of the roller.

    No element along the flank is longer than `flank_element_mm`; `finer` divides the size of the
    elements at the sharp corners of the arm.
    """
    head = lever.head
    radius, (_, upper) = head.radius_mm, head.angles_rad  # type: ignore[union-attr]
    centre = np.array([head.arm_mm, 0.0])  # type: ignore[union-attr]
    width = lever.arm_mm[1] - lever.arm_mm[0]
    inner = INNER_RATIO * flank_element_mm
    # the outer end of the roller has the same number of elements as the arm's width
    most = width * min(1 / LEAST_ACROSS, flank_element_mm / (2 * OUTER_ANGLE * radius))
    part = _between_corners(width, width, most, finer)
    over = max(LEAST_ACROSS, round_up((upper - OUTER_ANGLE) * radius / flank_element_mm))
    blocks = BlockMesh()
    hub, fixed = _add_hub(blocks, lever, part, flank_element_mm, finer)
    # clockwise around the roller, from the end of the arm
    angles = (2 * pi - upper, upper, OUTER_ANGLE, -OUTER_ANGLE, -upper)
    even = np.linspace(0.0, 1.0, 2 * over + 1)
    turns = [
        start + steps * (end - start)
        for start, end, steps in zip(angles[:-1], angles[1:], (part, even) * 2, strict=True)
    ]
    behind = centre + radius * directions(turns[0])
    length = float(behind[0, 0]) - hub[1]
    steps = _between_corners(length, width, inner, finer)
    ends = _add_bar(blocks, hub[3], behind, steps, hub[0])[:, -1]
    core = _roller_core(turns, radius)
    rings: list[Numbers] = []
    depth = _layers((1 - CORE_RATIO) * radius, flank_element_mm)
    up = (1.0 - depth[::-1])[:, None, None]
    known: dict[str, Numbers] = {"top": ends}
    for k, turn in enumerate(turns):
        outer, within = centre + radius * directions(turn), centre + core[k]
        if k == 3:
            known["right"] = rings[0][:, 0]
        numbers = blocks.add(within + up * (outer - within), known)
        rings.append(numbers)
        known = {"left": numbers[:, -1]}
    _add_core(blocks, [centre + edge for edge in core], [ring[0] for ring in rings])
    half = turns[2].size // 2 + 1
    flank = np.concatenate([rings[1][-1], rings[2][-1][1:half]])
    turn = np.concatenate([turns[1], turns[2][1:half]])
    return WholeMesh.of_blocks(blocks, fixed, flank, radius * (turn[0] - turn))


def flat_mesh(lever: Lever, *, flank_element_mm: float, finer: float = 1.0) -> WholeMesh:
    """Mesh a lever with a flat, which is the flank; parameters as for `roller_mesh`."""
    low, high = lever.arm_mm
    start, end = lever.head.ends_mm  # type: ignore[union-attr]
    width, inner = high - low, INNER_RATIO * flank_element_mm
    part = _between_corners(width, width, min(inner, width / LEAST_ACROSS), finer)
    blocks = BlockMesh()
    hub, fixed = _add_hub(blocks, lever, part, flank_element_mm, finer)
    up = low + part * (high - low)
    ends = hub[0]
    if start - hub[2] > 1e-6 * start:
        border = np.stack([np.full(up.size, start), up], axis=1)
        steps = _from_corner(start - hub[2], width, flank_element_mm, finer)
        ends = _add_bar(blocks, hub[3], border, steps, ends)[:, -1]
        left = border
    else:
        left = hub[3]
    steps = _from_corner(end - start, width, flank_element_mm, finer)
    right = np.stack([np.full(up.size, end), up], axis=1)
    numbers = _add_bar(blocks, left, right, steps, ends)
    return WholeMesh.of_blocks(blocks, fixed, numbers[-1], steps * (end - start))


def _layers(thickness: float, flank_element_mm: float) -> Floats:
    """Relative positions from the flank inwards, with middle nodes; thin layers first."""
    caps = np.array([[0.0], [INNER_RATIO * flank_element_mm]])
    first = min(FIRST_LAYER * flank_element_mm, thickness / LEAST_ACROSS)
    return with_middles(growing_breaks(thickness, first, GROWTH, caps))


def _from_corner(length: float, width: float, largest: float, finer: float) -> Floats:
    """Relative positions along a length, with middle nodes; elements grow from a corner."""
    caps = np.array([[0.0], [largest]])
    first, growth = _steps(width, finer)
    return with_middles(growing_breaks(length, first, growth, caps))


def _between_corners(length: float, width: float, largest: float, finer: float) -> Floats:
    """The same with corners at both ends."""
    first, growth = _steps(width, finer)
    return with_middles(symmetric_breaks(length, first, growth, largest))


def _steps(width: float, finer: float) -> tuple[float, float]:
    """Size of the element at a corner of the arm, mm, and growth of the next ones."""
    return CORNER_RATIO * width / finer, 1.0 + (CORNER_GROWTH - 1.0) / finer


def _add_hub(
    blocks: BlockMesh, lever: Lever, part: Floats, element_mm: float, finer: float
) -> tuple[tuple[Numbers, float, float, Floats], Numbers]:
    """Add the hub, a ring in two parts; `part`: relative heights of the nodes at the arm.

    Returns the nodes at the arm, upwards, x of the lowest and the highest one, and their
    coordinates; then the nodes on the bore.
    """
    (y_low, y_high), radius = lever.arm_mm, lever.hub_radius_mm
    leaving = np.arcsin((y_low + part * (y_high - y_low)) / radius)
    low, high = leaving[[0, -1]]
    width, wall = y_high - y_low, radius - lever.bore_radius_mm
    largest = min(2 * INNER_RATIO * element_mm, wall)
    rest = _between_corners((2 * pi - high + low) * radius, width, largest, finer)
    radii = radius - wall * _from_corner(wall, width, min(largest, wall / 3), finer)[::-1]
    known: dict[str, Numbers] = {}
    parts = []
    # clockwise, so that rows run outwards
    for turn in (leaving[::-1], low + 2 * pi + rest * (high - low - 2 * pi)):
        parts.append(blocks.add(radii[:, None, None] * directions(turn), known))
        known = {"left": parts[0][:, -1], "right": parts[0][:, 0]}
    places = radius * directions(leaving)
    fixed = np.concatenate([part[0] for part in parts])
    return (parts[0][-1][::-1], float(places[0, 0]), float(places[-1, 0]), places), fixed


def _add_bar(blocks: BlockMesh, left: Floats, right: Floats, x: Floats, known: Numbers) -> Numbers:
    """Add a bar between two borders (points, upwards), straight above and below; x: divisions."""
    y = np.stack([(edge[:, 1] - edge[0, 1]) / np.ptp(edge[:, 1]) for edge in (left, right)])
    bottom, top = (
        a + x[:, None] * (b - a) for a, b in ((left[0], right[0]), (left[-1], right[-1]))
    )
    return blocks.add(coons(bottom, top, left, right, x, y), {"left": known})


def _roller_core(turns: list[Floats], radius: float) -> list[Floats]:
    """Edges of the core relative to the roller's centre, clockwise from the one at the arm."""
    edges = []
    for turn in turns:
        start, end = CORE_RATIO * radius * directions(turn[[0, -1]])
        edges.append(start + np.linspace(0.0, 1.0, turn.size)[:, None] * (end - start))
    return edges


def _add_core(blocks: BlockMesh, edges: list[Floats], numbers: list[Numbers]) -> None:
    """Add the core; its edges are clockwise from the lower left."""
    left, top, right, bottom = edges
    x, y = (np.linspace(0.0, 1.0, len(edge)) for edge in (top, left))
    grid = coons(bottom[::-1], top, left, right[::-1], x, y)
    known = {
        "left": numbers[0],
        "top": numbers[1],
        "right": numbers[2][::-1],
        "bottom": numbers[3][::-1],
    }
    blocks.add(grid, known)
