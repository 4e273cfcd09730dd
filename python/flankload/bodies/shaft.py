"""A shaft on bearings as a compliance of the section that carries the gear.

The shaft is a Timoshenko beam with exact elements between the places where a step, a bearing or
the gear is; it is round, so both planes of bending are alike. The gear adds no stiffness. A shaft
that bends and twists under the teeth is that of `carrying_shaft`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.read_only import KeepsReadOnly

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.carrying_shaft import CarryingShaft
    from flankload.scene import shaft as keys

    Floats = NDArray[np.float64]

#: Decimals of places on the shaft, mm: to 1 um, the shortest length of a scene.
DECIMALS = 3
#: N/mm per N/um, and N mm/rad per N m/mrad.
PER_MM, PER_RAD = 1e3, 1e6


@dataclass(frozen=True, eq=False)
class Shaft(KeepsReadOnly):
    """What the contact needs to know of a shaft and its bearings.

    Attributes
    ----------
    compliance : (6, 6) array
        Displacements and rotations of the section under forces and moments there, mm/N, rad/N,
        rad/(N mm); symmetric, zeros in row and column 6.
    z_mm : float
        Axial position of the section: the middle of the face width.
    bearing_loads : (B, 3, 6) array
        Force on each bearing per force and moment at the section, -, 1/mm; B = 0 if the shaft is
        known by its compliance only.
    carrying : CarryingShaft or None
        The shaft as a part of the elastic body, if it bends and twists under the teeth; the section
        then only serves the tilt and the forces on the bearings.
    """

    compliance: Floats
    z_mm: float
    bearing_loads: Floats
    carrying: CarryingShaft | None = None


def build_shaft(table: keys.Shaft, z_mm: float) -> Shaft:
    """Shaft from its table.

    Parameters
    ----------
    table : Shaft of the scene
    z_mm : float
        Axial position of the middle of the face width.

    Returns
    -------
    Shaft
    """
    if table.compliance is not None:
        rows = np.array(table.compliance)
        return Shaft(0.5 * (rows + rows.T), z_mm, np.zeros((0, 3, 6)))
    radial, axial, tilt = bearing_stiffness(table)
    nodes, gear, bearings = _nodes(table)
    bent = _bent(table, nodes, gear, bearings, radial, tilt)
    pushed = _pushed(table, nodes, gear, bearings, axial)
    # both planes: u_x' = theta_y, u_y' = -theta_x
    to_x, to_y = np.zeros((2, 6)), np.zeros((2, 6))
    to_x[[0, 1], [0, 4]] = 1.0
    to_y[[0, 1], [1, 3]] = 1.0, -1.0
    compliance = np.zeros((6, 6))
    own = bent[[2 * gear, 2 * gear + 1]]
    compliance += to_x.T @ own @ to_x + to_y.T @ own @ to_y
    compliance[2, 2] = pushed[gear]
    loads = np.zeros((bearings.size, 3, 6))
    loads[:, 0] = radial[:, np.newaxis] * (bent[2 * bearings] @ to_x)
    loads[:, 1] = radial[:, np.newaxis] * (bent[2 * bearings] @ to_y)
    loads[:, 2, 2] = axial * pushed[bearings]
    return Shaft(0.5 * (compliance + compliance.T), z_mm, loads)


def bearing_stiffness(table: keys.Shaft) -> tuple[Floats, Floats, Floats]:
    """Radial, axial (N/mm) and tilting stiffness (N mm/rad) of the bearings."""
    assert table.bearing_positions_mm is not None
    assert table.radial_stiffness_N_per_um is not None
    none = (0.0,) * len(table.bearing_positions_mm)
    radial, axial, tilt = (
        np.array(values) * unit
        for values, unit in (
            (table.radial_stiffness_N_per_um, PER_MM),
            (table.axial_stiffness_N_per_um or none, PER_MM),
            (table.tilt_stiffness_Nm_per_mrad or none, PER_RAD),
        )
    )
    return radial, axial, tilt


def _nodes(table: keys.Shaft) -> tuple[Floats, int, NDArray[np.int64]]:
    """Places of the nodes, and which of them carry the gear and the bearings."""
    assert table.lengths_mm is not None
    assert table.gear_position_mm is not None
    assert table.bearing_positions_mm is not None
    steps = np.concatenate([[0.0], np.cumsum(table.lengths_mm)])
    places = [table.gear_position_mm, *table.bearing_positions_mm]
    # an element of rounding errors in length would be too stiff
    rounded = np.round(np.concatenate([places, steps]), DECIMALS)
    nodes, number = np.unique(rounded, return_inverse=True)
    return nodes, int(number[0]), number[1 : len(places)]


def _sections(table: keys.Shaft, nodes: Floats) -> tuple[Floats, Floats, Floats]:
    """Area, second moment of area and shear area of the element behind each node."""
    assert table.lengths_mm is not None
    assert table.diameters_mm is not None
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    step = np.searchsorted(np.cumsum(table.lengths_mm)[:-1], middles)
    outer, inner = np.array(table.diameters_mm)[step], table.bore_diameter_mm or 0.0
    return round_section(outer, inner, table.poisson_ratio)


def round_section(
    outer: Floats, inner: float, poisson_ratio: float
) -> tuple[Floats, Floats, Floats]:
    """Area, second moment of area and shear area (Cowper 1966) between two diameters."""
    area = np.pi / 4.0 * (outer**2 - inner**2)
    moment = np.pi / 64.0 * (outer**4 - inner**4)
    nu, ratio = poisson_ratio, (inner / outer) ** 2
    whole = (1.0 + ratio) ** 2
    shear = 6.0 * (1.0 + nu) * whole / ((7.0 + 6.0 * nu) * whole + (20.0 + 12.0 * nu) * ratio)
    return area, moment, shear * area


def _bent(
    table: keys.Shaft,
    nodes: Floats,
    gear: int,
    bearings: NDArray[np.int64],
    radial: Floats,
    tilt: Floats,
) -> Floats:
    """(2 N, 2) Displacement and rotation of all nodes in one plane under a force and a moment at
    the gear.
    """
    loads = np.zeros((2 * nodes.size, 2))
    loads[[2 * gear, 2 * gear + 1], [0, 1]] = 1.0
    return _solved(bending_stiffness(table, nodes, bearings, radial, tilt), loads)


def bending_stiffness(
    table: keys.Shaft,
    nodes: Floats,
    bearings: NDArray[np.int64],
    radial: Floats,
    tilt: Floats,
) -> Floats:
    """(2 N, 2 N) Stiffness in one plane of a shaft with bearings at some of its nodes."""
    modulus = table.young_modulus_MPa
    shear_modulus = modulus / (2.0 * (1.0 + table.poisson_ratio))
    stiffness = np.zeros((2 * nodes.size, 2 * nodes.size))
    _, moments, shears = _sections(table, nodes)
    for e, (one, two) in enumerate(pairwise(nodes)):
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
    np.add.at(stiffness, (2 * bearings, 2 * bearings), radial)
    np.add.at(stiffness, (2 * bearings + 1, 2 * bearings + 1), tilt)
    return stiffness


def _pushed(
    table: keys.Shaft, nodes: Floats, gear: int, bearings: NDArray[np.int64], axial: Floats
) -> Floats:
    """(N,) Axial displacement of all nodes under a force at the gear; 0 if no bearing resists:
    there is no axial force then.
    """
    if not axial.any():
        return np.zeros(nodes.size)
    loads = np.zeros((nodes.size, 1))
    loads[gear] = 1.0
    return _solved(pushing_stiffness(table, nodes, bearings, axial), loads)[:, 0]


def pushing_stiffness(
    table: keys.Shaft, nodes: Floats, bearings: NDArray[np.int64], axial: Floats
) -> Floats:
    """(N, N) Stiffness along the axis of a shaft with bearings at some of its nodes."""
    stiffness = np.zeros((nodes.size, nodes.size))
    areas, _, _ = _sections(table, nodes)
    for e, length in enumerate(np.diff(nodes)):
        own = slice(e, e + 2)
        spring = table.young_modulus_MPa * areas[e] / length
        stiffness[own, own] += spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    np.add.at(stiffness, (bearings, bearings), axial)
    return stiffness


def _solved(stiffness: Floats, loads: Floats) -> Floats:
    """Displacements under loads; forces and moments are scaled to one size."""
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    scaled = stiffness * np.outer(scale, scale)
    return np.asarray(scale[:, np.newaxis] * np.linalg.solve(scaled, scale[:, np.newaxis] * loads))
