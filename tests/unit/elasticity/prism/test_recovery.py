"""Back substitution into a sector: against all its unknowns at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.finite_elements import section_stiffness
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.recovery import Recovery
from flankload.elasticity.near_field import mode_loads
from tests.support.plain_prism import product_loads, unknowns, whole_stiffness
from tests.support.plane_sectors import STEEL
from tests.support.ring_bodies import gear_body, ring
from tests.support.tolerances import CLOSURE

AXIAL = AxialBasis((-3.0, 4.0), 3)
CUT_DEGREE = 1
#: By twist; the axis of symmetry of the ring is not that of x.
BODIES = {
    0.0: gear_body(17, 4.5),
    0.04: build_involute_body(ring(teeth=60), "body_2", flank_element_mm=3.0),
}


class Sector:
    """A condensed sector with its fronts, and its whole stiffness."""

    def __init__(self, twist: float, nodes: np.ndarray | None = None) -> None:
        body = BODIES[twist]
        mesh, span = body.mesh, body.mode_range_mm
        section = section_stiffness(mesh.nodes, mesh.cells, STEEL, twist)
        section = replace(section, functions=AXIAL, cut_degree=CUT_DEGREE)
        self.mesh, self.matrix = mesh, whole_stiffness(section, AXIAL)
        loads = mode_loads(mesh, span, 3, twist=twist)
        self.loads = product_loads(loads, AXIAL.load_vectors(2))
        self.recovery = Recovery(nodes)
        self.condensed = condense_nodes(
            section, mesh, self.by_node(self.loads), recovery=self.recovery
        )
        cut = np.concatenate([mesh.left_nodes, mesh.right_nodes])
        self.kept = unknowns(cut, AXIAL.count, CUT_DEGREE + 1)
        held = np.concatenate([cut, mesh.fixed_nodes])
        self.inner = np.setdiff1d(np.arange(len(self.loads)), unknowns(held, AXIAL.count))

    def by_node(self, columns: np.ndarray) -> np.ndarray:
        return columns.reshape(len(self.mesh.nodes), 3 * AXIAL.count, -1)


@pytest.mark.parametrize("twist", [0.0, 0.04])
def test_displacements_leave_no_residual_on_inner_unknowns(twist: float) -> None:
    sector = Sector(twist)
    generator = np.random.default_rng(3)
    forces = generator.normal(size=(len(sector.loads), 2))
    on_cuts = 1e-5 * generator.normal(size=(sector.kept.size, 2))
    kept, carried = sector.recovery.reduced(sector.by_node(forces))
    count = len(sector.mesh.nodes)
    moved = sector.recovery.displacements(kept, on_cuts, count).reshape(-1, 2)
    np.testing.assert_array_equal(moved[sector.kept], on_cuts)
    residual = sector.matrix @ moved - forces
    scale = np.abs(sector.matrix) @ np.abs(moved)
    assert np.abs(residual[sector.inner] / scale[sector.inner]).max() < CLOSURE
    # forces on the cuts
    on_them = sector.condensed.stiffness @ on_cuts - carried
    assert np.abs(residual[sector.kept] - on_them).max() < CLOSURE * np.abs(on_them).max()


@pytest.mark.parametrize("twist", [0.0, 0.04])
def test_loads_move_their_places_as_in_the_compliance(twist: float) -> None:
    sector = Sector(twist)
    kept, carried = sector.recovery.reduced(sector.by_node(sector.loads))
    wanted = sector.condensed.carried[0]
    assert np.abs(carried - wanted).max() < CLOSURE * np.abs(wanted).max()
    no_cuts = np.zeros((sector.kept.size, sector.loads.shape[1]))
    moved = sector.recovery.displacements(kept, no_cuts, len(sector.mesh.nodes))
    (local,) = sector.condensed.local
    found = sector.loads.T @ moved.reshape(sector.loads.shape)
    assert np.abs(found - local).max() < CLOSURE * np.abs(local).max()


@pytest.mark.parametrize("twist", [0.0, 0.04])
def test_few_nodes_need_few_fronts(twist: float) -> None:
    every = Sector(twist)
    nodes = every.mesh.flank_edges[:2, 2]
    cut = every.mesh.left_nodes[-1:]  # a node of a cut is one of them
    few = Sector(twist, nodes)
    assert 0 < few.recovery.bytes < 0.7 * every.recovery.bytes
    readings = np.zeros((len(every.mesh.nodes), 3 * AXIAL.count, 2))
    readings[np.append(nodes, cut)] = np.random.default_rng(4).normal(size=(3, 3 * AXIAL.count, 2))
    found, wanted = (
        each.recovery.read(
            each.condensed,
            readings,
            each.recovery.under_loads(len(readings), 0, each.loads.shape[1]),
        )
        for each in (few, every)
    )
    for parts in ("local", "carried"):
        own, other = getattr(found, parts)[1], getattr(wanted, parts)[1]
        np.testing.assert_allclose(own, other, rtol=0, atol=CLOSURE * np.abs(other).max())
    # by reciprocity, the forces of readings as loads
    kept, carried = every.recovery.reduced(readings)
    moved = every.recovery.displacements(kept, np.zeros_like(carried), len(readings))
    local = moved.reshape(-1, 2).T @ every.loads
    np.testing.assert_allclose(found.local[1], local, rtol=0, atol=CLOSURE * np.abs(local).max())
    np.testing.assert_allclose(found.carried[1], carried, atol=CLOSURE * np.abs(carried).max())
