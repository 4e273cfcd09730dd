"""Boundaries of the elements of a gear's sector: along the profile, across the tooth, radially."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import pi, radians
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from flankload.base.rounding import round_up
from flankload.flank import ACTIVE
from flankload.meshes.blocks import even_breaks, growing_breaks, symmetric_breaks

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.involute.ring_mesh import InvertedCurve, InvertedTooth
    from flankload.bodies.profile.tooth_profile import ToothProfile
    from flankload.flank import FlankCurve

    #: An external tooth on the +x axis, and its flank.
    ToothCurve: TypeAlias = FlankCurve | InvertedCurve
    ToothForm: TypeAlias = ToothProfile | InvertedTooth

#: Angle between the fillet's tangent and the tooth's centre line at the split point, rad.
SPLIT_ANGLE = radians(50.0)

#: Largest ratio of neighbouring elements.
GROWTH = 1.4

#: Element lengths over the flank element: along the fillet, first layer below the flank, largest
#: inside the tooth, first row below the root. On the FZG type C pinion with elements of 1 mm, first
#: layers of 0.5, 0.35, 0.25 leave errors of 2.0e-4, 1.1e-4, 0.9e-4 in the compliance under uniform
#: pressure; finer fillets, rows and inner elements change it by 0.6e-4 at most.
FILLET, FIRST_LAYER, INNER, FIRST_ROW = 0.4, 0.35, 1.0, 0.4

#: Largest turn of the profile within one element of the fillet, rad.
LARGEST_TURN = radians(25.0)

#: Largest height of the rim's rows over their radius; one pitch in rad, if that is larger.
ROW_RATIO = 0.35

#: Largest row at a bore that is fixed over its width, over that: displacements decay from there
#: within a width. Without this limit, a helical wheel 10 mm wide with a diameter of 384 mm is 1.5 %
#: too stiff, with it 0.1 %.
BORE_ROW = 0.5


@dataclass(frozen=True)
class SectorBreaks:
    """Arc lengths and relative positions of element boundaries.

    Attributes
    ----------
    low : from the root circle to the split point, along the curve
    flank : from the split point to the block's corner at the tip
    tip : from there to the end of the curve (rounding or chamfer); one value if there is none
    columns : relative positions across the tooth, even in number
    rows : relative positions from the split point down to the bore
    layers : number of elements across the layers below flank and tip; 0 if the tip is not rounded
    """

    low: Floats
    flank: Floats
    tip: Floats
    columns: Floats
    rows: Floats
    layers: int


def sector_breaks(
    profile: ToothForm,
    bore_radius: float,
    h: float,
    on_flank: float | None = None,
    *,
    width_mm: float | None = None,
) -> SectorBreaks:
    """Boundaries for elements no longer than h, or `on_flank` along the flank, mm.

    `width_mm`: that over which the bore is fixed, if rows depend on it.
    """
    curve = profile.curve
    form = profile.mode_range_mm[0]
    split = _split_point(curve, form)
    corner, end = _tip_corner(curve)
    on_flank = on_flank or h
    radius = float(np.linalg.norm(curve.point([split])[0]))
    pieces = [_turned_breaks(curve, split, form, FILLET * h)]
    parts = np.unique([form, *curve.range_of(*ACTIVE), corner])
    for start, stop in pairwise(parts):
        least = 3 if start == form else 1
        pieces.append(even_breaks(start, stop, on_flank, least)[1:])
    tip = np.array([corner])
    if end > corner:
        tip = even_breaks(corner, end, on_flank)
    width = 2 * curve.point([0.5 * (form + corner)])[0, 1]
    depth = radius - bore_radius
    pitch = 2 * pi / profile.teeth
    below = np.linspace(0.0, depth, 50)
    caps = np.stack([below, np.maximum(ROW_RATIO, pitch) * (radius - below)])
    if width_mm is not None:  # rows that grow from the bore
        rising = (BORE_ROW * width_mm + (GROWTH - 1.0) * (depth - below)) / GROWTH
        caps[1] = np.minimum(caps[1], rising)
    rows = growing_breaks(depth, FIRST_ROW * h, GROWTH, caps)
    if rows.size < 3:
        rows = np.array([0.0, 0.5, 1.0])
    columns = symmetric_breaks(width, FIRST_LAYER * on_flank, GROWTH, INNER * max(h, on_flank))
    layers = 0
    if "tip_radius" in curve.labels:
        columns, layers = _layered(columns, 2 * (end - corner) / width)
    inside = (columns.size - 1) // 2 - layers
    if tip.size > inside:
        tip = np.linspace(corner, end, inside)
    return SectorBreaks(
        low=_turned_breaks(curve, 0.0, split, FILLET * h),
        flank=np.concatenate(pieces),
        tip=tip,
        columns=columns,
        rows=rows,
        layers=layers,
    )


def _layered(columns: Floats, rounding: float) -> tuple[Floats, int]:
    """Columns, and the number of layers along the outline, as thick as a rounding is long.

    At least two columns remain on each half of the core, for the rounding and for the land.
    """
    half = columns[: columns.size // 2 + 1]
    layers = max(1, int(np.searchsorted(half, 0.5 * rounding)))
    layers = min(layers, max(1, half.size - 3))
    while half.size - 1 - layers < 2:
        half = np.insert(half, -1, 0.5 * (half[-2] + half[-1]))
    return np.concatenate([half, 1.0 - half[-2::-1]]), layers


def slants(curve: ToothCurve, s: Floats) -> Floats:
    """Angle (m,) between tangent and centre line at s (m,), positive for a tapering tooth."""
    tangent = curve.tangent(s)
    return np.arctan2(-tangent[:, 1], tangent[:, 0])


def _split_point(curve: ToothCurve, form: float) -> float:
    """Arc length at which the fillet has the split angle, away from the ends of the fillet."""
    s = np.linspace(0.0, form, 400)
    slant = slants(curve, s)
    low, high = np.interp([0.25, 0.75], [0.0, 1.0], [slant.min(), slant[0]])
    wanted = min(max(SPLIT_ANGLE, low), high)
    return float(s[np.argmax(slant <= wanted)])


def _tip_corner(curve: ToothCurve) -> tuple[float, float]:
    """Arc lengths of the tip corner of the tooth block, and of the end of the curve."""
    start = curve.range_of(*ACTIVE)[1]
    if "tip_radius" in curve.labels:
        return 0.5 * (start + curve.length_mm), curve.length_mm
    return start, curve.length_mm


def _turned_breaks(curve: ToothCurve, start: float, end: float, largest: float) -> Floats:
    """Boundaries between two arc lengths, with limits of the length and the turn of an element."""
    s = np.linspace(start, end, 200)
    turn = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(slants(curve, s))))])
    # equal parts of the sum of length and turn over their limits
    measure = (s - start) / largest + turn / LARGEST_TURN
    longest = max((end - start) / largest, turn[-1] / LARGEST_TURN)
    count = max(1, round_up(longest))
    return np.interp(np.linspace(0.0, measure[-1], count + 1), measure, s)
