"""A bore that is free but for its mean motion: meshed rings, a thin ring, fields of elements."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.sparse import block_array, csc_array
from scipy.sparse.linalg import splu

from flankload.base.rotation import turned
from flankload.bodies.body import Body, SectorMesh
from flankload.bodies.involute.free_bore import with_free_bore
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.finite_elements import section_stiffness, stiffness
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.loaded_body import loaded_body
from flankload.elasticity.mean_motion import bore_reactions
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.prism import Prism
from flankload.elasticity.recovered_ring import RecoveredRing
from flankload.elasticity.sector_closure import close_ring, uniform_response
from flankload.elasticity.whole_body import ring_of
from tests.support.condensed import condense
from tests.support.plain_prism import product_loads, whole_stiffness
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.plane_stiffness import plane_stiffness
from tests.support.ring_bodies import gear_body
from tests.support.tolerances import CLOSURE

#: Of the stiffness of a section, which is integrated to a higher degree than that in the plane.
QUADRATURE = 1e-5
#: Circumference of a circle from twelve parabolas.
PARABOLAS = 5e-4
AXIAL, TWIST, LOAD_DEGREE = AxialBasis((-3.0, 8.0), 2), 0.02, 1


def bordered(matrix: csc_array, loads: np.ndarray, reactions: np.ndarray) -> np.ndarray:
    """Displacements under loads where the motions that the reactions read are held."""
    whole = block_array([[matrix, reactions], [reactions.T, None]]).tocsc()
    right = np.concatenate([loads, np.zeros((reactions.shape[1], loads.shape[1]))])
    return np.asarray(splu(whole).solve(right)[: len(loads)])


def in_place(columns: np.ndarray, numbers: np.ndarray, tooth: int, count: int) -> np.ndarray:
    """Columns (N, c, …, k) of a sector on the nodes of the whole ring, turned to their tooth."""
    found = np.zeros((count, *columns.shape[1:]))
    own = columns.copy()
    angle = 2.0 * np.pi * tooth / len(numbers)
    across = np.moveaxis(own[:, :2], 1, -1)
    own[:, :2] = np.moveaxis(turned(across, angle), -1, 1)
    np.add.at(found, numbers[tooth], own)
    return found


def rigid(reactions: list[np.ndarray]) -> np.ndarray:
    """Reactions of a ring for each motion in space, from those of each sector in its frame."""
    pitch = 2.0 * np.pi / len(reactions)
    total = np.zeros_like(reactions[0])
    for tooth, columns in enumerate(reactions):
        turn = np.eye(columns.shape[-1])
        block = [[np.cos(tooth * pitch), np.sin(tooth * pitch)]]
        block += [[-block[0][1], block[0][0]]]
        for first in range(0, columns.shape[-1] - 1, 3):
            turn[first : first + 2, first : first + 2] = block
        total += columns @ turn
    return total


@pytest.mark.parametrize("teeth", [3, 4, 7])
def test_sectors_close_to_the_meshed_ring_with_a_held_mean_motion(teeth: int) -> None:
    mesh, span = ring_sector(teeth)
    mesh = with_free_bore(mesh)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    own, reactions = (
        mode_loads(mesh, span, 3),
        bore_reactions(mesh, matrix, STEEL.young_modulus_MPa),
    )
    sector, _ = condense(matrix, own, mesh, {"corner_readings": own[:, :1]}, None, reactions)
    found = close_ring(sector, teeth)
    nodes, cells, numbers = ring_of(mesh)
    size = 2 * len(nodes)

    def placed(columns: np.ndarray) -> list[np.ndarray]:
        by_node = columns.reshape(len(mesh.nodes), 2, -1)
        return [
            in_place(by_node, numbers, tooth, len(nodes)).reshape(size, -1)
            for tooth in range(teeth)
        ]

    loads = placed(own)
    moved = bordered(
        plane_stiffness(nodes, cells, STEEL, "strain"), loads[0], rigid(placed(reactions))
    )
    wanted = np.array([column.T @ moved for column in loads])
    scale = np.abs(wanted).max()
    np.testing.assert_allclose(found[:, :3], wanted, rtol=0, atol=CLOSURE * scale)
    np.testing.assert_allclose(found[:, 3], wanted[:, 0], rtol=0, atol=CLOSURE * scale)
    evenly = uniform_response(sector, teeth)
    np.testing.assert_allclose(evenly[:3], wanted.sum(axis=0), rtol=0, atol=CLOSURE * scale)


def prism_of(axial: AxialBasis, twist: float) -> Prism:
    """A prism whose cuts have the degree of its displacements."""
    return Prism(axial.range_mm, twist, axial.degree, load_degree=0, cut_degree=axial.degree)


def closed_prism(
    mesh: SectorMesh, span: tuple[float, float], axial: AxialBasis, degree: int, twist: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Loads of two modes along the profile on a sector, its reactions, and the closed ring."""
    in_plane = mode_loads(mesh, span, 2, twist=twist)
    loads = product_loads(in_plane, axial.load_vectors(degree))
    loads = loads.reshape(len(mesh.nodes), 3 * axial.count, -1)
    section = prism_of(axial, twist).section(mesh, STEEL)
    reactions = bore_reactions(mesh, section, STEEL.young_modulus_MPa)
    sector = condense_nodes(section, mesh, np.concatenate([loads, reactions], axis=2))
    return loads, reactions, close_ring(sector.with_reactions(6), mesh.teeth)


def placed_prism(mesh: SectorMesh, columns: np.ndarray) -> list[np.ndarray]:
    """Columns (N, 3 (p + 1), k) of a sector on all nodes of the ring, by tooth."""
    nodes, _, numbers = ring_of(mesh)
    by_component = columns.reshape(len(mesh.nodes), -1, 3, columns.shape[2]).swapaxes(1, 2)
    parts = [in_place(by_component, numbers, t, len(nodes)) for t in range(mesh.teeth)]
    return [part.swapaxes(1, 2).reshape(-1, columns.shape[2]) for part in parts]


@pytest.mark.parametrize("twist", [0.0, TWIST])
def test_reactions_of_a_prism_do_work_on_their_own_motion_alone(twist: float) -> None:
    """Tractions (M2) on rigid motions about the middle of the bore, in closed form."""
    mesh = with_free_bore(ring_sector(4, rows=1, columns=3)[0])
    axial = AxialBasis(AXIAL.range_mm, 8)
    width, middle = np.ptp(axial.range_mm), np.mean(axial.range_mm)
    section = prism_of(axial, twist).section(mesh, STEEL)
    reactions = rigid(placed_prism(mesh, bore_reactions(mesh, section, 1.0)))
    nodes, radius = ring_of(mesh)[0], np.hypot(*mesh.nodes[mesh.bore_edges[0, 0]])
    z = np.linspace(*axial.range_mm, 40)[:, None]
    places = np.stack([turned(nodes, twist * h) for (h,) in z])
    places = np.concatenate(
        [places, np.broadcast_to((z - middle)[..., None], places[..., :1].shape)], 2
    )
    motions = np.empty((z.size, len(nodes), 3, 6))
    for k, one in enumerate(np.eye(3)):
        motions[..., k], motions[..., 3 + k] = one, np.cross(one, places) / radius
    for own, (h,) in zip(motions, z, strict=True):
        own[:, :2] = np.moveaxis(turned(np.moveaxis(own[:, :2], 1, -1), -twist * h), -1, 1)
    fitted = np.linalg.lstsq(axial.values(z[:, 0]), motions.reshape(z.size, -1), rcond=None)[0]
    fields = fitted.reshape(axial.count, len(nodes), 3, 6).swapaxes(0, 1)
    tilt = 0.5 + width**2 / (12.0 * radius**2)
    wanted = 2.0 * np.pi * width * np.diag([1.0, 1.0, 1.0, tilt, tilt, 1.0])
    found = fields.reshape(-1, 6).T @ reactions
    np.testing.assert_allclose(found, wanted, rtol=0, atol=PARABOLAS * wanted.max())


@pytest.mark.parametrize("twist", [0.0, TWIST])
def test_prisms_close_to_the_meshed_ring_with_a_held_mean_motion(twist: float) -> None:
    mesh, span = ring_sector(4, rows=1, columns=3)
    mesh = with_free_bore(mesh)
    loads, reactions, found = closed_prism(mesh, span, AXIAL, LOAD_DEGREE, twist)
    nodes, cells, _ = ring_of(mesh)
    section = section_stiffness(nodes, cells, STEEL, twist)
    on_teeth, on_bore = placed_prism(mesh, loads), placed_prism(mesh, reactions)
    moved = bordered(whole_stiffness(section, AXIAL), on_teeth[0], rigid(on_bore))
    wanted = np.array([column.T @ moved for column in on_teeth])
    np.testing.assert_allclose(found, wanted, rtol=0, atol=CLOSURE * np.abs(wanted).max())


def diameter_change(thickness: float) -> float:
    """Growth of the diameter of a ring of mean radius 20 under two opposite unit forces, mm²/N."""
    mesh, _ = ring_sector(8, rows=2, columns=16, lobe=0.0)
    radius = np.hypot(*mesh.nodes.T)
    scale = (20.0 + thickness * ((radius - 10.0) / 20.0 - 0.5)) / radius
    mesh = with_free_bore(replace(mesh, nodes=mesh.nodes * scale[:, None]))
    middle = np.array([20.0, 0.0])
    load = np.zeros((len(mesh.nodes), 2, 1))
    load[np.linalg.norm(mesh.nodes - middle, axis=1).argmin(), 0] = 1.0
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    reactions = bore_reactions(mesh, matrix, STEEL.young_modulus_MPa)
    sector, _ = condense(matrix, load.reshape(-1, 1), mesh, reactions=reactions)
    response = close_ring(sector, 8)[:, 0, 0]
    return 2.0 * float(response[0] + response[4])


def test_a_thin_ring_bends_as_a_curved_beam() -> None:
    """0.1488 F R³/(E I) under two opposite forces, with shear and extension."""
    modulus = STEEL.young_modulus_MPa / (1.0 - STEEL.poisson_ratio**2)
    shear = STEEL.young_modulus_MPa / (2.0 * (1.0 + STEEL.poisson_ratio))
    for thickness in (1.0, 0.5):
        wanted = (np.pi / 4.0 - 2.0 / np.pi) * 20.0**3 * 12.0 / (modulus * thickness**3)
        wanted += 20.0 / thickness * (np.pi / 4.0 * (1.0 / modulus + 1.2 / shear))
        wanted -= 20.0 / thickness * 2.0 / (np.pi * modulus)
        assert diameter_change(thickness) == pytest.approx(wanted, rel=2e-3)


@cache
def thin_gear() -> Body:
    """Eight teeth on a thin rim."""
    return gear_body(8, 5.0, tip_diameter_mm=46.0, bore_diameter_mm=20.0, bore="torque")


def test_fields_of_the_elements_are_those_of_the_compliance() -> None:
    """The response of the sectors, from all nodes; the bore does not move in the mean."""
    body = thin_gear()
    mesh = body.mesh
    loads = mode_loads(mesh, body.mode_range_mm, 1)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    reactions = bore_reactions(mesh, matrix, STEEL.young_modulus_MPa)
    wanted = close_ring(condense(matrix, loads, mesh, reactions=reactions)[0], 8)[:, 0, 0]
    loaded = loaded_body(body, "strain")
    size = len(loaded.nodes)
    on_teeth, on_bore = (
        [in_place(part.reshape(-1, 2, part.shape[-1]), loaded.numbers, t, size) for t in range(8)]
        for part in (loads, reactions)
    )
    moved = loaded.solve(on_teeth[0].reshape(-1, 1, 2)).ravel()
    found = np.array([load.ravel() @ moved for load in on_teeth])
    np.testing.assert_allclose(found, wanted, rtol=0, atol=CLOSURE * np.abs(wanted).max())
    means = rigid(on_bore).reshape(moved.size, -1).T @ moved
    whole = np.abs(rigid(on_bore).reshape(moved.size, -1)).T @ np.abs(moved)
    np.testing.assert_allclose(means / whole, 0.0, atol=CLOSURE)


@pytest.mark.parametrize("twist", [0.0, TWIST])
def test_fields_of_a_prism_are_those_of_its_compliance(twist: float) -> None:
    body = thin_gear()
    prism = prism_of(AXIAL, twist)
    loads, _, wanted = closed_prism(body.mesh, body.mode_range_mm, AXIAL, 0, twist)
    forces = np.zeros((*loads.shape[:2], 8))
    forces[..., 0] = loads[..., 0]
    section = prism.section(body.mesh, body.material)
    moved = RecoveredRing.of(section, body.mesh, body.material).displacements(forces)
    found = np.einsum("nuf,nut->tf", loads, moved)
    np.testing.assert_allclose(found, wanted[:, :, 0], rtol=0, atol=CLOSURE * np.abs(wanted).max())


def test_a_prism_of_one_function_along_the_axis_is_in_plane_strain() -> None:
    body, axial = thin_gear(), AxialBasis((0.0, 5.0), 0)
    mesh = body.mesh
    loads = mode_loads(mesh, body.mode_range_mm, 2)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    reactions = bore_reactions(mesh, matrix, STEEL.young_modulus_MPa)
    plane = close_ring(condense(matrix, loads, mesh, reactions=reactions)[0], 8)
    _, _, solid = closed_prism(mesh, body.mode_range_mm, axial, 0, 0.0)
    np.testing.assert_allclose(solid, 5.0 * plane, rtol=0, atol=QUADRATURE * np.abs(solid).max())
