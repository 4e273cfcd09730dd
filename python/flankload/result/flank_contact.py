"""Contact width, place and sliding of a flank pair from its contact pairs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.read_only import KeepsReadOnly

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result.geometry import PairGeometry
    from flankload.result.pairs import PairTable


@dataclass(frozen=True, eq=False)
class FlankContacts(KeepsReadOnly):
    """Contacts at P positions on S sites; NaN if unloaded.

    Attributes
    ----------
    half_width_mm : (P, S) array
        Half the length of flank in contact; in three dimensions the largest of all slices.
    velocity_1, velocity_2 : (P, S) arrays
        Velocities of both bodies along the flank, mm per rad of position: means over the contact,
        weighted by force; also NaN if the motion is unknown.
    """

    half_width_mm: Floats
    velocity_1: Floats
    velocity_2: Floats


def flank_contacts(
    tables: Sequence[PairTable], sites: Numbers, geometry: PairGeometry | None
) -> FlankContacts:
    """Contacts of all positions, with a table each, on sites (S,)."""
    found = np.full((3, len(tables), sites.size), np.nan)
    for p, table in enumerate(tables):
        motion = pair_velocities(table, geometry, p)
        loaded = table.force_N > 0
        there = set(table.site[loaded].tolist())
        for s, site in enumerate(sites.tolist()):
            if site not in there:
                continue
            laid = table.site == site
            own = laid & loaded
            found[0, p, s] = max(_half_width(table, part) for part in _slices(table, laid))
            weight = table.force_N[own] / table.force_N[own].sum()
            found[1:, p, s] = [weight @ velocity[own] for velocity in motion]
    return FlankContacts(*found)


def _slices(table: PairTable, laid: Flags) -> list[Flags]:
    """Pairs of a site, those of each loaded slice apart."""
    if table.z_mm is None:
        return [laid]
    loaded = np.unique(table.z_mm[laid & (table.force_N > 0)])
    return [laid & (table.z_mm == z) for z in loaded]


def _half_width(table: PairTable, laid: Flags) -> float:
    """Half of the length of flank in contact at pairs beside each other, mm."""
    if table.half_width_mm is not None:
        return float(table.half_width_mm[laid & (table.force_N > 0)].sum())
    return 0.5 * loaded_length(
        table.arc_length_1_mm[laid], table.cell_mm[laid], table.force_N[laid]
    )


def pair_velocities(
    table: PairTable, geometry: PairGeometry | None, p: int
) -> tuple[Floats, Floats]:
    """Velocities of both bodies along flank 1, towards its tip, at each pair of position p.

    A body that rotates with the speed w about (c, 0) moves with w (-y, x - c). Two arrays (n,) in
    mm per rad of position, NaN without geometry.
    """
    if geometry is None:
        unknown = np.full(len(table), np.nan)
        return unknown, unknown
    x, y = table.x_mm, table.y_mm
    # the normal points to the left of the tangent
    t_x, t_y = table.normal_y, -table.normal_x
    one = geometry.speed_1[p] * (x * t_y - y * t_x)
    two = geometry.speed_2[p] * ((x - geometry.center_distance_mm) * t_y - y * t_x)
    return one, two


def loaded_length(place: Floats, cell: Floats, force: Floats) -> float:
    """Length of flank in contact, more accurate than one cell.

    The square of the pressure p decreases linearly to 0 at the end of a Hertz contact (p² = p_0² (1
    - x²/b²)); a line through the last two cells gives the end, limited to the centre of the next
    open cell. If the pressure increases towards the end (a sharp corner, a flat punch), the whole
    last cell is in contact. Several separate parts are added.

    Parameters
    ----------
    place, cell, force : (n,) arrays
        Arc length of the cells' centres, their lengths and forces.
    """
    order = np.argsort(place)
    s, d = place[order], cell[order]
    squared = (force[order] / d) ** 2
    carries = np.concatenate([[False], squared > 0, [False]])
    firsts = np.flatnonzero(carries[1:] & ~carries[:-1])
    lasts = np.flatnonzero(carries[:-1] & ~carries[1:]) - 1
    ends = zip(firsts.tolist(), lasts.tolist(), strict=True)
    return sum(
        _end(s, d, squared, last, 1) - _end(s, d, squared, first, -1) for first, last in ends
    )


def _end(s: Floats, d: Floats, squared: Floats, k: int, outwards: int) -> float:
    """End of the loaded part whose last cell is k."""
    inner, outer = k - outwards, k + outwards
    farthest = s[k] + outwards * 0.5 * d[k]
    if not 0 <= inner < s.size or squared[inner] <= squared[k]:
        return float(farthest)
    reach = abs(s[k] - s[inner]) * squared[k] / (squared[inner] - squared[k])
    if 0 <= outer < s.size:
        farthest = s[outer]
    return float(s[k] + outwards * min(reach, abs(farthest - s[k])))
