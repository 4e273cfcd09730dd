"""A shaft on bearings: the compliance of its section at the gear, or a flexible beam in the bore.

The shaft is a round Timoshenko beam with exact elements between steps, bearings and the gear, which
adds no stiffness. A flexible shaft fills the bore over its width; the parts outside of the bore,
with their bearings, act on both ends as condensed stiffnesses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.base.read_only import KeepsReadOnly

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.scene import shaft as keys

    Extent = tuple[float, float]
    #: Axial stiffness; stiffness in a plane of bending: force/displacement, force/rotation,
    #: moment/rotation.
    Springs = tuple[float, float, float, float]

#: Decimals of positions on the shaft, mm: 1 um is the shortest length of a scene.
DECIMALS = 3
#: N/mm per N/um, and N mm/rad per N m/mrad.
PER_MM, PER_RAD = 1e3, 1e6


@dataclass(frozen=True)
class FlexibleShaft:
    """A round shaft that bends and twists in the bore of a body, which follows it.

    Attributes
    ----------
    range_mm : (float, float)
        Ends of the bore on the common axis direction z.
    radius_mm, inner_radius_mm : float
        Radius of the bore of the body, and of that of the shaft, 0 if it is solid.
    stiffness : (float, float, float, float)
        Extension E A (N), bending E I (N mm²), shear k G A (N) and torsion G I_p (N mm²) of the
        beam in the bore.
    beyond : two tuples of four floats
        Stiffness of the shaft beyond each end, with its bearings, at this end: axial (N/mm); in a
        plane of bending force per displacement (N/mm), force per rotation (N), moment per rotation
        (N mm).
    end_radii_mm : (float, float)
        Outer radius of the shaft just beyond each end; 0 if there is none.
    bearings : tuple of (z, radial, axial, tilt)
        Bearings within the width of the bore: mm, N/mm, N/mm, N mm/rad.
    axially_held : bool
        Whether a bearing resists axial forces.
    torque_end : "I", "II" or "even"
        Section at which the torque enters, whose rotation is that of the body; "even": the torque
        is distributed over the width, and the rotation is the mean.
    """

    range_mm: Extent
    radius_mm: float
    inner_radius_mm: float
    stiffness: tuple[float, float, float, float]
    beyond: tuple[Springs, Springs]
    end_radii_mm: tuple[float, float]
    bearings: tuple[tuple[float, float, float, float], ...]
    axially_held: bool
    torque_end: Literal["I", "II", "even"]


@dataclass(frozen=True, eq=False)
class Shaft(KeepsReadOnly):
    """A shaft and its bearings.

    Attributes
    ----------
    compliance : (6, 6) array
        Displacements and rotations of the section per force and moment there, mm/N, rad/N,
        rad/(N mm); symmetric, with zeros in row and column 6.
    z_mm : float
        Axial position of the section: the middle of the face width.
    bearing_loads : (B, 3, 6) array
        Force on each bearing per force and moment at the section, -, 1/mm; B = 0 for a shaft from a
        compliance.
    flexible : FlexibleShaft or None
        The shaft as a part of the elastic body, if it bends and twists under the teeth; the section
        then serves only the tilt and the bearing forces.
    """

    compliance: Floats
    z_mm: float
    bearing_loads: Floats
    flexible: FlexibleShaft | None = None


def build_shaft(table: keys.Shaft, z_mm: float) -> Shaft:
    """Shaft from its table, with the axial position of the middle of the face width, mm."""
    if table.compliance is not None:
        rows = np.array(table.compliance)
        return Shaft(0.5 * (rows + rows.T), z_mm, np.zeros((0, 3, 6)))
    beam = _Beam.of(table, [table.dimensions.gear_position_mm])
    gear, bearings = beam.node_at(table.dimensions.gear_position_mm), beam.bearings
    loads = np.zeros((2 * beam.nodes.size, 2))
    loads[[2 * gear, 2 * gear + 1], [0, 1]] = 1.0
    bent = _solved(beam.bending(), loads)
    pushed = np.zeros(beam.nodes.size)
    if beam.axial.any():  # else there is no axial force
        loads = np.zeros((beam.nodes.size, 1))
        loads[gear] = 1.0
        pushed = _solved(beam.pushing(), loads)[:, 0]
    # both planes: u_x' = theta_y, u_y' = -theta_x
    to_x, to_y = np.zeros((2, 6)), np.zeros((2, 6))
    to_x[[0, 1], [0, 4]] = 1.0
    to_y[[0, 1], [1, 3]] = 1.0, -1.0
    compliance = np.zeros((6, 6))
    own = bent[[2 * gear, 2 * gear + 1]]
    compliance += to_x.T @ own @ to_x + to_y.T @ own @ to_y
    compliance[2, 2] = pushed[gear]
    forces = np.zeros((bearings.size, 3, 6))
    forces[:, 0] = beam.radial[:, np.newaxis] * (bent[2 * bearings] @ to_x)
    forces[:, 1] = beam.radial[:, np.newaxis] * (bent[2 * bearings] @ to_y)
    forces[:, 2, 2] = beam.axial * pushed[bearings]
    return Shaft(0.5 * (compliance + compliance.T), z_mm, forces)


def flexible_shaft(
    table: keys.Shaft, middle_mm: float, range_mm: Extent, bore_diameter_mm: float
) -> FlexibleShaft:
    """The shaft in a bore, with `under_teeth = "flexible"`.

    The middle is that of the face width. Metal of the shaft outside the diameter of the bore
    belongs to the body.
    """
    assert table.torque_end is not None
    shift = middle_mm - table.dimensions.gear_position_mm
    low, high = (round(end - shift, DECIMALS) for end in range_mm)
    places, (radial, axial, tilt) = _bearings(table)
    modulus, shear_modulus = _moduli(table)
    inner = table.bore_diameter_mm or 0.0
    area, moment, sheared = _round_section(np.array(bore_diameter_mm), inner, table.poisson_ratio)
    end = round(sum(table.dimensions.lengths_mm), DECIMALS)
    return FlexibleShaft(
        range_mm=range_mm,
        radius_mm=0.5 * bore_diameter_mm,
        inner_radius_mm=0.5 * inner,
        stiffness=(
            modulus * float(area),
            modulus * float(moment),
            shear_modulus * float(sheared),
            2.0 * shear_modulus * float(moment),
        ),
        beyond=(_beyond(table, 0.0, low), _beyond(table, end, high)),
        end_radii_mm=(_radius_at(table, low, -1), _radius_at(table, high, 1)),
        bearings=tuple(
            (float(place + shift), float(one), float(two), float(three))
            for place, one, two, three in zip(places, radial, axial, tilt, strict=True)
            if low <= place <= high
        ),
        axially_held=bool(axial.any()),
        torque_end=table.torque_end,
    )


@dataclass(frozen=True)
class _Beam:
    """Beam elements between nodes (N,), with bearings (numbers of nodes) and their stiffness."""

    table: keys.Shaft
    nodes: Floats
    bearings: Numbers
    radial: Floats
    axial: Floats
    tilt: Floats

    @classmethod
    def of(cls, table: keys.Shaft, marks: Sequence[float]) -> _Beam:
        """The whole shaft, with nodes also at `marks`."""
        places, stiffness = _bearings(table)
        steps = np.concatenate([[0.0], np.cumsum(table.dimensions.lengths_mm)])
        # nodes that differ by rounding errors are one
        nodes = np.unique(np.round(np.concatenate([marks, places, steps]), DECIMALS))
        return cls(table, nodes, np.searchsorted(nodes, places), *stiffness)

    def between(self, low: float, high: float, *, without: float) -> _Beam:
        """The part between two nodes, without the bearings at the position `without`."""
        places = self.nodes[self.bearings]
        own = (places >= low) & (places <= high) & (places != without)
        nodes = self.nodes[(self.nodes >= low) & (self.nodes <= high)]
        return replace(
            self,
            nodes=nodes,
            bearings=np.searchsorted(nodes, places[own]),
            radial=self.radial[own],
            axial=self.axial[own],
            tilt=self.tilt[own],
        )

    def node_at(self, place: float) -> int:
        """Number of the node at a place."""
        return int(np.searchsorted(self.nodes, round(place, DECIMALS)))

    def _sections(self) -> tuple[Floats, Floats, Floats]:
        """Area, second moment of area and shear area of each element."""
        sizes = self.table.dimensions
        middles = 0.5 * (self.nodes[1:] + self.nodes[:-1])
        step = np.searchsorted(np.cumsum(sizes.lengths_mm)[:-1], middles)
        inner = self.table.bore_diameter_mm or 0.0
        return _round_section(np.array(sizes.diameters_mm)[step], inner, self.table.poisson_ratio)

    def bending(self) -> Floats:
        """(2 N, 2 N) Bending stiffness: displacement and rotation of each node in one plane."""
        modulus, shear_modulus = _moduli(self.table)
        stiffness = np.zeros((2 * self.nodes.size, 2 * self.nodes.size))
        _, moments, shears = self._sections()
        for e, (one, two) in enumerate(pairwise(self.nodes)):
            length, bending = two - one, modulus * moments[e]
            phi = 12.0 * bending / (shear_modulus * shears[e] * length**2)
            side, near, far = 6.0 * length, (4.0 + phi) * length**2, (2.0 - phi) * length**2
            rows = [
                [12.0, side, -12.0, side],
                [side, near, -side, far],
                [-12.0, -side, 12.0, -side],
                [side, far, -side, near],
            ]
            own = slice(2 * e, 2 * e + 4)
            stiffness[own, own] += bending / ((1.0 + phi) * length**3) * np.array(rows)
        bearings = self.bearings
        np.add.at(stiffness, (2 * bearings, 2 * bearings), self.radial)
        np.add.at(stiffness, (2 * bearings + 1, 2 * bearings + 1), self.tilt)
        return stiffness

    def pushing(self) -> Floats:
        """(N, N) Axial stiffness."""
        stiffness = np.zeros((self.nodes.size, self.nodes.size))
        areas, _, _ = self._sections()
        for e, length in enumerate(np.diff(self.nodes)):
            own = slice(e, e + 2)
            spring = self.table.young_modulus_MPa * areas[e] / length
            stiffness[own, own] += spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
        np.add.at(stiffness, (self.bearings, self.bearings), self.axial)
        return stiffness


def _bearings(table: keys.Shaft) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
    """Positions of the bearings, mm; radial, axial (N/mm) and tilting stiffness (N mm/rad)."""
    places = np.round(table.dimensions.bearing_positions_mm, DECIMALS)
    none = (0.0,) * places.size
    return places, (
        np.array(table.dimensions.radial_stiffness_N_per_um) * PER_MM,
        np.array(table.axial_stiffness_N_per_um or none) * PER_MM,
        np.array(table.tilt_stiffness_Nm_per_mrad or none) * PER_RAD,
    )


def _moduli(table: keys.Shaft) -> tuple[float, float]:
    """Young's modulus and shear modulus, MPa."""
    return table.young_modulus_MPa, table.young_modulus_MPa / (2.0 * (1.0 + table.poisson_ratio))


def _round_section(
    outer: Floats, inner: float, poisson_ratio: float
) -> tuple[Floats, Floats, Floats]:
    """Area, second moment of area and shear area (Cowper 1966) of hollow circles."""
    area = np.pi / 4.0 * (outer**2 - inner**2)
    moment = np.pi / 64.0 * (outer**4 - inner**4)
    nu, ratio = poisson_ratio, (inner / outer) ** 2
    whole = (1.0 + ratio) ** 2
    shear = 6.0 * (1.0 + nu) * whole / ((7.0 + 6.0 * nu) * whole + (20.0 + 12.0 * nu) * ratio)
    return area, moment, shear * area


def _radius_at(table: keys.Shaft, place: float, side: int) -> float:
    """Outer radius just beyond a position, towards smaller (-1) or larger z (1)."""
    ends = np.round(np.cumsum(table.dimensions.lengths_mm), DECIMALS)
    beyond = place + side * 10.0**-DECIMALS
    if not 0.0 < beyond < ends[-1]:
        return 0.0
    return 0.5 * table.dimensions.diameters_mm[int(np.searchsorted(ends, beyond))]


def _beyond(table: keys.Shaft, free: float, end: float) -> Springs:
    """Stiffness at `end` of the part of a shaft up to its free end."""
    low, high = min(free, end), max(free, end)
    beam = _Beam.of(table, [low, high]).between(low, high, without=end)
    if not beam.bearings.size:
        return 0.0, 0.0, 0.0, 0.0
    at = beam.node_at(end)
    bent = _condensed(beam.bending(), np.array([2 * at, 2 * at + 1]))
    pushed = _condensed(beam.pushing(), np.array([at]))
    return float(pushed[0, 0]), float(bent[0, 0]), float(bent[0, 1]), float(bent[1, 1])


def _condensed(stiffness: Floats, kept: Numbers) -> Floats:
    """Stiffness condensed to the unknowns `kept`; symmetric."""
    rest = np.setdiff1d(np.arange(len(stiffness)), kept)
    scaled, scale = _scaled(stiffness)
    between = scaled[np.ix_(rest, kept)]
    own = scaled[np.ix_(kept, kept)]
    found = own - between.T @ np.linalg.solve(scaled[np.ix_(rest, rest)], between)
    size = 1.0 / scale[kept]
    return np.asarray(0.5 * (found + found.T) * np.outer(size, size))


def _solved(stiffness: Floats, loads: Floats) -> Floats:
    """Displacements under loads, solved with scaled unknowns."""
    scaled, scale = _scaled(stiffness)
    return np.asarray(scale[:, np.newaxis] * np.linalg.solve(scaled, scale[:, np.newaxis] * loads))


def _scaled(stiffness: Floats) -> tuple[Floats, Floats]:
    """A stiffness scaled to a unit diagonal, and the factors."""
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    return stiffness * np.outer(scale, scale), scale
