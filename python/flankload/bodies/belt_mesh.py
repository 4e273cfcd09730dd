"""Quadratic quadrilaterals of a timing belt around its pulley, and where it is touched and held."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.blocks import BlockMesh, coons, even_breaks, with_middles

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.belt import Strip

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Elements on the flank of a tooth; along the strip they are as long.
FLANK_ELEMENTS = 6
#: Rows of elements from the land to the cord, and from the cord to the back, at least.
LEAST_ROWS = 2


@dataclass(frozen=True)
class BeltMesh:
    """The mesh of a strip; edges and lines are nodes in order, every second one a middle.

    Attributes
    ----------
    nodes : (N, 2) array
        About the axis of the pulley, the tight end on the x axis, mm.
    cells : ((kind, (E, 9) array),)
    cord : array
        From the tight end to the slack one.
    flanks : tuple of arrays, one per tooth
        Working flanks from the land to the tip.
    lands : tuple of arrays, one more than teeth
        From the tight end on; of a belt without teeth one.
    tight_end : array
        Nodes of the face at which the belt is held.
    """

    nodes: Floats
    cells: tuple[tuple[str, Numbers], ...]
    cord: Numbers
    flanks: tuple[Numbers, ...]
    lands: tuple[Numbers, ...]
    tight_end: Numbers


def mesh_strip(strip: Strip, flank_elements: int = FLANK_ELEMENTS) -> BeltMesh:
    """Mesh of the wrapped strip, cut in the middle of a land at both ends.

    Parameters
    ----------
    strip : Strip
    flank_elements : int

    Returns
    -------
    BeltMesh
    """
    tooth = strip.tooth
    half_pitch = 0.5 * strip.pitch_rad
    height = tooth.height_mm if tooth is not None else 0.25 * strip.pitch_mm
    width = tooth.width_mm if tooth is not None else 0.5 * strip.pitch_mm
    size = height / flank_elements
    base = asin(0.5 * width / strip.land_radius_mm)
    arc = strip.land_radius_mm
    land = even_breaks(0.0, half_pitch - base, size / arc, 2)
    foot = even_breaks(-base, base, 1.2 * size / arc, 4)
    rows = _radii(strip, 1.5 * size)
    cord_row = int(np.argmin(np.abs(rows - strip.pitch_radius_mm)))
    mesh = BlockMesh()
    flanks: list[Numbers] = []
    lands: list[Numbers] = []
    cords: list[Numbers] = []
    ends: list[Numbers] = []
    known: dict[str, Numbers] = {}
    for angle in strip.tooth_angles_rad:
        blocks = []
        for breaks in (land - half_pitch, foot, land + base):
            numbers = mesh.add(_ring_part(rows, angle + with_middles(breaks)[::-1]), known)
            # columns run against the turn, so that a block is right-handed with its rows outwards
            known = {"right": numbers[:, 0]}
            blocks.append(numbers[:, ::-1])
            cords.append(numbers[cord_row, ::-1])
        before, under, after = (block[0] for block in blocks)
        if not ends:
            ends.append(blocks[0][:, 0])
            land_nodes = before
        else:
            land_nodes = np.append(land_nodes, before[1:])
        if tooth is not None:
            flanks.append(_add_tooth(mesh, strip, angle, under, flank_elements))
            lands.append(land_nodes)
            land_nodes = after
        else:
            land_nodes = np.concatenate([land_nodes, under[1:], after[1:]])
    lands.append(land_nodes)
    cord = np.concatenate([cords[0], *(part[1:] for part in cords[1:])])
    return BeltMesh(
        nodes=np.concatenate(mesh.places),
        cells=(("quad9", np.concatenate(mesh.cells)),),
        cord=cord,
        flanks=tuple(flanks),
        lands=tuple(lands),
        tight_end=ends[0],
    )


def _add_tooth(
    mesh: BlockMesh, strip: Strip, angle: float, land: Numbers, flank_elements: int
) -> Numbers:
    """Add a tooth below its part of the strip; its working flank from the land to the tip."""
    tooth = strip.tooth
    assert tooth is not None
    parts = with_middles(np.linspace(0.0, 1.0, flank_elements + 1))
    across = with_middles(np.linspace(0.0, 1.0, (land.size - 1) // 2 + 1))
    flank = tooth.side(parts)[0]
    mirror = np.array([1.0, -1.0])
    sides = [strip.placed(side[::-1], angle) for side in (flank * mirror, flank)]
    tip = strip.placed(tooth.tip(across), angle)
    top = np.concatenate(mesh.places)[land[::-1]]
    grid = coons(tip[::-1], top, sides[0], sides[1], np.stack([across] * 2), np.stack([parts] * 2))
    return mesh.add(grid, {"top": land[::-1]})[::-1, -1]


def _radii(strip: Strip, size: float) -> Floats:
    """Rows of nodes from the land over the cord to the back."""
    inner, middle = strip.land_radius_mm, strip.pitch_radius_mm
    below = even_breaks(inner, middle, size, LEAST_ROWS)
    above = even_breaks(middle, inner + strip.back_mm, size, LEAST_ROWS)
    return with_middles(np.concatenate([below, above[1:]]))


def _ring_part(radii: Floats, angles: Floats) -> Floats:
    """(n, m, 2) Places of a part of a ring."""
    way = np.column_stack([np.cos(angles), np.sin(angles)])
    return np.asarray(radii[:, None, None] * way)
