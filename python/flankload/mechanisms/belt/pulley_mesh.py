"""Mesh of quadratic quadrilaterals of one sector of a pulley, with contact boundaries.

Its tooth is a block between both flanks; below it a middle block and, under the bottoms of both
half grooves, two side blocks extend to the bore in common rows. Both halves are mirror images.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.bodies.body import SectorMesh
from flankload.bodies.involute.sector_breaks import FIRST_ROW, GROWTH
from flankload.bodies.involute.sector_mesh import inverted_element
from flankload.errors import SceneError
from flankload.mechanisms.belt.belt_mesh import FLANK_ELEMENTS
from flankload.meshes.blocks import BlockMesh, coons, even_breaks, growing_breaks, with_middles

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.mechanisms.belt.belt import ElasticPulley


MIRROR = np.array([1.0, -1.0])
#: Least number of elements between land and bore of a ring without grooves, and on a half land.
LEAST_ROWS, LEAST_LAND = 2, 2
#: Largest height of a row relative to its radius: the twist of a thick ring is proportional to
#: 1/r², and rows of 0.35 give an error of 2e-4.
ROW_RATIO = 0.2


@dataclass(frozen=True)
class PulleyMesh:
    """The mesh of a sector; lines are nodes in order, every second one a mid-side node.

    Attributes
    ----------
    sector : SectorMesh
        Sector with its land centred on the x axis.
    flank : array
        Nodes of the part that a belt's tooth touches, from the land on.
    land : array
        Nodes by ascending polar angle.
    """

    pulley: ElasticPulley
    sector: SectorMesh
    flank: Numbers
    land: Numbers


def mesh_pulley(pulley: ElasticPulley, flank_elements: int = FLANK_ELEMENTS) -> PulleyMesh:
    """Mesh of one sector, with the same number of flank elements as the belt.

    Raises SceneError if no valid mesh can be made.
    """
    size = pulley.touched_mm / flank_elements
    half = even_breaks(0.0, pulley.half_land_rad, size / pulley.land_radius_mm, LEAST_LAND)
    turns = with_middles(np.concatenate([-half[:0:-1], half]))[::-1]
    land = pulley.land_radius_mm * directions(turns)
    plain = pulley.groove is None
    mesh = _plain(pulley, land, size) if plain else _grooved(pulley, land, flank_elements, size)
    _, found = inverted_element(mesh.sector)
    if found:
        raise SceneError(
            key="body_1.bore_diameter_mm",
            expected="teeth and a rim that can be meshed in blocks",
            found=f"{found} (bore {2 * pulley.bore_radius_mm:g} mm)",
        )
    return mesh


def _plain(pulley: ElasticPulley, land: Floats, size: float) -> PulleyMesh:
    """A sector without a groove; `land` is ordered against the direction of rotation."""
    mesh = BlockMesh()
    depth = pulley.land_radius_mm - pulley.bore_radius_mm
    rows = with_middles(_rows(pulley, depth, size))[::-1]
    radii = pulley.bore_radius_mm + depth * (1.0 - rows)
    ring = mesh.add(radii[:, None, None] * land / pulley.land_radius_mm, {})
    sector = _sector(pulley, mesh, ring[0], ring[1:, -1], ring[1:, 0], ring[:0, 0])
    return PulleyMesh(pulley, sector, ring[:0, 0], ring[-1, ::-1])


def _grooved(pulley: ElasticPulley, land: Floats, flank_elements: int, size: float) -> PulleyMesh:
    """A sector with a tooth between two half grooves; `land` is ordered against the rotation."""
    mesh = BlockMesh()
    columns = np.linspace(0.0, 1.0, len(land))
    flank, touched = _flank(pulley, flank_elements, size)
    corner = flank[-1]
    angle, radius = atan2(corner[1], corner[0]), float(np.hypot(*corner))
    foot = radius * directions(angle * (1.0 - 2.0 * columns))
    up = fractions(flank[::-1])
    across, high = np.stack([columns] * 2), np.stack([up] * 2)
    sides = flank[::-1], flank[::-1] * MIRROR
    tooth = mesh.add(coons(foot, land, *sides, across, high), {})
    rows = with_middles(_rows(pulley, radius - pulley.bore_radius_mm, size))[::-1]
    shaft = corner * (1.0 - rows[:, None]) + pulley.bore_radius_mm / radius * corner * rows[:, None]
    bore = pulley.bore_radius_mm * directions(angle * (1.0 - 2.0 * columns))
    sides, high = (shaft, shaft * MIRROR), np.stack([1.0 - rows] * 2)
    middle = mesh.add(coons(bore, foot, *sides, across, high), {"top": tooth[0]})
    grid = _side_grid(pulley, shaft, rows, size)
    right = mesh.add(grid, {"right": middle[:, 0]})
    left = mesh.add(grid[:, ::-1] * MIRROR, {"left": middle[:, -1]})
    bored = np.unique(np.concatenate([right[0], middle[0], left[0]]))
    sector = _sector(pulley, mesh, bored, left[1:, -1], right[1:, 0], tooth[:, 0])
    return PulleyMesh(pulley, sector, tooth[::-1, 0][:touched], tooth[-1, ::-1])


def _flank(pulley: ElasticPulley, flank_elements: int, size: float) -> tuple[Floats, int]:
    """Points of the working flank from the land on, and the number in the contact part."""
    parts = with_middles(np.linspace(0.0, 1.0, flank_elements + 1))
    flank = pulley.flank(parts)
    if not pulley.flank_goes_on:
        return flank, parts.size
    length = float(np.hypot(*(pulley.below(np.ones(1)) - flank[-1]).T).item())
    below = with_middles(even_breaks(0.0, 1.0, size / length))
    return np.concatenate([flank, pulley.below(below)[1:]]), parts.size


def _side_grid(pulley: ElasticPulley, shaft: Floats, rows: Floats, size: float) -> Floats:
    """Places below the bottom of a half groove, from the cut to the middle block."""
    fine = pulley.bottom(np.linspace(0.0, 1.0, 33))
    length = float(np.hypot(*np.diff(fine, axis=0).T).sum())
    parts = with_middles(even_breaks(0.0, 1.0, size / length, 2))[::-1]
    top = pulley.bottom(parts)
    angles = np.arctan2(top[:, 1], top[:, 0])
    across = (angles[0] - angles) / (angles[0] - angles[-1])
    bore = pulley.bore_radius_mm * directions(angles)
    cut = bore[0] * rows[:, None] + top[0] * (1.0 - rows[:, None])
    return coons(bore, top, cut, shaft, np.stack([across] * 2), np.stack([1.0 - rows] * 2))


def _rows(pulley: ElasticPulley, depth: float, size: float) -> Floats:
    """Fractions of the distance from the foot of the tooth to the bore."""
    below = np.linspace(0.0, depth, 50)
    caps = np.stack([below, ROW_RATIO * (pulley.bore_radius_mm + depth - below)])
    rows = growing_breaks(depth, FIRST_ROW * size, GROWTH, caps)
    return rows if rows.size > LEAST_ROWS else np.linspace(0.0, 1.0, LEAST_ROWS + 1)


def _sector(
    pulley: ElasticPulley,
    mesh: BlockMesh,
    bore: Numbers,
    left: Numbers,
    right: Numbers,
    flank: Numbers,
) -> SectorMesh:
    """The mesh as a general sector, with its flank from the groove to the land."""
    nodes = np.concatenate(mesh.places)
    along = np.full(len(nodes), np.nan)
    along[flank] = _lengths(nodes[flank])[: flank.size]
    return SectorMesh(
        nodes=nodes,
        cells=(("quad9", np.concatenate(mesh.cells)),),
        flank_edges=np.stack([flank[:-2:2], flank[2::2], flank[1:-1:2]], axis=1),
        flank_arc_length=along,
        fixed_nodes=bore,
        left_nodes=left,
        right_nodes=right,
        teeth=pulley.teeth,
    )


def _lengths(places: Floats) -> Floats:
    """Lengths along a line of nodes (n, 2) from the first one, mm."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])


def fractions(places: Floats) -> Floats:
    """Fractions of the length of a line of nodes (n, 2)."""
    return np.asarray(_lengths(places) / _lengths(places)[-1])
