"""An elastic pulley against a thick ring, whole meshes, statics and a rigid one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.sparse import block_array, block_diag, csc_array, hstack
from scipy.sparse.linalg import spsolve

from flankload.bodies.body import Material
from flankload.elasticity.finite_elements import degrees_of
from flankload.mechanisms.belt.belt import ElasticPulley, Round, Strip, Trapezoid
from flankload.mechanisms.belt.belt_mesh import mesh_strip
from flankload.mechanisms.belt.columns import flank_columns, land_columns
from flankload.mechanisms.belt.contact import solve_belt, spring_row
from flankload.mechanisms.belt.pulley_compliance import (
    PulleyResponse,
    land_forces,
    on_elastic_pulley,
    pulley_compliance,
    solve_pulley,
    touches_of,
    unit_forces,
)
from flankload.mechanisms.belt.pulley_mesh import mesh_pulley
from flankload.mechanisms.belt.row import BeltRow, StripResponse, strand_ends
from flankload.mechanisms.belt.strip import Kind, cord_stiffness
from flankload.meshes.plane_mesh import jacobians
from tests.support.belts import (
    CORD,
    FORCE,
    HTD,
    ROW,
    ROW_AT_THE_EDGE,
    T10,
    TAUT,
    longer,
    response,
    shares,
    solved_springs,
)
from tests.support.plane_stiffness import of_bars, plane_stiffness
from tests.support.tolerances import SOLVER

PLASTIC, STEEL = Material(3000.0, 0.35), Material(206e3, 0.3)
#: Of symmetry.
SYMMETRIC = 1e-12
#: Of quadratic elements against a closed form; their rows are long at the bore.
ELEMENTS = 5e-5
#: Of the way of the pulley by the row of springs.
ROW_WAY = 0.005


def pulley_of(
    strip: Strip, material: Material = PLASTIC, bore: float = 10.0, plane: str = "strain"
) -> ElasticPulley:
    groove = strip.groove or strip.tooth
    return ElasticPulley(
        teeth=strip.pulley_teeth,
        land_radius_mm=strip.land_radius_mm,
        groove=groove,
        touched_mm=strip.tooth.height_mm if strip.tooth is not None else 2.5,
        depth_mm=groove.height_mm if groove is not None else 0.0,
        bore_radius_mm=bore,
        material=material,
        plane=plane,
    )


@cache
def known(
    strip: Strip, material: Material = PLASTIC, elements: int = 6, bore: float = 10.0
) -> PulleyResponse:
    pulley = pulley_of(strip, material, bore)
    return solve_pulley(mesh_pulley(pulley, elements), sliding=True)


@cache
def held(strip: Strip, elements: int, phase: float) -> StripResponse:
    return BeltRow(strip, elements, sliding=True, lifting=True).at(phase)


@cache
def resting(
    strip: Strip = T10, material: Material = PLASTIC, elements: int = 6, phase: float = 0.0
) -> StripResponse:
    pulley = known(replace(strip, prestress_N_per_mm=0.0), material, elements)
    return on_elastic_pulley(held(strip, elements, phase), strip, pulley)


# --- the pulley -----------------------------------------------------------------------------------
@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_ring_without_grooves_is_a_thick_ring(plane: str) -> None:
    """Held at a; under a pressure at b u = A (r - a²/r), under a shear v = B r (1/a² - 1/r²)."""
    ring = pulley_of(replace(T10, tooth=None), plane=plane)
    found = solve_pulley(mesh_pulley(ring, 6), sliding=True)
    inner, outer = ring.bore_radius_mm, ring.land_radius_mm
    modulus, nu = ring.material.young_modulus_MPa, ring.material.poisson_ratio
    shear = modulus / (2 * (1 + nu))
    bulk = modulus / (2 * (1 + nu) * (1 - 2 * nu)) if plane == "strain" else modulus / (1 - nu) / 2
    ends = np.linspace(-ring.half_land_rad, ring.half_land_rad, 9)
    own, along = land_forces(found.mesh, ends, rows_of(found))
    # shape functions that carry a pressure, or a shear, of 1
    step = outer * (ends[1] - ends[0])
    weights = step * np.concatenate([[0.5], np.ones(7), [0.5]])
    together = found.response.sum(axis=0)
    sunk = own.T @ together @ own @ weights
    slope = 1.0 / (2 * bulk + 2 * shear * inner**2 / outer**2)
    expected = slope * (outer - inner**2 / outer)
    np.testing.assert_allclose(sunk, expected, rtol=ELEMENTS, atol=0.0)
    turned = along.T @ together @ along @ weights
    expected = outer**3 / (2 * shear) * (1 / inner**2 - 1 / outer**2)
    np.testing.assert_allclose(turned, expected, rtol=ELEMENTS, atol=0.0)


SMALL = replace(T10, pulley_teeth=10, wrapped_teeth=4)


def whole_pulley(pulley: ElasticPulley, elements: int) -> tuple[np.ndarray, csc_array, np.ndarray]:
    """Nodes of each sector among those of the whole body, its stiffness, nodes of the bore."""
    sector = mesh_pulley(pulley, elements).sector
    turns = 2 * np.pi / pulley.teeth * np.arange(pulley.teeth)
    ways = np.stack([np.cos(turns), np.sin(turns), -np.sin(turns), np.cos(turns)], 1)
    places = (sector.nodes @ ways.reshape(-1, 2, 2)).reshape(-1, 2)
    _, first, number = np.unique(
        np.round(places, 7) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    number = number.reshape(pulley.teeth, -1)
    cells = np.concatenate([own[sector.cells[0][1]] for own in number])
    matrix = plane_stiffness(places[first], (("quad9", cells),), pulley.material, pulley.plane)
    return number, matrix, np.unique(number[:, sector.fixed_nodes])


def whole_forces(found: PulleyResponse, strip: Strip, elements: int, number: np.ndarray, phase=0.0):
    """(2N, count) Nodal forces of all shape functions on the whole pulley, in x and y."""
    touches, count = touches_of(strip, held(strip, elements, phase), found.mesh, rows_of(found))
    nodal = unit_forces(found.mesh, sliding=True)
    forces = np.zeros((2 * (number.max() + 1), count))
    for touch in touches:
        turn = 2 * np.pi / strip.pulley_teeth * touch.sector
        c, s = np.cos(turn), np.sin(turn)
        x, y = (nodal @ touch.forces)[::2], (nodal @ touch.forces)[1::2]
        at = number[touch.sector % strip.pulley_teeth]
        np.add.at(forces, (2 * at[:, None], touch.numbers[None]), c * x - s * y)
        np.add.at(forces, (2 * at[:, None] + 1, touch.numbers[None]), s * x + c * y)
    return forces


def rows_of(found: PulleyResponse) -> int:
    return int(found.response.shape[1])


@pytest.mark.parametrize("strip", [SMALL, replace(SMALL, wrapped_teeth=9)])
def test_ring_of_sectors_is_the_whole_pulley(strip: Strip) -> None:
    """Under forces at any places, also on almost all teeth."""
    found = known(strip, elements=2)
    touches, count = touches_of(strip, held(strip, 2, 0.0), found.mesh, rows_of(found))
    closed = pulley_compliance(found, touches, count)
    number, matrix, bore = whole_pulley(found.mesh.pulley, 2)
    forces = whole_forces(found, strip, 2, number)
    free = np.setdiff1d(np.arange(matrix.shape[0]), degrees_of(bore))
    moved = spsolve(matrix[free][:, free].tocsc(), csc_array(forces[free])).toarray()
    scale = np.abs(closed).max()
    np.testing.assert_allclose(closed, forces[free].T @ moved, rtol=0.0, atol=SOLVER * scale)


def test_compliance_of_the_pulley_is_symmetric_before_it_is_made_so() -> None:
    found = known(SMALL, elements=2)
    touches, _ = touches_of(SMALL, held(SMALL, 2, 0.0), found.mesh, rows_of(found))
    for one in touches:
        for two in touches:
            apart = (one.sector - two.sector) % found.mesh.pulley.teeth
            there = one.forces.T @ found.response[apart] @ two.forces
            back = two.forces.T @ found.response[-apart] @ one.forces
            scale = np.abs(found.response).max()
            np.testing.assert_allclose(there, back.T, rtol=0.0, atol=SYMMETRIC * scale)


def test_shape_functions_are_exact_for_linear_fields() -> None:
    """Displacements by shape functions follow an inclined land at any angle."""
    found = known(T10)
    nodes = found.mesh.sector.nodes[found.mesh.land]
    angles = np.arctan2(nodes[:, 1], nodes[:, 0])
    ends = np.array([-0.047, -0.03, -0.0123, 0.0, 0.004, 0.031])
    own, along = land_forces(found.mesh, ends, rows_of(found))
    first = 2 * found.mesh.flank.size
    lean = own[first : first + angles.size].T @ (3.0 + 50.0 * angles)
    np.testing.assert_allclose(lean, 3.0 + 50.0 * ends, rtol=1e-10, atol=0.0)
    np.testing.assert_allclose(along.sum(axis=0), 1.0, rtol=1e-12, atol=0.0)


# --- the belt on it -------------------------------------------------------------------------------
def monolith(
    strip: Strip,
    elements: int,
    slack: float,
    active: np.ndarray,
    *,
    phase: float = 0.0,
    friction: float = 0.0,
) -> tuple[np.ndarray, float, tuple[float, float]]:
    """Belt and whole pulley as one system of equations, these pairs in contact.

    Flanks meet at their pairs, lands follow each other by their shape functions.

    Returns
    -------
    forces of the pairs, rotation, and twice the energy by the elements and by the slack strand
    """
    on = phase * strip.pitch_rad
    mesh = mesh_strip(strip, elements, ends_rad=strand_ends(strip, elements, on))
    found = known(strip, elements=elements)
    number, matrix, bore = whole_pulley(found.mesh.pulley, elements)
    forces = whole_forces(found, strip, elements, number, phase)
    free = np.setdiff1d(np.arange(matrix.shape[0]), degrees_of(bore))
    pulley, forces = matrix[free][:, free], forces[free]
    lands = land_columns(mesh)
    frames = polar(mesh.turns_rad)
    moves = np.eye(frames.shape[0])
    moves[lands.degrees] = lands.moved
    basis = (frames @ csc_array(moves)).tocsc()
    solid = plane_stiffness(mesh.nodes, mesh.cells, strip.material, "strain")
    belt = basis.T @ (solid + of_bars(*cord_stiffness(strip, mesh), len(mesh.nodes))) @ basis
    flanks, columns = flank_columns(strip, mesh)
    columns, lever = (basis.T @ columns)[:, active], flanks.levers_mm[active]
    n, h, k = flanks.tooth.size, lands.number.size, active.size
    kept = np.setdiff1d(np.arange(belt.shape[0]), 2 * mesh.tight + 1)
    pull = np.zeros(belt.shape[0])
    pull[2 * mesh.slack + 1] = slack
    ways = lands.degrees
    tie_belt = csc_array(
        (np.ones(ways.size), (np.arange(ways.size), ways)), (ways.size, belt.shape[0])
    )[:, kept]
    tie_pulley = forces[:, n : n + h].T
    belt, columns, pull = belt[kept][:, kept], columns[kept], pull[kept]
    body = block_diag([belt, pulley]).tocsc()
    meets = csc_array(np.vstack([columns, forces[:, active]]))
    tie = hstack([tie_belt, csc_array(tie_pulley)]).tocsc()
    # lands push the belt outwards by N, and along the turn
    pushes, turned = -tie.T, np.zeros(ways.size)
    if friction:
        along = np.vstack([lands.forces[kept], forces[:, n + h :]])
        pushes = pushes - friction * csc_array(along)
        turned[:] = friction * strip.land_radius_mm
    # unknowns: belt, pulley, F, N, rotation
    system = block_array(
        [
            [body, -meets, pushes, None],
            [meets.T, None, None, csc_array(-lever[:, None])],
            [tie, None, None, csc_array((ways.size, 1))],
            [None, csc_array(lever[None]), csc_array(turned[None]), None],
        ]
    ).tocsc()
    right = np.zeros(system.shape[0])
    right[: kept.size] = pull
    right[-1] = FORCE * strip.pitch_radius_mm
    solved = spsolve(system, right)
    u = solved[: body.shape[0]]
    energy = float(u @ (body @ u)), float(pull @ u[: kept.size])
    return solved[body.shape[0] :][:k], float(solved[-1]), energy


def polar(turns: np.ndarray) -> csc_array:
    """Columns outwards and along the turn."""
    blocks = [csc_array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]]) for t in turns]
    return block_diag(blocks).tocsc()


#: A stiff cord lets all teeth carry.
FULL = replace(SMALL, cord_N_per_mm=20 * CORD)


@pytest.mark.parametrize(
    ("friction", "phase"), [(0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.0, 0.1), (0.2, -0.1)]
)
def test_belt_on_its_pulley_is_one_body_of_elements(friction: float, phase: float) -> None:
    """The same elements solved all at once, without Fourier and without any elimination."""
    state = solve_belt(
        FULL, resting(FULL, elements=2, phase=phase), FORCE, 5.0, land_friction=friction
    )
    active = np.flatnonzero(state.pair_N_per_mm)
    assert active.size > 6
    pairs, turn, _ = monolith(FULL, 2, 5.0, active, phase=phase, friction=friction)
    np.testing.assert_allclose(
        state.pair_N_per_mm[active], pairs, rtol=0.0, atol=10 * SOLVER * np.abs(pairs).max()
    )
    np.testing.assert_allclose(state.rotation_rad, turn, rtol=10 * SOLVER, atol=0.0)


def test_energy_of_the_elements_is_the_work_of_the_loads() -> None:
    state = solve_belt(FULL, resting(FULL, elements=2), FORCE, 5.0)
    active = np.flatnonzero(state.pair_N_per_mm)
    _, _, (stored, slack_work) = monolith(FULL, 2, 5.0, active)
    work = FORCE * FULL.pitch_radius_mm * state.rotation_rad + slack_work
    np.testing.assert_allclose(stored, work, rtol=1e-8, atol=0.0)


def test_shape_functions_are_where_they_were_when_the_pulley_turns_on() -> None:
    found = known(T10, elements=3)
    before, _ = touches_of(T10, held(T10, 3, 0.0), found.mesh, rows_of(found))
    after, _ = touches_of(T10, held(T10, 3, 1.2), found.mesh, rows_of(found))
    for sector in range(1, 9):
        # one tooth further on, of those in the row
        old, new = ([t.forces for t in all_ if t.sector == sector] for all_ in (before, after))
        for one, two in zip(old, new, strict=True):
            np.testing.assert_allclose(two, one, rtol=0.0, atol=1e-9)


def test_pitch_later_all_is_as_before() -> None:
    states = [
        solve_belt(T10, resting(elements=3, phase=phase), FORCE, 20.0) for phase in (0.4, 1.4)
    ]
    np.testing.assert_allclose(
        states[1].tooth_N_per_mm, states[0].tooth_N_per_mm, rtol=0.0, atol=SOLVER * FORCE
    )
    np.testing.assert_allclose(states[1].rotation_rad, states[0].rotation_rad, rtol=SOLVER, atol=0)


def test_stiff_pulley_is_a_rigid_one() -> None:
    """Its effect decreases as 1/E."""
    rigid = solve_belt(T10, response(), FORCE, 20.0)
    changes = []
    for modulus in (1e8, 1e9):
        state = solve_belt(T10, resting(material=Material(modulus, 0.3)), FORCE, 20.0)
        np.testing.assert_allclose(state.tooth_N_per_mm, rigid.tooth_N_per_mm, rtol=0, atol=1e-3)
        changes.append(modulus * (state.rotation_rad - rigid.rotation_rad))
    np.testing.assert_allclose(changes[0], changes[1], rtol=1e-3, atol=0.0)


@pytest.mark.parametrize(
    ("material", "twist", "whole"),
    [(STEEL, 0.0047, 0.0079), (PLASTIC, 0.338, 0.545), (Material(1000.0, 0.35), 1.014, 1.603)],
)
def test_pulley_twists_as_a_thick_ring_with_an_elastic_rim(
    material: Material, twist: float, whole: float
) -> None:
    """Parts of the rotation on a rigid pulley; the twist is M/(4 pi G) (1/a² - 1/b²)."""
    rigid = solve_belt(T10, response(), FORCE, 20.0)
    state = solve_belt(T10, resting(material=material), FORCE, 20.0)
    shear = material.young_modulus_MPa / (2 * (1 + material.poisson_ratio))
    radii = 1 / 10.0**2 - 1 / (T10.land_radius_mm - 2.5) ** 2
    closed = FORCE * T10.pitch_radius_mm / (4 * np.pi * shear) * radii / rigid.rotation_rad
    more = state.rotation_rad / rigid.rotation_rad - 1
    np.testing.assert_allclose(closed, twist, rtol=0.02, atol=0.0)
    np.testing.assert_allclose(more, whole, rtol=0.01, atol=0.0)
    assert more > closed
    # the softer the grooves, the more evenly they carry
    assert state.tooth_N_per_mm.max() < rigid.tooth_N_per_mm.max()


def test_forces_hold_each_other() -> None:
    for friction in (0.0, 0.2, -0.2):
        state = solve_belt(longer(T10, -10.0), resting(), FORCE, 20.0, land_friction=friction)
        np.testing.assert_allclose(state.tight_N_per_mm, 20.0 + FORCE, rtol=SOLVER, atol=0.0)
        whole = state.tooth_N_per_mm.sum() + state.land_friction_N_per_mm.sum()
        np.testing.assert_allclose(whole, FORCE, rtol=SOLVER, atol=0.0)


def test_slack_tension_presses_the_pulley_without_any_torque() -> None:
    """T2/r_p on every land all around: it shrinks as much as the ring of all loads."""
    found, rigid = (known.by[Kind.SLACK] for known in (resting(), response()))
    change = np.abs(found.displacement - rigid.displacement)
    assert (change > 0.01 * np.abs(rigid.displacement).max()).any()
    np.testing.assert_allclose(found.tight, 1.0, rtol=SOLVER, atol=0.0)
    # lands still carry the load of the taut strip
    np.testing.assert_allclose(found.reaction.sum(), rigid.reaction.sum(), rtol=0.02, atol=0.0)


@pytest.mark.parametrize(
    ("difference", "points"), [(0.0, 0.05 + ROW_AT_THE_EDGE), (-10.0, ROW), (-20.0, ROW)]
)
@pytest.mark.parametrize("modulus", [3000.0, 1000.0])
def test_row_of_springs_knows_the_pulley(modulus: float, difference: float, points: float) -> None:
    strip, known_here = longer(T10, difference), resting(material=Material(modulus, 0.35))
    state = solve_belt(strip, known_here, FORCE, 20.0)
    row = spring_row(strip, known_here)
    springs = solved_springs(row, 20.0, strip.pitch_difference_mm)
    np.testing.assert_allclose(
        100.0 * springs.normal_forces / FORCE, shares(state), rtol=0.0, atol=points
    )
    way = state.rotation_rad * strip.pitch_radius_mm
    np.testing.assert_allclose(springs.rotation, way, rtol=ROW_WAY, atol=0.0)
    # without the cross compliances of teeth through the pulley the twist is missing
    lone = replace(row, coupling_mm2_per_N=np.zeros(0))
    alone = solved_springs(lone, 20.0, strip.pitch_difference_mm)
    assert alone.rotation < 0.85 * way
    rigid = spring_row(strip, response())
    assert row.tooth_N_per_mm2 < 0.85 * rigid.tooth_N_per_mm2
    assert rigid.coupling_mm2_per_N.size == 0


def test_lands_that_need_not_lift_change_nothing() -> None:
    known_here = resting(TAUT, elements=3)
    held = solve_belt(TAUT, known_here, FORCE, 5.0)
    free = solve_belt(TAUT, known_here, FORCE, 5.0, land_lift=True)
    assert (held.land_N_per_mm > 0).all()
    assert free.land_lift_mm.max() < 1e-3
    np.testing.assert_allclose(free.tooth_N_per_mm, held.tooth_N_per_mm, rtol=0, atol=1e-4 * FORCE)


def test_lands_lift_off_an_elastic_pulley() -> None:
    known_here = resting(TAUT, elements=3)
    lifts, reaction = known_here.by[Kind.RADIAL], known_here.by[Kind.PAIR].reaction
    scale = np.abs(reaction).max()
    np.testing.assert_allclose(lifts.displacement, -reaction.T, rtol=0, atol=SOLVER * scale)
    state = solve_belt(TAUT, known_here, FORCE, 0.1, land_lift=True)
    rigid = solve_belt(TAUT, response(TAUT, 3), FORCE, 0.1, land_lift=True)
    assert state.land_N_per_mm.min() > -SOLVER * FORCE
    np.testing.assert_allclose(state.tight_N_per_mm, 0.1 + FORCE, rtol=1e-8, atol=0.0)
    assert state.land_lift_mm[-1] > 0
    assert abs(state.land_lift_mm[-1] / rigid.land_lift_mm[-1] - 1) < 0.9


WIDE = Trapezoid(5.7, 3.2, np.radians(25.0))


@pytest.mark.parametrize(
    ("strip", "groove", "depth"),
    [
        (T10, WIDE, 3.2),
        (HTD, HTD.tooth, HTD.tooth.height_mm),
        (HTD, HTD.tooth, HTD.tooth.height_mm + 0.6),
        (replace(HTD, tooth=Round(2.575, 2.3)), Round(2.575, 2.3), 2.3),
        (replace(HTD, tooth=Round(2.0, 2.0)), Round(2.1, 2.1), 2.1),
    ],
    ids=["wider and deeper", "round", "round and deeper", "less than half round", "wider round"],
)
def test_other_grooves_have_sound_elements_and_balance(
    strip: Strip, groove: Trapezoid | Round, depth: float
) -> None:
    strip = replace(strip, wrapped_teeth=4)
    pulley = replace(pulley_of(strip), groove=groove, depth_mm=depth)
    mesh = mesh_pulley(pulley, 4)
    kind, cells = mesh.sector.cells[0]
    assert (jacobians(mesh.sector.nodes, kind, cells) > 0).all()
    radii = np.hypot(*mesh.sector.nodes.T)
    np.testing.assert_allclose(radii.max(), strip.land_radius_mm, rtol=1e-12, atol=0.0)
    rigid = solve_belt(strip, response(strip, 4), FORCE, 20.0)
    moved = []
    for material in (PLASTIC, Material(1e9, 0.35)):
        own = solve_pulley(replace(mesh, pulley=replace(pulley, material=material)), sliding=True)
        found = on_elastic_pulley(response(strip, 4), strip, own)
        state = solve_belt(strip, found, FORCE, 20.0)
        np.testing.assert_allclose(state.tight_N_per_mm, 20.0 + FORCE, rtol=SOLVER, atol=0.0)
        moved.append(state.rotation_rad / rigid.rotation_rad - 1)
    assert 0.1 < moved[0] < 2.0
    assert 0.0 < moved[1] < 1e-5
