"""Stress on the fillets of a prism: known fields on the twisted surface, limits, mirror images."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.root_fillet import root_fillets
from flankload.elasticity import sector_closure
from flankload.elasticity.axial_basis import AxialBasis, AxialRegions
from flankload.elasticity.compliance import BodyCompliance, JobOptions, flank_compliance
from flankload.elasticity.prism import Prism
from flankload.elasticity.prism.root_surface import root_surface_stress
from tests.support.plane_sectors import STEEL
from tests.support.ring_bodies import gear
from tests.support.tolerances import ROUND_OFF, SOLVER

BODY = build_involute_body(gear(), "body_1", flank_element_mm=3.0)
FILLETS = root_fillets(BODY, "body_1")
TWIST = float(np.tan(np.radians(30.0)) / 36.0)
AXIAL = AxialBasis((-7.0, 7.0), 10)
COARSE = Prism((-7.0, 7.0), degree=6, load_degree=2, cut_degree=3)
#: Polynomials of degree 10 for a turn of 13 degrees.
FITTED = 1e-9


@cache
def _found(**keys) -> BodyCompliance:
    return flank_compliance(
        BODY, JobOptions(n_modes=3, fillets=FILLETS, prism=replace(COARSE, **keys))
    )


def _root(**keys) -> np.ndarray:
    root = _found(**keys).root
    assert root is not None
    return root.response


def _turned(angle: np.ndarray) -> np.ndarray:
    c, s, o = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    return np.stack([np.stack([c, -s, o]), np.stack([s, c, o]), np.stack([o, o, o + 1.0])])


def _unknowns(gradient: np.ndarray, axial: AxialBasis, turn: float) -> np.ndarray:
    """Unknowns of the fillets' nodes in a field u = gradient x in space."""
    points, weights = np.polynomial.legendre.leggauss(30)
    low, high = axial.range_mm
    z = 0.5 * (low + high) + 0.5 * (high - low) * points
    nodes = BODY.mesh.nodes[FILLETS.on_elements.nodes]
    plane = np.broadcast_to(nodes[:, None], (len(nodes), z.size, 2))
    section = np.dstack([plane, np.broadcast_to(z, plane.shape[:2])])
    frame = _turned(turn * z)
    place = np.einsum("ijz,nzj->nzi", frame, section)
    own = np.einsum("jiz,nzj->nzi", frame, place @ gradient.T)
    values = axial.values(z) * (0.5 * (high - low) * weights)[:, None]
    return np.einsum("zk,nzc->nkc", values, own).ravel()


@pytest.mark.parametrize("twist", [0.0, TWIST, -TWIST])
def test_stress_of_even_strains_on_the_twisted_surface(twist: float) -> None:
    """Across the curves of constant s of the surface, whose metric is made in space."""
    generator = np.random.default_rng(5)
    gradient = 1e-4 * generator.normal(size=(3, 3))
    columns = root_surface_stress(FILLETS.on_elements, AXIAL, AXIAL, STEEL, twist)
    found = (columns @ _unknowns(gradient, AXIAL, twist)).reshape(-1, AXIAL.count)
    places, tangents = FILLETS.on_elements.places, FILLETS.on_elements.tangents
    strain = 0.5 * (gradient + gradient.T)
    for z in (-7.0, 1.5, 7.0):
        frame = _turned(np.array(twist * z))
        across = np.column_stack([tangents, np.zeros(len(places))]) @ frame.T
        step = 1e-5
        ends = [
            np.column_stack([places, np.zeros(len(places))]) @ _turned(np.array(twist * (z + d))).T
            + [0.0, 0.0, d]
            for d in (-step, step)
        ]
        root_line = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0], axis=1, keepdims=True)
        across -= (across * root_line).sum(axis=1, keepdims=True) * root_line
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        e_11, e_22 = (np.einsum("qi,ij,qj->q", d, strain, d) for d in (across, root_line))
        nu = STEEL.poisson_ratio
        wanted = STEEL.young_modulus_MPa / (1 - nu**2) * (e_11 + nu * e_22)
        stress = found @ AXIAL.values(np.array([z]))[0]
        np.testing.assert_allclose(stress, wanted, atol=1e-7 * np.abs(wanted).max())


def test_a_rigid_turn_stresses_nothing() -> None:
    turn = np.array([[0.0, -1.0, 0.4], [1.0, 0.0, -0.7], [-0.4, 0.7, 0.0]])
    columns = root_surface_stress(FILLETS.on_elements, AXIAL, AXIAL, STEEL, TWIST)
    moved = _unknowns(1e-4 * turn, AXIAL, TWIST)
    scale = (np.abs(columns) @ np.abs(moved)).max()
    assert np.abs(columns @ moved).max() < FITTED * scale


def test_nodes_of_wider_regions_have_the_same_stress() -> None:
    """Polynomials over a wider hub are polynomials of the same degree over the teeth."""
    nodes = FILLETS.on_elements.nodes
    bases = (AxialBasis((-9.0, 12.0), AXIAL.degree), AXIAL)
    of_node = np.ones(len(BODY.mesh.nodes), dtype=np.int64)
    of_node[nodes[::2]] = 0
    functions = AxialRegions(bases, of_node)
    gradient = 1e-4 * np.random.default_rng(6).normal(size=(3, 3))
    moved = [_unknowns(gradient, basis, TWIST).reshape(nodes.size, -1) for basis in bases]
    mixed = np.where(of_node[nodes][:, None] == 0, moved[0], moved[1])
    made = [
        root_surface_stress(FILLETS.on_elements, each, AXIAL, STEEL, TWIST)
        for each in (functions, AXIAL)
    ]
    wanted = made[1] @ moved[1].ravel()
    np.testing.assert_allclose(made[0] @ mixed.ravel(), wanted, atol=1e-6 * np.abs(wanted).max())


def test_a_twist_that_vanishes_is_none() -> None:
    straight, hardly = _root(), _root(twist=1e-13)
    np.testing.assert_allclose(hardly, straight, atol=SOLVER * np.abs(straight).max())


def test_the_other_hand_is_the_mirror_image() -> None:
    right, left = _root(twist=TWIST), _root(twist=-TWIST)
    z, modes = (-1.0) ** np.arange(7), np.tile((-1.0) ** np.arange(3), 3)
    mirrored = right * z[:, None] * modes
    np.testing.assert_allclose(left, mirrored, atol=SOLVER * np.abs(right).max())


def test_readings_do_not_change_the_compliance() -> None:
    plain = flank_compliance(BODY, JobOptions(n_modes=3, prism=replace(COARSE, twist=TWIST)))
    found = _found(twist=TWIST)
    np.testing.assert_array_equal(found.smooth, plain.smooth)
    assert plain.root is None
    assert "stress_recoveries" not in plain.job.counters
    count = FILLETS.points.arc_length_mm.size
    assert found.job.counters["stress_recoveries"] == count
    assert _root(twist=TWIST).shape == (16, count, 7, 9)
    assert found.job.workspace_bytes > plain.job.workspace_bytes


def test_no_front_is_kept_unless_stress_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sector_closure, "Recovery", None)
    assert flank_compliance(BODY, JobOptions(n_modes=2, prism=COARSE)).root is None


def test_forces_in_balance_leave_the_next_tooth_hardly_stressed() -> None:
    """The largest stress is that of the loaded tooth, and falls from tooth to tooth."""
    values = AXIAL.values(np.zeros(1))[:, :7]
    stress = np.abs(np.einsum("tqka,k->tqa", _root(), values[0])[:, :, 0]).max(axis=1)
    assert stress[0] > 2.0 * stress[1] > 0.0
    assert (np.diff(stress[1:8]) < ROUND_OFF).all()
