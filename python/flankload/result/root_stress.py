"""Stress in the tooth roots at all positions, by superposition of pressure modes.

The pressure on a flank is expanded in the modes of the elastic solution,

    p(s) = sum_a c_a P_a(s),   c_a = 1/D_a int p P_a ds = 1/D_a sum_i P_a(s_i) F_i/width,

with the forces F_i of its contact pairs (D_a = int P_a² ds). Root stress is linear in c, summed
over all teeth in mesh. The part of the pressure that few modes omit is local to the contact and
decays towards the root. Friction along the flanks is expanded in the same way.

Largest stresses are those of bending. Friction Q per width on a contact at the distance d from the
end of the fillet adds 2 Q/(pi d) there (Flamant), which has no limit as the contact approaches.
Stress that rises towards the flank from its last minimum along the fillet is of this kind, unless
the rest of the fillet is compressed, as beside the teeth that carry.

In three dimensions the modes are products P_a(s) P_b(z), the force of a slice is even over its
width, and the stress is that across the root line of the tooth, which a helix turns, in the middle
of each slice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.blas_threads import one_blas_thread
from flankload.base.card import Card
from flankload.base.gauss import leggauss
from flankload.base.read_only import KeepsReadOnly
from flankload.contact.conforming import force_spread
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.near_field import mode_values, to_coefficients
from flankload.elasticity.nodal_loads import linear_shapes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.bodies.root_fillet import RootPoints
    from flankload.bodies.tip_modes import Tip
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.pairs import PairTable


#: Gauss points along the profile of the cell of a slice.
CELL_POINTS = 4
#: Positions whose pairs are expanded at once, which limits the memory for cells in slices.
AT_ONCE = 16


@dataclass(frozen=True, eq=False)
class RootReading:
    """Conversion of the forces on one body's flanks into stress in its roots.

    Attributes
    ----------
    points : RootPoints
        The q evaluation points of a tooth.
    n_modes : int
        Along the profile.
    response : (S, S, q, p) array; (S, S, q, d + 1, p) in three dimensions
        Root stress of the tooth at the first site, under the modes on the second; p is the number
        of modes, or twice as many if friction also loads the flanks tangentially. In three
        dimensions as in `RootResponse`.
    mode_range_mm : (float, float)
    tip : Tip or None
        End of the modes of a tip; these are included in n_modes.
    face_width_mm : float
    nodes : (n_modes,) array, optional
        Arc lengths of nodes that carry unit forces instead of modes, mm.
    over_width : OverWidth or None
        In three dimensions.
    spread : (n_modes,) array or None
        Values of the modes under the force of a slice of conforming flanks, which is distributed
        over their height.
    """

    points: RootPoints
    n_modes: int
    response: Floats
    mode_range_mm: tuple[float, float]
    tip: Tip | None
    face_width_mm: float
    nodes: Floats | None = None
    over_width: OverWidth | None = None
    spread: Floats | None = None


@dataclass(frozen=True, eq=False)
class OverWidth:
    """The slices of a three-dimensional body, and its modes along the axis.

    Attributes
    ----------
    range_mm : (float, float)
        Ends of the teeth.
    load_degree : int
        Highest degree of the modes.
    edges_mm : (J + 1,) array
        Ends of the slices, ascending.
    """

    range_mm: tuple[float, float]
    load_degree: int
    edges_mm: Floats

    @property
    def z_mm(self) -> Floats:
        """(J,) Middle of each slice."""
        return np.asarray(0.5 * (self.edges_mm[1:] + self.edges_mm[:-1]))

    def modes_at(self, z_mm: Floats) -> Floats:
        """Means (n, load_degree + 1) of the modes along the axis over the slices of places (n,)."""
        basis, edges = AxialBasis(self.range_mm, self.load_degree), self.edges_mm
        at = np.searchsorted(edges, z_mm)
        means = basis.means(np.column_stack([edges[at - 1], edges[at]]))
        # of 1 at the end of the teeth, as Legendre polynomials are
        return np.asarray(means / basis.values(np.array(self.range_mm[1:])))


@dataclass(frozen=True, eq=False, repr=False)
class Extremes(KeepsReadOnly, Card):
    """Largest stress of one sign in both fillets of a tooth, at P positions on S sites.

    Attributes
    ----------
    stress_MPa : (P, S) array
        Largest tension (positive) or largest compression (negative) in the fillets of the tooth,
        without the rise towards the flank beside a contact.
    arc_length_mm, radius_mm : (P, S) arrays
        Its place along the profile from the root circle; its distance from the axis.
    slant_deg : (P, S) array
        Angle of the fillet's tangent to the tooth's centre line there.
    working : (P, S) array of bool
        Whether the place is on the side of the working flank.
    z_mm : (P, S) array or None
        Its axial position, in the middle of a slice; None in a plane scene.
    """

    stress_MPa: Floats
    arc_length_mm: Floats
    radius_mm: Floats
    slant_deg: Floats
    working: Flags
    z_mm: Floats | None = None


@dataclass(frozen=True, eq=False, repr=False)
class RootStress(KeepsReadOnly, Card):
    """Stress along the root fillets of the teeth of one body; P positions, S sites, q points.

    Attributes
    ----------
    points : RootPoints
        The points, those of the working side first.
    stress_MPa : (P, S, q) array; (P, S, J, q) with J slices
        Stress along the fillet, positive in tension; in three dimensions across the root line,
        which is the direction of the fillet in the section normal to the tooth.
    tension, compression : Extremes
        Largest and least stress between the points, from a parabola through the nearest three; in
        three dimensions also over the slices.
    slice_tension_MPa, slice_compression_MPa : (P, S, J) arrays
        The same in each slice; J = 1 in a plane scene.
    """

    points: RootPoints
    stress_MPa: Floats
    tension: Extremes
    compression: Extremes
    slice_tension_MPa: Floats
    slice_compression_MPa: Floats


def root_reading(
    pair: BodyPair,
    compliances: tuple[BodyCompliance, BodyCompliance],
    z: int,
    sites: Numbers,
) -> RootReading | None:
    """Reading of body z + 1 at some of its sites; None if its compliance contains no stress.

    Parameters
    ----------
    sites : (S,) array
        Columns of the pairing's sites.
    """
    compliance = compliances[z]
    root, modes = compliance.root, compliance.modes
    if root is None:
        return None
    body, over_width, spread = pair.bodies[z], None, None
    n_modes = compliance.modes_along
    if pair.slices.conforming is not None:
        places = pair.slices.conforming.s_mm[z]
        values = mode_values(places, modes.range_mm, n_modes, tip=modes.tip)
        spread = force_spread(pair, compliances) @ values
    if root.range_mm is not None:
        over_width = OverWidth(root.range_mm, modes.axial.degree, pair.slices.edges_mm)
    teeth = pair.pairing.site_teeth[z][sites]
    response = root.response[compliance.block_of(teeth[:, None], teeth[None, :], body.teeth)]
    if not pair.effects.friction:  # finite forces alone have none along the flanks
        response = response[..., : compliance.smooth.shape[1]]
    return RootReading(
        points=root.points,
        n_modes=n_modes,
        response=response,
        mode_range_mm=modes.range_mm,
        tip=modes.tip,
        face_width_mm=pair.face_width_mm,
        nodes=modes.nodes,
        over_width=over_width,
        spread=spread,
    )


def root_stress(
    reading: RootReading, tables: Sequence[PairTable], sites: Numbers, z: int
) -> RootStress:
    """Stress of body z + 1 under the forces of a table per position.

    `sites` (S,): numbers of flank pairs, all loaded ones among them.
    """
    loads, over_width = loads_of_modes(reading, tables, sites, z), reading.over_width
    by_slice = stress_by_slice(reading, loads)
    z_mm = None if over_width is None else over_width.z_mm
    points = reading.points
    largest, least = (_extremes(points, by_slice, sign) for sign in (1.0, -1.0))
    return RootStress(
        points=points,
        stress_MPa=by_slice[:, :, 0] if over_width is None else by_slice,
        tension=_over_slices(largest, 1.0, z_mm),
        compression=_over_slices(least, -1.0, z_mm),
        slice_tension_MPa=largest.stress_MPa,
        slice_compression_MPa=least.stress_MPa,
    )


@one_blas_thread()
def stress_by_slice(reading: RootReading, loads: Floats) -> Floats:
    """Stress (P, S, J, q) under loads of the modes (P, S, p); J = 1 in a plane scene."""
    # of all loaded teeth (p i q …); zeros without a sign
    stress = np.tensordot(loads, reading.response, axes=((1, 2), (1, -1))) + 0.0
    if reading.over_width is None:
        return stress[:, :, None]
    basis = AxialBasis(reading.over_width.range_mm, stress.shape[3] - 1)
    values = basis.values(reading.over_width.z_mm)
    return np.asarray(np.einsum("jk,piqk->pijq", values, stress) + 0.0)


def loads_of_modes(
    reading: RootReading, tables: Sequence[PairTable], sites: Numbers, z: int
) -> Floats:
    """Loads c (P, S, p) of the modes, MPa: out of the material, then along it.

    In three dimensions the forces times the values of the modes, N. Arguments as of `root_stress`.

    Raises
    ------
    ValueError
        If a flank pair that is not among the sites carries load.
    """
    parts = [
        _loads_at(reading, tables[first : first + AT_ONCE], sites, z)
        for first in range(0, len(tables), AT_ONCE)
    ]
    return np.concatenate(parts)


def _loads_at(reading: RootReading, tables: Sequence[PairTable], sites: Numbers, z: int) -> Floats:
    """The same at a few positions."""
    loaded = [table.force_N > 0 for table in tables]

    def column(name: str) -> Any:
        parts = [getattr(table, name)[own] for table, own in zip(tables, loaded, strict=True)]
        return np.concatenate(parts)

    span, tip = reading.mode_range_mm, reading.tip
    places, force = column(f"arc_length_{z + 1}_mm"), column("force_N")
    if reading.over_width is not None:
        if reading.spread is None:
            at = places, column("cell_mm"), column("z_mm")
            values = modes_on_slices(at, span, tip, reading.n_modes, reading.over_width)
        else:
            along = reading.over_width.modes_at(column("z_mm"))
            values = np.einsum("a,nb->nab", reading.spread, along).reshape(len(along), -1)
    elif reading.nodes is not None:
        values = linear_shapes(places, reading.nodes) / reading.face_width_mm
    else:
        # beyond their range modes keep their end values
        within = np.clip(places, span[0], span[1] if tip is None else tip.end_mm)
        values = mode_values(within, span, reading.n_modes, tip=tip)
        values = to_coefficients(values.T, span, tip=tip).T / reading.face_width_mm
    # contact pushes into the material; where flanks touch, arc length grows to opposite sides, and
    # so do the forces along them
    forces = [-force]
    if reading.response.shape[-1] > values.shape[1]:
        forces.append(column("friction_force_N"))
    weighted = np.hstack([values * each[:, None] for each in forces])
    position = np.repeat(np.arange(len(tables)), [int(own.sum()) for own in loaded])
    loads = np.zeros((len(tables), sites.size, reading.response.shape[-1]))
    here = column("site")[:, None] == sites
    if not here.any(axis=1).all():
        missing = sorted(set(column("site").tolist()) - set(sites.tolist()))
        raise ValueError(f"sites: expected all loaded flank pairs, without {missing} found {sites}")
    np.add.at(loads, (position, here.argmax(axis=1)), weighted)
    return loads


def modes_on_slices(
    cells: tuple[Floats, Floats, Floats],
    span: tuple[float, float],
    tip: Tip | None,
    n_modes: int,
    over_width: OverWidth,
) -> Floats:
    """Means (n, p) of the modes over cells of slices, along the profile and the axis.

    `cells`: places (n,) along the profile, lengths (n,) there, and middles (n,) of the slices;
    `span`: range of the modes along the profile, of which there are `n_modes`.
    """
    places, lengths_mm, z_mm = cells
    points, weights = leggauss(CELL_POINTS)
    s = places[:, None] + 0.5 * lengths_mm[:, None] * points
    within = np.clip(s, span[0], span[1] if tip is None else tip.end_mm)
    values = mode_values(within.ravel(), span, n_modes, tip=tip)
    values = np.einsum("g,nga->na", 0.5 * weights, values.reshape(*s.shape, n_modes))
    along = over_width.modes_at(z_mm)
    count = values.shape[1] * along.shape[1]
    return np.asarray(np.einsum("na,nb->nab", values, along).reshape(len(values), count))


def _extremes(points: RootPoints, stress: Floats, sign: float) -> Extremes:
    """Largest of sign * stress over both sides."""
    sides, peaks = _peaks_of_sides(points, sign * stress)
    working = peaks[0][0] >= peaks[1][0]
    found, place = (np.where(working, *both) for both in zip(*peaks, strict=True))
    radius, slant = (
        np.where(working, *(np.interp(place, points.arc_length_mm[k], values[k]) for k in sides))
        for values in (points.radius_mm, points.slant_rad)
    )
    # normalise the sign of zero
    return Extremes(sign * found + 0.0, place, radius, np.degrees(slant), working)


def largest_tension(points: RootPoints, stress: Floats) -> Floats:
    """Largest stress between the points of the last axis, over both fillets."""
    _, ((one, _), (two, _)) = _peaks_of_sides(points, stress)
    return np.maximum(one, two)


def _peaks_of_sides(
    points: RootPoints, values: Floats
) -> tuple[list[Numbers], list[tuple[Floats, Floats]]]:
    """Points of both fillets, the working one first, and the maximum on each with its place."""
    sides = [np.flatnonzero(points.working), np.flatnonzero(~points.working)]
    return sides, [_peak(points.arc_length_mm[side], values[..., side]) for side in sides]


def _over_slices(found: Extremes, sign: float, z_mm: Floats | None) -> Extremes:
    """Extremes (P, S) of the slice with the largest sign * stress, from those (P, S, J)."""
    at = (sign * found.stress_MPa).argmax(axis=2)
    arrays = [
        np.take_along_axis(getattr(found, name), at[..., None], axis=2)[..., 0]
        for name in ("stress_MPa", "arc_length_mm", "radius_mm", "slant_deg", "working")
    ]
    if z_mm is not None:
        arrays.append(z_mm[at])
    return Extremes(*arrays)


def _peak(s: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Maximum along the last axis and its place, from the parabola around the largest value.

    Values that rise from their last minimum to the last place, beside the flank, do not count if
    one of the others is positive.
    """
    falls = np.diff(values, axis=-1) < 0
    beside = np.logical_and.accumulate(~falls[..., ::-1], axis=-1)[..., ::-1]
    beside &= falls.any(axis=-1, keepdims=True)
    own = values.copy()
    own[..., 1:][beside] = -np.inf
    own = np.where(own.max(axis=-1, keepdims=True) > 0, own, values)
    at = own.argmax(axis=-1)
    middle = np.clip(at, 1, s.size - 2)
    three = middle[..., None] + [-1, 0, 1]
    s_0, s_1, s_2 = np.moveaxis(s[three], -1, 0)
    v_0, v_1, v_2 = np.moveaxis(np.take_along_axis(values, three, axis=-1), -1, 0)
    left, right = (v_1 - v_0) / (s_1 - s_0), (v_2 - v_1) / (s_2 - s_1)
    bend = (right - left) / (s_2 - s_0)
    # slope of the parabola at s_1; its vertex lies between the neighbours of the largest value
    slope = left + bend * (s_1 - s_0)
    inside = (at == middle) & (bend < 0)
    shift = np.zeros_like(slope)
    np.divide(-slope, 2 * bend, out=shift, where=inside)
    largest = np.where(inside, v_1 + 0.5 * slope * shift, own.max(axis=-1))
    return largest, np.where(inside, s_1 + shift, s[at])


def root_arrays(stress: RootStress, z: int) -> dict[str, tuple[Floats, str]]:
    """Arrays (P, S) of body z + 1 by their names and with their units in files."""
    found: dict[str, tuple[Floats, str]] = {}
    for name, extremes in (("tension", stress.tension), ("compression", stress.compression)):
        key = f"root_{name}_{z + 1}"
        found[f"{key}_MPa"] = extremes.stress_MPa, "MPa"
        found[f"{key}_arc_length_mm"] = extremes.arc_length_mm, "mm"
        if extremes.z_mm is not None:
            found[f"{key}_z_mm"] = extremes.z_mm, "mm"
    return found


def slice_root_arrays(stress: RootStress, z: int) -> dict[str, tuple[Floats, str]]:
    """Arrays (P, S, J) of body z + 1 by their names and with their units in files."""
    return {
        f"slice_root_tension_{z + 1}_MPa": (stress.slice_tension_MPa, "MPa"),
        f"slice_root_compression_{z + 1}_MPa": (stress.slice_compression_MPa, "MPa"),
    }
