"""Fields of loaded three-dimensional bodies: compliance, equilibrium, end faces, files."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import meshio
import numpy as np
import pytest

import flankload as fl
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.root_fillet import root_fillets
from flankload.elasticity.axial_basis import AxialBasis, mode_norms_z
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.finite_elements import lame_parameters
from flankload.elasticity.loaded_body import LoadedBody, PointForces, loaded_body
from flankload.elasticity.near_field import logarithm_strength, mode_loads
from flankload.elasticity.prism import Prism, flank_surface
from flankload.elasticity.prism.flank_potential import projected_potential
from flankload.elasticity.prism.root_surface import root_surface_stress
from flankload.elasticity.recovered_ring import RecoveredRing
from flankload.elasticity.whole_body import BodyPart
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.loaded_bodies import BodyOfPair, field_bodies
from flankload.mechanisms.loaded_bodies import NodalFields, in_world, stress_in_world
from tests.support.made_up_result import made_up_result
from tests.support.plane_sectors import STEEL
from tests.support.ring_bodies import gear
from tests.support.solving import solve
from tests.support.three_dimensional import HELICAL, SMALL, tree_of
from tests.support.tolerances import CLOSURE, SOLVER

#: As in the plane: forces act on undeformed flanks.
LEVERS = 2e-3
#: The direction of a force in the middle of a slice beside those at the stations of its layer.
TURN = 1e-4
#: Stress along the root line at the ends beside that across it, times nu; measured 0.003 and 0.02.
FREE = 0.03
#: Polynomials of degree 5 for a turn of 10 degrees.
FITTED = 1e-5


@cache
def solved() -> tuple[fl.Scene, fl.Result]:
    scene = fl.Scene.from_dict(tree_of(HELICAL, SMALL))
    result = solve(scene)
    assert isinstance(result, fl.Result)
    return scene, result


@cache
def bodies() -> tuple[BodyOfPair, ...]:
    found = field_bodies(solved()[0]).values()
    return tuple(body for body in found if isinstance(body, BodyOfPair))


@cache
def fields(number: int) -> NodalFields:
    return bodies()[number].at(solved()[1], 0)


def point_force(
    tooth: int, s_mm: float, span_mm: tuple[float, float], force_N: np.ndarray
) -> PointForces:
    """A force (1, 3) on a working flank."""
    size = np.linalg.norm(force_N, axis=1)
    at = np.array([tooth]), np.array([s_mm]), np.array([span_mm])
    return PointForces(*at, force_N, size, np.zeros(1, dtype=bool))


def test_flanks_move_as_in_the_compliance_of_the_run() -> None:
    """Loads and readings are the pressure modes; the near field is that of the run."""
    body = build_involute_body(gear(), "body_1", flank_element_mm=3.0)
    prism, n_s = Prism((-7.0, 7.0), 0.01, degree=5, load_degree=1, cut_degree=3), 3
    wanted = flank_compliance(body, JobOptions(n_modes=n_s, prism=prism)).smooth.copy()
    surface = flank_surface(body, prism)
    norms = np.kron(surface.products(n_s), np.diag(mode_norms_z(14.0, 1)))
    kernel = 0.5 * logarithm_strength(STEEL, "strain")
    inverse = np.linalg.inv(norms)
    wanted[0] += inverse @ (kernel * projected_potential(surface, n_s, 1)) @ inverse
    loaded = loaded_body(body, prism=prism)
    count, tooth = len(body.mesh.nodes), 2
    in_plane = mode_loads(body.mesh, body.mode_range_mm, n_s, twist=prism.twist)
    along = AxialBasis(prism.range_mm, prism.degree).load_vectors(1)
    loads = np.einsum("ica,kb->ikcab", in_plane.reshape(count, 3, n_s), along)
    loads = loads.reshape(count, -1, wanted.shape[1])
    forces = np.zeros((count, loads.shape[1], body.teeth))
    forces[..., tooth] = loads[..., 3]
    ring = RecoveredRing.of(loaded.section, body.mesh, body.material)
    found = inverse @ np.einsum("nup,nut->pt", loads, ring.displacements(forces))
    expected = wanted @ norms[:, 3]
    for k in range(body.teeth):
        np.testing.assert_allclose(
            found[:, (tooth + k) % body.teeth], expected[k], atol=CLOSURE * np.abs(expected).max()
        )


def test_nodal_forces_are_in_equilibrium_with_torque_and_axial_force() -> None:
    _, result = solved()
    total = []
    for body in bodies():
        found = fields(body.number)
        arm = found.points_mm[:, 0] - body.number * result.drawing.center_distance_mm
        turning = arm * found.force_N[:, 1] - found.points_mm[:, 1] * found.force_N[:, 0]
        expected = result.torque_Nm * (60 / 25 if body.number else 1.0)
        assert abs(turning.sum() / 1000.0) == pytest.approx(expected, rel=LEVERS)
        total.append(found.force_N.sum(axis=0))
    np.testing.assert_allclose(total[0], -total[1], atol=TURN * np.abs(total[0]).max())
    assert total[0][2] == pytest.approx(result.axial_force_N[0], rel=LEVERS)


def test_the_work_of_the_forces_is_positive_and_below_that_of_the_torque() -> None:
    """Gaps of tip relief and crowning close under load, and the near field is missing."""
    _, result = solved()
    work = sum((part.force_N * part.displacement_mm).sum() for part in map(fields, (0, 1)))
    of_torque = 1000.0 * result.torque_Nm * result.turned_by_load_rad[0]
    assert 0.75 * of_torque < work < of_torque


def test_the_pressure_on_flank_nodes_carries_the_force() -> None:
    _, result = solved()
    loaded, part = bodies()[0].loaded, bodies()[0].loaded.parts[0]
    pressure = fields(0).contact_pressure_MPa.reshape(part.nodes.size, -1)
    spacing = part.z_mm[1] / 3.0 - part.z_mm[0] / 3.0
    levels = np.where(np.arange(part.z_mm.size) % 2, 4.0 * spacing, 2.0 * spacing)
    levels[[0, -1]] = spacing
    total = 0.0
    for tooth in range(len(loaded.numbers)):
        nodes, widths = loaded.flank_widths(tooth)
        total += float(widths @ pressure[np.searchsorted(part.nodes, nodes)] @ levels)
    assert total == pytest.approx(result.site_force_N[0].sum(), rel=1e-12)


@pytest.mark.parametrize("twist", [0.0, 0.01])
def test_roots_are_in_plane_stress_at_the_ends_and_nearly_in_plane_strain_between(
    twist: float,
) -> None:
    """E times the strain across the root line is the stress only where none acts along it."""
    body = build_involute_body(gear(), "body_1", flank_element_mm=3.0)
    loaded, axial = loaded_body(body, prism=Prism((-7.0, 7.0), twist)), AxialBasis((-7.0, 7.0), 8)
    force = np.array([[0.0, -1000.0, 0.0]])
    moved = loaded.displacements(point_force(0, 5.0, (-7.0, 7.0), force))
    fillet = root_fillets(body, "body_1").on_elements
    own, at = moved[loaded.numbers[0, fillet.nodes]].ravel(), axial.values(np.array([-7.0, 0, 7]))
    stress, strained = (
        (root_surface_stress(fillet, axial, axial, material, twist) @ own).reshape(-1, 9) @ at.T
        for material in (STEEL, replace(STEEL, poisson_ratio=0.0))
    )
    largest = stress.argmax(axis=0), np.arange(3)
    ratio = (stress / strained)[largest]
    np.testing.assert_allclose(ratio[[0, 2]], 1.0, atol=FREE)
    assert 1.05 < ratio[1] < 1.0 / (1.0 - STEEL.poisson_ratio**2)


def test_stress_follows_from_the_displacements_in_the_world() -> None:
    """An even strain of a body that is twisted and turned: the same stress everywhere."""
    body, generator = bodies()[0], np.random.default_rng(2)
    loaded, angle = body.loaded, 0.7
    gradient = 1e-4 * generator.normal(size=(3, 3))
    axial, twist = loaded.axial, loaded.section.twist
    x, weights = np.polynomial.legendre.leggauss(20)
    z = axial.range_mm[1] * x
    plane = np.broadcast_to(loaded.nodes[:, None], (len(loaded.nodes), z.size, 2))
    turns = np.broadcast_to(angle + twist * z, plane.shape[:2])
    section = np.dstack([plane, np.broadcast_to(z, turns.shape)])
    own = in_world(in_world(section, turns) @ gradient.T, -turns)
    values = axial.values(z) * (axial.range_mm[1] * weights)[:, None]
    part = loaded.parts[0]
    _, stress = loaded.fields(part, np.einsum("zk,nzc->nkc", values, own))
    turns = np.broadcast_to(angle + twist * part.z_mm, stress.shape[:2])
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress_in_world(stress, turns), -1, 0)
    strain = 0.5 * (gradient + gradient.T)
    first, second = lame_parameters(loaded.body.material, "strain")
    wanted = first * np.trace(strain) * np.eye(3) + 2.0 * second * strain
    for (i, j), found in zip(
        [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)], (xx, yy, zz, xy, yz, xz), strict=True
    ):
        np.testing.assert_allclose(found, wanted[i, j], atol=FITTED * np.abs(wanted).max())


@pytest.mark.parametrize("kind", ["quad9", "triangle6"])
def test_nodes_of_solids_are_in_the_order_of_vtk(kind: str) -> None:
    corners = {"quad9": [[0, 0], [2, 0], [2, 2], [0, 2]], "triangle6": [[0, 0], [2, 0], [0, 2]]}
    points = np.array(corners[kind], dtype=float)
    points = np.vstack([points, 0.5 * (points + np.roll(points, -1, axis=0))])
    if kind == "quad9":
        points = np.vstack([points, points.mean(axis=0)])
    cells = ((kind, np.arange(len(points))[None]),)
    basis = AxialBasis((0.0, 4.0), 3)
    z = np.linspace(0.0, 4.0, 5)
    part = BodyPart(np.arange(len(points)), cells, basis)
    ((_, solids),) = part.solids
    places = np.column_stack([np.repeat(points, 5, axis=0), np.tile(z, len(points))])[solids]
    assert len(solids) == 2
    n = len(corners[kind])
    for place in places:
        low, high = place[:n], place[n : 2 * n]
        np.testing.assert_array_equal(high - low, np.tile([0.0, 0.0, 2.0], (n, 1)))
        following = np.roll(np.arange(n), -1)
        edges = [0.5 * (side + side[following]) for side in (low, high)]
        np.testing.assert_array_equal(place[2 * n : 4 * n], np.vstack(edges))
        np.testing.assert_array_equal(place[4 * n : 5 * n], 0.5 * (low + high))
        faces = 0.5 * (edges[0] + edges[1])
        if kind == "quad9":  # at low x, high x, low y, high y, below, above, inside
            faces = np.vstack([faces[[3, 1, 0, 2]], [low.mean(0), high.mean(0), place[:8].mean(0)]])
        np.testing.assert_array_equal(place[5 * n :], faces)


def test_files_read_back(tmp_path: Path) -> None:
    _, result = solved()
    scene = fl.Scene.from_dict(tree_of(HELICAL, {**SMALL, "body_2__rigid": True}))
    said = fl.write_vtu(scene, result, tmp_path, positions=[0])
    assert said[0].startswith("body_1: 7750 nodes")
    assert said[1] == "body_2: rigid, so it has no fields"
    mesh, found = meshio.read(tmp_path / "body_1_0000.vtu"), fields(0)
    assert [block.type for block in mesh.cells] == ["hexahedron27"]
    np.testing.assert_array_equal(mesh.points, found.points_mm)
    single = np.finfo(np.float32).eps
    np.testing.assert_allclose(
        mesh.point_data["displacement_mm"], found.displacement_mm, rtol=single
    )
    np.testing.assert_allclose(mesh.point_data["stress_MPa"], found.stress_MPa, rtol=single)
    assert mesh.point_data["von_mises_MPa"].max() == pytest.approx(found.von_mises_MPa.max())
    # contacts are where the nodal forces are
    contacts = meshio.read(tmp_path / "contacts_0000.vtu")
    loads = found.force_N @ found.force_N.sum(axis=0)
    middle = (loads @ found.points_mm) / loads.sum()
    force = np.repeat(contacts.cell_data["force_N"][0], 2)
    np.testing.assert_allclose(force @ contacts.points / force.sum(), middle, atol=0.02)


def test_results_of_a_plane_scene_are_refused() -> None:
    with pytest.raises(SceneError, match="results: expected results of this scene, found those of"):
        bodies()[0].at(made_up_result(), 0)


@cache
def _webbed(twist: float) -> LoadedBody:
    body = build_involute_body(
        gear(web_width_mm=5.0, rim_thickness_mm=6.0),
        "body_1",
        flank_element_mm=3.5,
        regions=("web",),
    )
    prism = Prism((-7.0, 7.0), twist, 5, 1, regions=(("web", (-2.5, 2.5)),))
    return loaded_body(body, prism=prism)


def test_a_web_and_its_rim_move_as_one() -> None:
    loaded = _webbed(0.01)
    one, two = loaded.parts
    assert {part.z_mm[-1] for part in (one, two)} == {7.0, 2.5}
    force = np.array([[100.0, -40.0, 20.0]])
    moved = loaded.displacements(point_force(3, 4.0, (-7.0, 0.0), force))
    shared, in_one, in_two = np.intersect1d(one.nodes, two.nodes, return_indices=True)
    assert shared.size
    v, _ = loaded.fields(two, moved)
    seam = AxialBasis((-7.0, 7.0), 5, ((-2.5, 2.5),))
    own = np.einsum("jk,nkc->njc", seam.values(two.z_mm), moved[one.nodes[in_one]])
    np.testing.assert_allclose(v[in_two], own, atol=SOLVER * np.abs(v).max())
    assert np.abs(v).max() > 0


def test_a_force_on_another_tooth_moves_it_alike() -> None:
    loaded, tooth = _webbed(0.01), 3
    turn = tooth * 2 * np.pi / len(loaded.numbers)
    force = np.array([[100.0, -40.0, 20.0]])
    found = []
    for number, own in ((0, force), (tooth, in_world(force, np.array([turn])))):
        moved = loaded.displacements(point_force(number, 4.0, (-7.0, 0.0), own))
        row = moved[loaded.numbers[number]]
        found.append(in_world(row, np.full(row.shape[:2], -number * turn / tooth)))
    np.testing.assert_allclose(found[1], found[0], atol=SOLVER * np.abs(found[0]).max())
