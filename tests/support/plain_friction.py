"""A plain solution of a pair with friction: as `plain_elements`, with tangential loads, too.

The direction of sliding follows from the radius: inside or outside the pitch circle of body 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import flankload as fl
from flankload.bodies import Body
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.sector_closure import close_ring
from flankload.pairing.body_pair import BodyPair
from tests.support.condensed import condense
from tests.support.plain_elements import Hats, blind_pairs, fine_bodies, nodal_unit_loads


@dataclass(frozen=True)
class RubbedHats:
    """Normal displacements under normal and under tangential loads of the shape functions."""

    normal: Hats
    tangent: Hats


def rubbed_hats(body: Body) -> RubbedHats:
    """Solve a body's sector for all its shape functions in both directions and close the ring."""
    mesh = body.mesh
    assert mesh is not None
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    loads = np.hstack([nodal_unit_loads(mesh), nodal_unit_loads(mesh, along_flank=True)])
    sector, _ = condense(matrix, loads, mesh)
    ends = np.append(mesh.flank_edges[:, 0], mesh.flank_edges[-1, 1])
    places, ring = mesh.flank_arc_length[ends], close_ring(sector, mesh.teeth)
    p = places.size
    return RubbedHats(Hats(places, ring[:, :p, :p]), Hats(places, ring[:, :p, p:]))


def solve_rubbing(
    scene: dict,
    *,
    mus: tuple[float, ...],
    element_mm: float,
    inner_mm: float,
    cell_mm: float,
    rotation_rad: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rotation (M, P), forces (M, P, S) and sites (S,) of a scene whose body 1 drives.

    One row for each of M coefficients; the expected rotations (P,) limit the cells.
    """
    pair = fine_bodies(scene, element_mm, inner_mm)
    hats = [rubbed_hats(body) for body in (pair.body_1, pair.body_2)]
    found = [
        [
            _state(scene, pair, hats, position, cell_mm, expected, mu)
            for position, expected in zip(pair.position_rad, rotation_rad, strict=True)
        ]
        for mu in mus
    ]
    rotations = np.array([[state[0] for state in row] for row in found])
    forces = np.array([[state[1] for state in row] for row in found])
    return rotations, forces, pair.pairing.sites


def _state(
    scene: dict,
    pair: BodyPair,
    hats: list[RubbedHats],
    position: float,
    cell: float,
    expected: float,
    mu: float,
) -> tuple[float, np.ndarray]:
    pairing = pair.pairing
    columns = [
        rows[:, rows[3] < 1.3 * expected]
        for site in range(pairing.sites.size)
        if (rows := blind_pairs(pair, site, position, cell)).size
    ]
    site, s_1, s_2, gap, lever_1, lever_2 = np.concatenate(columns, axis=1)
    site, lever = site.astype(int), 0.5 * (lever_1 + lever_2)
    radius = np.hypot(*pair.body_1.curve.point(s_1).T)
    ratio = pair.body_1.teeth / (pair.body_1.teeth + pair.body_2.outward * pair.body_2.teeth)
    # body 1 drives: beyond its pitch circle body 2 drags it towards its tip
    rubs = mu * np.sign(radius - pairing.center_distance_mm * abs(ratio))
    # distance of the base tangent point, for a force with lever lever_1
    torque_lever = lever_1 + rubs * np.sqrt(radius**2 - lever_1**2)
    matrix = np.zeros((site.size, site.size))
    widths = (np.full(site.size, cell), cell * lever_1 / lever_2)
    for z, (s, width) in enumerate(zip((s_1, s_2), widths, strict=True)):
        weights, teeth = hats[z].normal.weights(s, width), pairing.site_teeth[z]
        for i in np.unique(site):
            for j in np.unique(site):
                t = (teeth[i] - teeth[j]) % len(hats[z].normal.response)
                loads = weights[site == j].T
                moved = hats[z].normal.response[t] @ loads - hats[z].tangent.response[t] @ (
                    loads * rubs[site == j]
                )
                matrix[np.ix_(site == i, site == j)] += weights[site == i] @ moved
    matrix /= scene["pair"]["face_width_mm"]
    state = fl.solve_contact(
        matrix / lever[:, None],
        torque_lever,
        gap,
        1000.0 * scene["load"]["torque_Nm"],
        normal_lever_arms=lever,
    )
    return state.rotation, np.bincount(site, state.normal_forces, pairing.sites.size)
