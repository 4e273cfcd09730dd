"""Mesh of quadratic quadrilaterals of a timing belt around its pulley, with contact boundaries.

A position on the belt is given by the angle of its pitch line around the pulley; tooth 0 is the
first one from the tight strand, and angle 0 is the middle of the land before it. The belt lies on
the pulley between two such angles and is straight beyond them. A piece of belt extends from one
place to another; places are counted in half pitches: 2k is the middle of tooth k, 2k - 1 is the
middle of the land before it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rounding import TIE
from flankload.mechanisms.belt.belt import Round
from flankload.meshes.blocks import BlockMesh, coons, even_breaks, with_middles

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.mechanisms.belt.belt import Strip

#: Elements on the flank of a tooth; along the strip they have the same length.
FLANK_ELEMENTS = 6
#: Least number of element rows from the land to the cord, and from the cord to the back.
LEAST_ROWS = 2
#: Meshed fraction of the arc over half a round tooth, whose tip has no contact.
TIP_BULGE = 0.6
#: Meshed length of the strands, in half pitches from the first and the last tooth: up to the middle
#: of the land behind the next tooth.
STRAND = 3


@dataclass(frozen=True)
class BeltMesh:
    """The mesh of a piece of belt; edges and lines are nodes in order, every second one a middle.

    Attributes
    ----------
    nodes : (N, 2) array
        Relative to the axis of the pulley, with the tight end of the wrap on the x axis, mm.
    turns_rad : (N,) array
        Angle of the outward normal of the pitch line at each node.
    cells : ((kind, (E, 9) array),)
    cord : array
        Nodes from the tight end to the slack one.
    flanks : dict of int to array
        Working flanks by the number of their teeth, from the land to the tip.
    lands : dict of int to array
        Part of each land that lies on the pulley, by the number of the tooth behind it; a belt
        without teeth has one land.
    left, right : arrays
        Nodes of the faces at the ends of the piece, beginning at the back; in the middle of a tooth
        they extend to its tip.
    bars : array
        Number of cord elements that lie on the pulley.
    tight, slack : (1,) or (0,) arrays
        Nodes of the cord where the strands begin; empty if these are outside the piece.
    """

    nodes: Floats
    turns_rad: Floats
    cells: Cells
    cord: Numbers
    flanks: dict[int, Numbers]
    lands: dict[int, Numbers]
    left: Numbers
    right: Numbers
    bars: Numbers
    tight: Numbers
    slack: Numbers


def half_land(strip: Strip, flank_elements: int) -> Floats:
    """Element boundaries on half a land, rad, beginning at its middle."""
    height, width = _tooth_size(strip)
    base = asin(0.5 * width / strip.land_radius_mm)
    largest = height / flank_elements / strip.land_radius_mm
    return even_breaks(0.0, 0.5 * strip.pitch_rad - base, largest, 2)


def coarser(strip: Strip, flank_elements: int) -> tuple[Strip, int]:
    """The strip with half as many rows, or fewer, and half as many elements on a flank.

    At least one row remains. Coarser flanks alone would show little of the discretization error.
    """
    radii = _radii(strip, 1.5 * _tooth_size(strip)[0] / flank_elements)[::2]
    below = int(np.searchsorted(radii, strip.pitch_radius_mm - TIE))
    rows = max(1, below // 2), max(1, (radii.size - 1 - below) // 2)
    return replace(strip, rows=rows), max(1, flank_elements // 2)


def mesh_strip(
    strip: Strip,
    flank_elements: int = FLANK_ELEMENTS,
    *,
    ends_rad: tuple[float, float] = (0.0, 0.0),
    places: tuple[int, int] | None = None,
) -> BeltMesh:
    """Mesh of the belt on its pulley, or of a piece of it.

    The belt leaves the pulley at two angles `ends_rad` from the middles of the first and the last
    land. The piece lies between two places in half pitches; by default it is the whole belt with
    the strands of `STRAND`.
    """
    builder = _StripBuilder(strip, flank_elements, ends_rad)
    for place in range(*(places or (-STRAND, 2 * strip.wrapped_teeth - 2 + STRAND))):
        builder.add(place)
    return builder.mesh()


def _tooth_size(strip: Strip) -> tuple[float, float]:
    """Height and width of a tooth; substitutes for the mesh of a belt without teeth."""
    tooth = strip.tooth
    if tooth is None:
        return 0.25 * strip.pitch_mm, 0.5 * strip.pitch_mm
    return tooth.height_mm, tooth.width_mm


class _StripBuilder:
    """Assembly of half pitches; nodes are radius and angle, as if all lay on the pulley."""

    def __init__(self, strip: Strip, flank_elements: int, ends_rad: tuple[float, float]) -> None:
        self._strip = strip
        wrap = strip.wrapped_teeth * strip.pitch_rad
        self._ends = (ends_rad[0], wrap + ends_rad[1])
        tooth, (height, width) = strip.tooth, _tooth_size(strip)
        size = height / flank_elements
        self._half_land = half_land(strip, flank_elements)
        base = asin(0.5 * width / strip.land_radius_mm)
        self._foot = even_breaks(0.0, base, 1.2 * size / strip.land_radius_mm, 2)
        self._rows = _radii(strip, 1.5 * size)
        self._cord_row = int(np.argmin(np.abs(self._rows - strip.pitch_radius_mm)))
        self._half_tooth = (
            _half_tooth(strip, with_middles(self._foot), 2 * flank_elements + 1)
            if tooth is not None
            else None
        )
        self._blocks = BlockMesh()
        self._known: dict[str, Numbers] = {}
        self._middle: Numbers | None = None
        self._cord: list[Numbers] = []
        self._cord_angles: list[Floats] = []
        self._flanks: dict[int, Numbers] = {}
        self._lands: dict[int, list[Numbers]] = {}
        self._faces: list[Numbers] = []

    def add(self, place: int) -> None:
        """Add the part from a place to the next one."""
        start, end = self._strip.pitch_rad * 0.5 * np.array([place + 1, place + 2])
        if place % 2:
            self._add_land((place + 1) // 2, start + self._half_land)
            self._add_foot((place + 1) // 2, end, -1)
        else:
            self._add_foot(place // 2, start, 1)
            self._add_land(place // 2 + 1, end - self._half_land[::-1])

    def mesh(self) -> BeltMesh:
        """The complete mesh."""
        nodes, turns = self._straightened(np.concatenate(self._blocks.places))
        cord, angles = _joined(self._cord), _joined(self._cord_angles)
        middles = angles[1::2]
        tight, slack = (cord[np.flatnonzero(np.abs(angles - end) < TIE)] for end in self._ends)
        return BeltMesh(
            nodes=nodes,
            turns_rad=turns,
            cells=(("quad9", np.concatenate(self._blocks.cells)),),
            cord=cord,
            flanks=self._flanks,
            lands={number: _joined(parts) for number, parts in self._lands.items()},
            left=self._faces[0],
            right=self._faces[-1],
            bars=np.flatnonzero((middles > self._ends[0]) & (middles < self._ends[1])),
            tight=tight,
            slack=slack,
        )

    def _add_land(self, number: int, breaks: Floats) -> None:
        """Add half a land; an element boundary lies where a strand begins."""
        inside = [a for a in self._ends if breaks[0] + TIE < a < breaks[-1] - TIE]
        parts = [breaks]
        for end in inside:
            size = breaks[1] - breaks[0]
            parts = [even_breaks(breaks[0], end, size), even_breaks(end, breaks[-1], size)]
        for part in parts:
            self._hold(number, 0.5 * (part[0] + part[-1]), self._add_ring(part))

    def _add_foot(self, number: int, middle: float, side: int) -> None:
        """Add half a tooth and the belt above: -1 for the half with the working flank, else 1."""
        angles = middle + (self._foot if side > 0 else -self._foot[::-1])
        under = self._add_ring(angles)
        if self._half_tooth is None:
            self._hold(number, 0.5 * (angles[0] + angles[-1]), under)
            return
        grid, known = self._half_tooth, {"top": under[::-1]}
        if side > 0:
            grid = (grid * [1.0, -1.0])[:, ::-1]
            if self._middle is not None:
                known["right"] = self._middle[::-1]
        grid = grid + np.array([0.0, middle])
        numbers = self._blocks.add(grid, known)[::-1]
        self._middle = numbers[:, 0 if side < 0 else -1]
        if side < 0 and 0 <= number < self._strip.wrapped_teeth:
            self._flanks[number] = numbers[:, -1]
        # a face in the middle of a tooth extends to its tip
        at = len(self._faces) - (1 if side < 0 else 2)
        self._faces[at] = np.concatenate([self._faces[at], self._middle[1:]])

    def _add_ring(self, breaks: Floats) -> Numbers:
        """Add a part of the strip above a land or tooth from the nodes of its lower edge."""
        angles = with_middles(breaks)
        # with columns against the rotation, a block with outward rows is right-handed
        grid = np.stack(np.meshgrid(self._rows, angles[::-1], indexing="ij"), axis=-1)
        numbers = self._blocks.add(grid, self._known)[:, ::-1]
        self._known = {"right": numbers[:, -1]}
        self._cord.append(numbers[self._cord_row])
        self._cord_angles.append(angles)
        if not self._faces:
            self._faces.append(numbers[::-1, 0])
        self._faces.append(numbers[::-1, -1])
        return np.asarray(numbers[0])

    def _hold(self, number: int, middle: float, nodes: Numbers) -> None:
        """Add nodes of a land, if it lies on the pulley."""
        if self._ends[0] < middle < self._ends[1]:
            at = number if self._strip.tooth is not None else 0
            self._lands.setdefault(at, []).append(nodes)

    def _straightened(self, polar: Floats) -> tuple[Floats, Floats]:
        """Places of nodes and angles of their frames, with straight strands."""
        radius, angle = polar.T
        turn = np.clip(angle, *self._ends)
        along = self._strip.pitch_radius_mm * (angle - turn)
        cosine, sine = np.cos(turn), np.sin(turn)
        nodes = np.column_stack([radius * cosine - along * sine, radius * sine + along * cosine])
        return nodes, turn


def _half_tooth(strip: Strip, angles: Floats, count: int) -> Floats:
    """Half a tooth from its middle to the working flank, the tip below.

    From the angles (m,) of the nodes of its foot from the middle, and the number of nodes from the
    land to the tip: radius, and angle from the middle, (count, m, 2).
    """
    tooth = strip.tooth
    assert tooth is not None
    parts, across = np.linspace(0.0, 1.0, count), angles / angles[-1]
    flank, tip = tooth.side(parts)[0], tooth.tip(0.5 * (1.0 - across))
    # if a round tip continues the flank smoothly, elements would have a corner of 180 degrees
    chord = tip[-1] + (1.0 - across)[:, None] * (tip[0] - tip[-1])
    tip = chord + TIP_BULGE * (tip - chord) if isinstance(tooth, Round) else tip
    foot = strip.land_radius_mm * np.column_stack([np.cos(angles), -np.sin(angles)])
    foot -= [strip.foot_radius_mm, 0.0]
    middle = foot[0] + parts[:, None] * (tip[0] - foot[0])
    grid = coons(
        tip, foot, middle[::-1], flank[::-1], np.stack([across] * 2), np.stack([parts] * 2)
    )
    x, y = grid[..., 0] + strip.foot_radius_mm, grid[..., 1]
    return np.stack([np.hypot(x, y), np.arctan2(y, x)], axis=-1)


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """Concatenate consecutive lines; common nodes appear once."""
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def _radii(strip: Strip, size: float) -> Floats:
    """Node rows from the land over the cord to the back."""
    inner, middle = strip.land_radius_mm, strip.pitch_radius_mm
    if strip.rows is None:
        below = even_breaks(inner, middle, size, LEAST_ROWS)
        above = even_breaks(middle, inner + strip.back_mm, size, LEAST_ROWS)
    else:
        below = np.linspace(inner, middle, strip.rows[0] + 1)
        above = np.linspace(middle, inner + strip.back_mm, strip.rows[1] + 1)
    return with_middles(np.concatenate([below, above[1:]]))
