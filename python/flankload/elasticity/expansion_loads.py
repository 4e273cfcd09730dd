"""Loads of an expansion on finite elements, and the displacements of the flanks under them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.finite_elements import place_load
from flankload.elasticity.near_field import mode_loads, to_coefficients

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scipy.sparse import csc_array

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body, SectorMesh, WholeMesh
    from flankload.pairing.expansion import Growth


def growth_loads(
    matrix: csc_array, mesh: SectorMesh | WholeMesh, growth: Growth | None, *, lumped: bool = False
) -> dict[str, Floats]:
    """Nodal loads (2N,) of an expansion relative to the support, N per mm of width, by cause.

    The displacement is e_s x plus the response to these loads with the held surface at rest. The
    stiffness matrix (2N, 2N), per mm of width, times the coordinates of the nodes is the load of a
    strain of 1 in the plane. The body expands freely along its axis, in plane strain as well.
    """
    loads: dict[str, Floats] = {}
    if growth is None:
        return loads
    if growth.strain != growth.held_strain:
        loads["temperature"] = (growth.strain - growth.held_strain) * (matrix @ mesh.nodes.ravel())
    if growth.speed_rad_per_s > 0.0:
        pull = growth.density_Ns2_per_mm4 * growth.speed_rad_per_s**2
        loads["speed"] = pull * place_load(mesh.nodes, mesh.cells, lumped=lumped)
    return loads


def growth_of_flanks(
    body: Body, growth: Growth | None, n_modes: int, moved: Mapping[str, Floats]
) -> tuple[float, dict[str, Floats]]:
    """Uniform expansion of a body, and the displacements of its flanks beyond that.

    Displacements are known along the normal only, as gaps require; at an edge this is not enough: a
    tip that moves outwards touches its mate elsewhere. Most of the expansion of a tooth is uniform:
    the strain that fits all flanks best, by least squares, scales the whole body.

    Parameters
    ----------
    moved : mapping of str to (f, p) array
        Readings of the modes on each of f flanks under each of `growth_loads`, pressure modes
        first, mm².

    Returns
    -------
    strain : float
    shifts : dict of str to (f, n_modes) array
        Mode coefficients, mm.
    """
    if growth is None:
        return 0.0, {}
    mesh, closed = body.mesh, body.curve.closed
    if mesh is None or not moved:
        return growth.held_strain, {}
    span, tip = body.mode_range_mm, body.tip
    read = [mode_loads(flank, span, n_modes, closed=closed, tip=tip) for flank in mesh.flanks]

    def settled(moments: Floats) -> Floats:
        return to_coefficients(moments.T, span, closed=closed, tip=tip).T

    evenly = np.array([columns.T @ mesh.nodes.ravel() for columns in read])
    unit = settled(evenly)
    shifts = {name: settled(part[:, :n_modes]) for name, part in moved.items()}
    square = float(np.sum(evenly * unit))
    parts = {name: float(np.sum(evenly * shift)) / square for name, shift in shifts.items()}
    left = {name: shift - parts[name] * unit for name, shift in shifts.items()}
    return growth.held_strain + sum(parts.values()), left
