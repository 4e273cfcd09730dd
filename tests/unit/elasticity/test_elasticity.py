"""Elements: symmetry, rigid motions, patch test, plane strain and plane stress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import skfem
from scipy.sparse.linalg import spsolve

import flankload as fl
from flankload.cost import Account
from flankload.elasticity.finite_elements import degrees_of, stiffness
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.shape_functions import block_basis, quadrature
from flankload.meshes.plane_mesh import boundary_edges
from tests.support.condensed import condense
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.plane_stiffness import plane_stiffness
from tests.support.tolerances import ROUND_OFF, SOLVER

SECTOR, _ = ring_sector(7)


def _triangles() -> tuple[np.ndarray, np.ndarray]:
    """Quadratic triangles on a square with a shifted inner corner."""
    corners = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [0.8, 1.1]], dtype=float)
    triangles = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    nodes, middles, cells = list(corners), {}, []
    for a, b, c in triangles:
        numbers = []
        for pair in ((a, b), (b, c), (c, a)):
            key = tuple(sorted(pair))
            if key not in middles:
                middles[key] = len(nodes)
                nodes.append(0.5 * (corners[key[0]] + corners[key[1]]))
            numbers.append(middles[key])
        cells.append([a, b, c, *numbers])
    return np.array(nodes), np.array(cells)


@pytest.mark.parametrize("kind", ["quad9", "triangle6"])
def test_shape_functions_at_their_points_are_those_of_scikit_fem(kind: str) -> None:
    nodes, cells = _triangles() if kind.startswith("tri") else (SECTOR.nodes, SECTOR.cells[0][1])
    mesh_type, element = {
        "quad9": (skfem.MeshQuad2, skfem.ElementQuad2()),
        "triangle6": (skfem.MeshTri2, skfem.ElementTriP2()),
    }[kind]
    rng = np.random.default_rng(31)
    cells = cells[:, : int(kind[-1])]
    used, local = np.unique(cells, return_inverse=True)
    nodes = nodes + 0.02 * np.ptp(nodes[cells], axis=1).min() * rng.normal(size=nodes.shape)
    mesh = mesh_type(nodes[used].T.copy(), local.reshape(cells.shape).T.copy(), sort_t=False)
    theirs = skfem.Basis(mesh, element, intorder=4)
    ours = block_basis(nodes, kind, cells, 4)
    at, _ = quadrature(kind, 4)
    own = [int(np.argmin(np.abs(theirs.X - point[:, None]).sum(axis=0))) for point in at.T]
    for k, (shape,) in enumerate(theirs.basis):
        np.testing.assert_allclose(
            np.broadcast_to(ours.values[k], ours.dx.shape), shape[:, own], rtol=0, atol=ROUND_OFF
        )
        scale = np.abs(shape.grad).max()
        np.testing.assert_allclose(
            ours.slopes[k], shape.grad[..., own], rtol=0, atol=ROUND_OFF * scale
        )
    np.testing.assert_allclose(ours.dx, theirs.dx[:, own], rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(
        ours.places,
        theirs.global_coordinates()[..., own],
        rtol=0,
        atol=ROUND_OFF * np.abs(nodes).max(),
    )


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_stiffness_is_symmetric_and_knows_rigid_motions(plane: str) -> None:
    matrix = plane_stiffness(SECTOR.nodes, SECTOR.cells, STEEL, plane)
    scale = abs(matrix).max()
    assert abs(matrix - matrix.T).max() <= ROUND_OFF * scale
    x, y = SECTOR.nodes.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    for motion in ((one, zero), (zero, one), (-y, x)):
        forces = matrix @ np.stack(motion, axis=1).ravel()
        assert np.abs(forces).max() <= ROUND_OFF * scale * np.abs(motion).max()


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("shape", ["quad9", "triangle6"])
def test_patch_of_constant_strain_is_exact(shape: str, plane: str) -> None:
    """With elements of any shape, a linear displacement of the boundary is exact inside."""
    if shape == "quad9":
        nodes, cells = SECTOR.nodes, SECTOR.cells
    else:
        nodes, connectivity = _triangles()
        cells = (("triangle6", connectivity),)
    matrix = plane_stiffness(nodes, cells, STEEL, plane)
    gradient = np.array([[1e-3, 4e-4], [-2e-4, 7e-4]])
    exact = nodes @ gradient.T
    rim = degrees_of(np.unique(boundary_edges(cells)))
    inner = np.setdiff1d(np.arange(exact.size), rim)
    found = exact.ravel().copy()
    found[inner] = spsolve(matrix[inner][:, inner].tocsc(), -matrix[inner][:, rim] @ found[rim])
    np.testing.assert_allclose(found, exact.ravel(), rtol=0, atol=SOLVER * np.abs(exact).max())


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_energy_of_constant_strain_is_that_of_hooke(plane: str) -> None:
    """u K u = area * strain : stress, with the stress from Young's modulus and Poisson's ratio."""
    nodes, connectivity = _triangles()
    matrix = plane_stiffness(nodes, (("triangle6", connectivity),), STEEL, plane)
    xx, yy, shear = 1e-3, -3e-4, 5e-4
    moved = np.stack([xx * nodes[:, 0] + shear * nodes[:, 1], yy * nodes[:, 1]], axis=1).ravel()
    modulus, ratio = STEEL.young_modulus_MPa, STEEL.poisson_ratio
    if plane == "strain":
        modulus, ratio = modulus / (1 - ratio**2), ratio / (1 - ratio)
    stress_xx = modulus / (1 - ratio**2) * (xx + ratio * yy)
    stress_yy = modulus / (1 - ratio**2) * (yy + ratio * xx)
    stress_xy = modulus / (2 * (1 + ratio)) * shear
    expected = 4.0 * (stress_xx * xx + stress_yy * yy + stress_xy * shear)
    assert moved @ (matrix @ moved) == pytest.approx(expected, rel=SOLVER)


def test_pressurised_thick_ring_agrees_with_lame() -> None:
    """Radial displacement of a ring held by its symmetry alone, inner pressure 1, plane strain."""
    teeth, inner, outer = 12, 10.0, 30.0
    mesh, _ = ring_sector(teeth, rows=6, columns=4, lobe=0.0)
    matrix = plane_stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    edges = boundary_edges(mesh.cells)
    bore = edges[np.isin(edges, mesh.fixed_nodes).all(axis=1)]
    loads = np.zeros((len(mesh.nodes), 2))
    for first, last, middle in bore:
        # uniform pressure on a quadratic edge: consistent loads by Simpson's rule on n ds
        place = mesh.nodes[[first, last, middle]]
        points, weights = np.polynomial.legendre.leggauss(4)
        shape = np.stack([points * (points - 1) / 2, points * (points + 1) / 2, 1 - points**2], 1)
        slope = np.stack([points - 0.5, points + 0.5, -2 * points], 1) @ place
        out_of_hole = np.stack([slope[:, 1], -slope[:, 0]], 1)  # material on the left
        loads[[first, last, middle]] -= np.einsum("g,gk,gd->kd", weights, shape, out_of_hole)
    # symmetry: no motion across the two cuts, in coordinates turned into each cut
    size = 2 * len(mesh.nodes)
    keep = np.ones(size, dtype=bool)
    turn = np.eye(size)
    for sign, cut in ((-1, mesh.left_nodes), (1, mesh.right_nodes)):
        angle = sign * np.pi / teeth
        every = np.union1d(
            cut,
            mesh.fixed_nodes[
                np.isclose(np.arctan2(*mesh.nodes[mesh.fixed_nodes].T[::-1]), angle, atol=1e-9)
            ],
        )
        for node in every:
            block = slice(2 * node, 2 * node + 2)
            turn[block, block] = [
                [np.cos(angle), -np.sin(angle)],
                [np.sin(angle), np.cos(angle)],
            ]
            keep[2 * node + 1] = False
    reduced = turn.T @ matrix.toarray() @ turn
    found = np.zeros(size)
    found[keep] = np.linalg.solve(reduced[np.ix_(keep, keep)], (turn.T @ loads.ravel())[keep])
    moved = (turn @ found).reshape(-1, 2)
    radial = np.sum(moved * mesh.nodes, axis=1) / np.linalg.norm(mesh.nodes, axis=1)
    radius = np.linalg.norm(mesh.nodes, axis=1)
    ratio, modulus = STEEL.poisson_ratio, STEEL.young_modulus_MPa
    factor = (1 + ratio) / modulus * inner**2 / (outer**2 - inner**2)
    lame = factor * ((1 - 2 * ratio) * radius + outer**2 / radius)
    np.testing.assert_allclose(radial, lame, rtol=2e-4)


def test_condensed_is_the_dense_schur_complement() -> None:
    mesh = SECTOR
    section = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    dense = plane_stiffness(mesh.nodes, mesh.cells, STEEL, "strain").toarray()
    kept = degrees_of(np.concatenate([mesh.left_nodes, mesh.right_nodes]))
    inner = np.setdiff1d(np.arange(len(dense)), np.append(kept, degrees_of(mesh.fixed_nodes)))
    loads = np.random.default_rng(5).normal(size=(len(dense), 3))
    account = Account()
    found, unknowns = condense(section, loads, mesh, log=JobLog(account))
    assert account.counters == {"fe_factorisations": 1, "fe_solutions": 3}
    assert unknowns == inner.size + kept.size // 2
    own, across = dense[np.ix_(inner, inner)], dense[np.ix_(inner, kept)]
    moved = np.linalg.solve(own, np.hstack([loads[inner], across]))
    for part, wanted in (
        (found.local[0], loads[inner].T @ moved[:, :3]),
        (found.carried[0], loads[kept] - across.T @ moved[:, :3]),
        (found.stiffness, dense[np.ix_(kept, kept)] - across.T @ moved[:, 3:]),
    ):
        atol = 100 * ROUND_OFF * np.abs(wanted).max()
        np.testing.assert_allclose(part, wanted, rtol=0, atol=atol)


def test_a_stiffness_that_is_not_positive_is_refused_with_a_line() -> None:
    section = stiffness(SECTOR.nodes, SECTOR.cells, STEEL, "strain")
    negative = replace(section, blocks=-section.blocks)
    with pytest.raises(fl.errors.MeshError, match="not positive definite"):
        condense(negative, np.zeros((2 * len(SECTOR.nodes), 1)), SECTOR)
