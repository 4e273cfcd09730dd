"""A condensed prism against all its unknowns at once, the closed ring against the meshed one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from flankload.bodies.body import Body
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.condensed_sector import CondensedSector
from flankload.elasticity.finite_elements import section_stiffness, stiffness
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.dissection import dissect
from flankload.elasticity.fronts.mirror import images_of
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.sector_closure import Harmonics, close_ring
from flankload.elasticity.sector_row import open_row
from tests.support.condensed import condense
from tests.support.plain_prism import (
    full_prism_ring,
    product_loads,
    unknowns,
    whole_stiffness,
)
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.ring_bodies import gear_body, ring
from tests.support.tolerances import CLOSURE

TEETH = 5
GEAR = gear_body(17, 4.5)
#: The axis of symmetry of its sector is not that of x.
INWARDS = build_involute_body(ring(teeth=60), "body_2", flank_element_mm=3.0)
AXIAL = AxialBasis((-3.0, 4.0), 3)


def _condensed(
    mesh, span, *, twist: float, twisted: bool | None = None, cut_degree: int = 3, degree: int = 3
) -> CondensedSector:
    axial = AxialBasis(AXIAL.range_mm, degree)
    loads = product_loads(
        mode_loads(mesh, span, 3, twist=twist), axial.load_vectors(min(2, degree))
    )
    section = section_stiffness(mesh.nodes, mesh.cells, STEEL, twist)
    section = replace(section, functions=axial, cut_degree=cut_degree)
    # a twist after its blocks are made joins both halves
    section = section if twisted is None else replace(section, twist=float(twisted))
    return condense_nodes(section, mesh, loads.reshape(len(mesh.nodes), 3 * axial.count, -1))


def _same(found: CondensedSector, expected: CondensedSector, part: float) -> None:
    for one, two in zip(
        (*found.local, *found.carried, found.stiffness),
        (*expected.local, *expected.carried, expected.stiffness),
        strict=True,
    ):
        np.testing.assert_allclose(one, two, rtol=0, atol=part * np.abs(two).max())


@pytest.mark.parametrize("body", [GEAR, INWARDS], ids=["outwards", "inwards"])
@pytest.mark.parametrize(("twist", "cut_degree"), [(0.0, 1), (0.04, 3)])
def test_it_is_the_schur_complement_of_the_whole_matrix(
    body: Body, twist: float, cut_degree: int
) -> None:
    mesh, span = body.mesh, body.mode_range_mm
    section = section_stiffness(mesh.nodes, mesh.cells, STEEL, twist)
    matrix = whole_stiffness(section, AXIAL)
    loads = product_loads(mode_loads(mesh, span, 3, twist=twist), AXIAL.load_vectors(2))
    # and a force on every node, those of the cuts too
    loads = np.hstack([loads, np.random.default_rng(7).normal(size=(len(loads), 1))])
    cuts = np.concatenate([mesh.left_nodes, mesh.right_nodes])
    kept = unknowns(cuts, AXIAL.count, cut_degree + 1)
    held = np.union1d(unknowns(mesh.fixed_nodes, AXIAL.count), unknowns(cuts, AXIAL.count))
    inner = np.setdiff1d(np.arange(matrix.shape[0]), held)
    coupling = matrix[inner][:, kept].toarray()
    moved = splu(matrix[inner][:, inner].tocsc()).solve(np.hstack([loads[inner], coupling]))
    by_loads, by_cuts = np.split(moved, [loads.shape[1]], axis=1)
    expected = CondensedSector(
        local=(loads[inner].T @ by_loads,),
        carried=(loads[kept] - coupling.T @ by_loads,),
        stiffness=matrix[kept][:, kept].toarray() - coupling.T @ by_cuts,
        components=3,
    )
    section = replace(section, functions=AXIAL, cut_degree=cut_degree)
    found = condense_nodes(section, mesh, loads.reshape(len(mesh.nodes), 3 * AXIAL.count, -1))
    _same(found, expected, CLOSURE)


@pytest.mark.parametrize("twist", [0.0, 0.04])
def test_closed_ring_of_prisms_equals_the_meshed_ring(twist: float) -> None:
    mesh, span = ring_sector(TEETH, rows=2, columns=4)
    found = close_ring(_condensed(mesh, span, twist=twist), TEETH)
    expected = full_prism_ring(mesh, span, 3, AXIAL, twist=twist, load_degree=2)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()
    # cuts that follow lower degrees are stiffer, and little
    fewer = close_ring(_condensed(mesh, span, twist=twist, cut_degree=1), TEETH)
    assert 1e-6 < (expected - fewer)[0, 0, 0] / expected[0, 0, 0] < 0.05


@pytest.mark.parametrize("sectors", [1, 3])
def test_open_row_of_prisms_equals_the_meshed_row(sectors: int) -> None:
    mesh, span = ring_sector(TEETH, rows=2, columns=4)
    sector = _condensed(mesh, span, twist=0.04)
    found = open_row(sector, sectors, 2.0 * np.pi / TEETH)[:, 0]
    expected = full_prism_ring(mesh, span, 3, AXIAL, twist=0.04, load_degree=2, sectors=sectors)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


def test_the_two_halves_of_a_straight_prism_are_the_whole() -> None:
    mesh, span = ring_sector(TEETH, rows=2, columns=4)
    halves = _condensed(mesh, span, twist=0.0, twisted=False)
    _same(halves, _condensed(mesh, span, twist=0.0, twisted=True), CLOSURE)


def test_a_prism_that_cannot_bend_or_stretch_is_in_plane_strain() -> None:
    mesh, span = ring_sector(TEETH, rows=2, columns=4)
    found = close_ring(_condensed(mesh, span, twist=0.0, cut_degree=0, degree=0), TEETH)
    plane = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(plane, mode_loads(mesh, span, 3), mesh)
    expected = AXIAL.width_mm * close_ring(sector, TEETH)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


def test_only_sectors_of_mirror_images_are_halved() -> None:
    mesh = GEAR.mesh
    inner = np.ones(len(mesh.nodes), dtype=bool)
    images = images_of(mesh, inner)
    assert images is not None
    own = np.arange(len(images))
    first = (images >= 0) & (images != own)
    assert 2 * first.sum() + (images == own).sum() == len(images)
    np.testing.assert_allclose(
        mesh.nodes[images[first]], mesh.nodes[first] * [1.0, -1.0], rtol=0, atol=1e-12
    )
    moved = mesh.nodes.copy()
    moved[np.flatnonzero(first)[0], 0] += 1e-9
    assert images_of(replace(mesh, nodes=moved), inner) is None
    one_held = inner.copy()
    one_held[np.flatnonzero(first)[0]] = False
    assert images_of(mesh, one_held) is None
    ((kind, cells),) = mesh.cells
    assert images_of(replace(mesh, cells=((kind, cells[1:]),)), inner) is None


def test_every_inner_node_is_eliminated_once_and_fronts_stay_small() -> None:
    body = gear_body(16, 1.0)
    mesh = body.mesh
    kept = np.concatenate([mesh.left_nodes, mesh.right_nodes])
    inner = np.ones(len(mesh.nodes), dtype=bool)
    inner[kept] = inner[mesh.fixed_nodes] = False
    cells = [cells for _, cells in mesh.cells]
    order = dissect(mesh.nodes, cells, inner=inner, kept=kept, unknowns=6)
    fronts, position = order.fronts, order.position
    own = np.concatenate([front.own for front in fronts])
    assert np.array_equal(np.sort(own), np.flatnonzero(inner))
    assert np.array_equal(position[own], np.arange(own.size))
    assert np.array_equal(np.argsort(position)[-kept.size :], kept)
    assert np.isin(fronts[-1].rest, kept).all()
    assert max(front.own.size for front in fronts) < 0.06 * own.size


@pytest.mark.parametrize("body", [GEAR, INWARDS])
@pytest.mark.parametrize("twist", [0.0, 0.04])
def test_harmonics_of_a_symmetric_sector_are_real(body: Body, twist: float) -> None:
    """Solutions of the real equations are those of the complex ones, for any right sides."""
    mesh = body.mesh
    assert mesh is not None
    sector = _condensed(mesh, body.mode_range_mm, twist=twist)
    assert sector.line is not None
    ring = Harmonics(sector, body.teeth)
    rng = np.random.default_rng(5)
    size = len(sector.stiffness) // 2
    right = rng.normal(size=(size, 3)) + 1j * rng.normal(size=(size, 3))
    for k in (0, 1, 2, body.teeth // 2):
        found, wanted = ring.solved(k, right), np.linalg.solve(ring.system(k), right)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=CLOSURE * np.abs(wanted).max())
