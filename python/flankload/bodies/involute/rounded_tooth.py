"""Blocks of a tooth with rounded tips: layers along its outline around a core.

A block corner on a smooth outline would cause an element angle of 180 degrees, where the Jacobian
vanishes. Therefore the layers follow the outline around the rounding, and the corner of the core is
inside the tooth.
"""

from __future__ import annotations

from math import atan2, cos
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.meshes.blocks import BlockMesh, coons

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.involute.sector_breaks import ToothCurve


#: Largest thickness of the layers over the half-width of the tip.
LAYERS_RATIO = 0.6


def rounded_tooth(
    mesh: BlockMesh,
    curve: ToothCurve,
    s_flank: Floats,
    foot: tuple[Floats, Floats],
    top: tuple[Floats, Floats],
    n: int,
) -> tuple[Numbers, Numbers, Numbers]:
    """Add the blocks of a tooth with rounded tips; returns the nodes of flank, tip and foot.

    `s_flank` (r,) ends at the middle of the rounding. `foot`: points (m, 2) across the foot of the
    tooth from the working flank to its mirror image, and their relative positions (m,). `top`: the
    same (m - 2 n) across the tip between the middles of the roundings. n: number of nodes across
    the layers, without the first.
    """
    mirror = np.array([1.0, -1.0])
    places, parts = foot
    flank = curve.point(s_flank)
    thick = float(np.linalg.norm(places[n] - places[0]))
    peak = _corner_of_core(curve, flank[-1], thick)
    up = (s_flank - s_flank[0]) / (s_flank[-1] - s_flank[0])
    inner = _inner_line(curve, s_flank, up, places[n], peak)
    layer = parts[: n + 1] / parts[n]
    inwards = flank[-1] + layer[:, None] * (peak - flank[-1])
    half_angle = atan2(peak[1], peak[0]) * (1 - 2 * top[1])
    below = np.hypot(*peak) * directions(half_angle)
    across = np.stack([(parts[n:-n] - parts[n]) / (1 - 2 * parts[n]), top[1]])
    grid = coons(places[n:-n], below, inner, inner * mirror, across, up)
    core = mesh.add(grid, {})
    grid = coons(places[: n + 1], inwards, flank, inner, layer, up)
    working = mesh.add(grid, {"right": core[:, 0]})
    other = mesh.add(grid[:, ::-1] * mirror, {"left": core[:, -1]})
    down = inwards[::-1]
    grid = coons(below, top[0], down, down * mirror, top[1], 1 - layer[::-1])
    tip = mesh.add(grid, {"bottom": core[-1], "left": working[-1, ::-1], "right": other[-1]})
    bottom = np.concatenate([working[0, :-1], core[0], other[0, 1:]])
    return working[:, 0], tip[-1], bottom


def _corner_of_core(curve: ToothCurve, middle: Floats, thick: float) -> Floats:
    """Corner of the core, at the same depth d below flank and tip.

    Lines at this depth intersect at r + (d - r) / cos b below the middle of the rounding with the
    angle 2 b and the radius r.
    """
    start, end = curve.range_of("tip_radius")
    (first, last), (begin, stop) = curve.tangent([start, end]), curve.point([start, end])
    chord = stop - begin
    turned = 0.5 * abs(atan2(first[0] * last[1] - first[1] * last[0], float(first @ last)))
    radius = 0.5 * float(np.hypot(*chord)) / np.sin(turned)
    inward = np.array([chord[1], -chord[0]]) / np.hypot(*chord)
    deep = min(thick, LAYERS_RATIO * float(middle[1]))
    return middle + (radius + (deep - radius) / cos(turned)) * inward


def _inner_line(curve: ToothCurve, s: Floats, up: Floats, first: Floats, last: Floats) -> Floats:
    """Inner edge of the layers (r, 2): the flank without its rounding, shifted to fit both ends."""
    start = curve.range_of("tip_radius")[0]
    straight = curve.point(np.minimum(s, start))
    straight += np.maximum(s - start, 0.0)[:, None] * curve.tangent([start])
    part = up[:, None] ** 2
    return np.asarray(straight + (1 - part) * (first - straight[0]) + part * (last - straight[-1]))
