"""Bodies that grow before they touch: by heat and by speed, against closed forms and geometry."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.body import Body, MeshedFlank, WholeMesh
from flankload.elasticity.compliance import BodyCompliance, JobOptions, flank_compliance
from flankload.elasticity.finite_elements import centrifugal_load, stiffness
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.sector_closure import close_ring, uniform_response
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.expansion import BodyLoad, body_loads_of
from tests.support.condensed import condense
from tests.support.gear_pair import ONE, TWO
from tests.support.gear_scenes import changed
from tests.support.paths import SCENES
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.ring_bodies import gear_body
from tests.support.tolerances import ROUND_OFF, SOLVER

INNER, OUTER = 10.0, 30.0
#: Closed forms of an annulus against eight elements over its wall, of the displacement on its rim
#: (measured 6e-5).
ELEMENTS = 1e-4
#: A gear's backlash by the angle of its flanks, against flank curves (measured 3e-9), um.
CURVES_UM = 1e-3
#: Lumped contact against contact pairs, um (measured 0.009, without growth 0.008).
LUMPED_UM = 0.02
PAIR = {
    "body_1": ONE,
    "body_2": TWO,
    "pair": {"center_distance_mm": 91.5, "face_width_mm": 14},
    "load": {"torque_Nm": 302},
    "positions": {"count": 8},
    "accuracy": {"estimate": False, "tangents": False},
}


# --- closed forms ---------------------------------------------------------------------------------
def annulus(*, rows: int = 8) -> Body:
    """A ring of 7 sectors without lobes: its flank is part of a circle."""
    mesh, span = ring_sector(7, rows=rows, columns=12, lobe=0.0)
    return replace(gear_body(7, 2.5), mesh=mesh, mode_range_mm=span, material=STEEL)


def on_rim(compliance: BodyCompliance, body: Body) -> np.ndarray:
    """Radial displacement of the rim at its modes; the rim's middle is a circle."""
    columns = mode_loads(body.mesh, body.mode_range_mm, compliance.smooth.shape[1])
    out = columns.T @ body.mesh.nodes.ravel()
    low, high = body.mode_range_mm
    norms = (high - low) / (2 * np.arange(out.size) + 1)
    total = compliance.expansion.strain * out / norms
    return np.asarray(total + sum(part[0] for part in compliance.expansion.shifts.values()))


def plane_numbers(plane: str) -> tuple[float, float]:
    """E and nu of plane stress with which its closed forms hold."""
    modulus, ratio = STEEL.young_modulus_MPa, STEEL.poisson_ratio
    if plane == "stress":
        return modulus, ratio
    return modulus / (1 - ratio**2), ratio / (1 - ratio)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_rotating_annulus_on_a_stiff_shaft(plane: str) -> None:
    """Timoshenko, Theory of Elasticity, rotating discs: u = A r + B/r - (1 - nu²) rho w² r³/(8 E).

    Held in its bore, free at its rim.
    """
    body, speed, density = annulus(), 1200.0, 7.85e-9
    found = flank_compliance(
        body,
        JobOptions(n_modes=3, plane=plane),
        body_load=BodyLoad(speed_rad_per_s=speed, density_Ns2_per_mm4=density),
    )
    modulus, ratio = plane_numbers(plane)
    pull = density * speed**2 * (1 - ratio**2) / modulus
    # u(a) = 0; stress at b: (1 + nu) A - (1 - nu) B/b² - (3 + nu) pull b²/8 = 0
    equations = [[INNER, 1 / INNER], [1 + ratio, -(1 - ratio) / OUTER**2]]
    right = [pull * INNER**3 / 8, (3 + ratio) * pull * OUTER**2 / 8]
    a, b = np.linalg.solve(equations, right)
    exact = a * OUTER + b / OUTER - pull * OUTER**3 / 8
    assert exact > 1e-4
    displacement = on_rim(found, body)
    assert displacement[0] == pytest.approx(exact, rel=ELEMENTS)
    np.testing.assert_allclose(displacement[1:], 0.0, rtol=0, atol=ELEMENTS * exact)
    assert found.job.counters["fe_load_cases_growth"] == 1


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("held", [0.0, 4e-4, 9e-4])
def test_warm_annulus_on_a_shaft_of_another_expansion(plane: str, held: float) -> None:
    """u = A r + B/r with u = e_s a in the bore, no stress at the rim; free to grow axially."""
    body, strain = annulus(), 7e-4
    found = flank_compliance(
        body,
        JobOptions(n_modes=3, plane=plane),
        body_load=BodyLoad(strain=strain, held_strain=held),
    )
    _, ratio = plane_numbers(plane)
    # stress at b: (1 + nu) A - (1 - nu) B/b² = (1 + nu) e
    equations = [[INNER, 1 / INNER], [1 + ratio, -(1 - ratio) / OUTER**2]]
    a, b = np.linalg.solve(equations, [held * INNER, (1 + ratio) * strain])
    exact = a * OUTER + b / OUTER
    displacement = on_rim(found, body)
    assert displacement[0] == pytest.approx(exact, rel=ELEMENTS)
    assert abs(exact / (strain * OUTER) - 1) > 0.01


def test_growth_without_hindrance_is_exact_and_takes_no_elements() -> None:
    body, strain = annulus(), 7e-4
    found = flank_compliance(
        body,
        JobOptions(n_modes=3, plane="strain"),
        body_load=BodyLoad(strain=strain, held_strain=strain),
    )
    # the circle is one of quadratic edges
    assert on_rim(found, body)[0] == pytest.approx(strain * OUTER, rel=ELEMENTS)
    assert found.expansion.strain == strain
    assert not found.expansion.shifts
    assert "fe_load_cases_growth" not in found.job.counters
    almost = flank_compliance(
        body,
        JobOptions(n_modes=3, plane="strain"),
        body_load=BodyLoad(strain=strain, held_strain=strain * 0.9999),
    )
    np.testing.assert_allclose(on_rim(almost, body), on_rim(found, body), rtol=0, atol=3e-6)


def test_displacement_converges_as_elements_get_smaller() -> None:
    body_load = BodyLoad(speed_rad_per_s=1200.0, density_Ns2_per_mm4=7.85e-9)
    found = [
        on_rim(
            flank_compliance(body, JobOptions(n_modes=3, plane="strain"), body_load=body_load), body
        )[0]
        for body in (annulus(rows=2), annulus(rows=4), annulus(rows=8))
    ]
    assert abs(found[2] - found[1]) < 0.3 * abs(found[1] - found[0])


def test_pull_of_rotation_is_the_mass_times_its_place() -> None:
    """For a sector, the resultant is the integral of the place over the area."""
    mesh, _ = ring_sector(7, rows=8, columns=12, lobe=0.0)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    total = centrifugal_load(matrix, mesh.nodes, mesh.cells).reshape(-1, 2).sum(axis=0)
    half = np.pi / 7
    exact = 2 * np.sin(half) * (OUTER**3 - INNER**3) / 3
    np.testing.assert_allclose(total, [exact, 0.0], rtol=0, atol=1e-5 * exact)


# --- sectors and whole bodies ---------------------------------------------------------------------
def test_harmonic_0_is_the_sum_over_the_ring() -> None:
    mesh, span = ring_sector(7)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    pull = {"fe_load_cases_growth": centrifugal_load(matrix, mesh.nodes, mesh.cells).reshape(-1, 1)}
    sector, _ = condense(matrix, mode_loads(mesh, span, 3), mesh, pull)
    ring = close_ring(sector, 7)
    scale = np.abs(ring).max()
    np.testing.assert_allclose(
        uniform_response(sector, 7), ring.sum(axis=0), rtol=0, atol=100 * ROUND_OFF * scale
    )


def test_a_whole_mesh_grows_as_its_sectors_do() -> None:
    mesh, span = ring_sector(5)
    body = replace(gear_body(7, 2.5), mesh=mesh, mode_range_mm=span, material=STEEL)
    pieces = []
    for tooth in range(5):
        angle = 2 * np.pi * tooth / 5
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        pieces.append(mesh.nodes @ turn)
    count = len(mesh.nodes)
    _, number = np.unique(np.round(np.vstack(pieces), 7), axis=0, return_inverse=True)
    number = number.ravel()
    nodes = np.zeros((number.max() + 1, 2))
    nodes[number] = np.vstack(pieces)
    ((kind, data),) = mesh.cells
    flanks = []
    for tooth in (0, 2):
        own = number[tooth * count : (tooth + 1) * count]
        arc_length = np.full(len(nodes), np.nan)
        arc_length[own] = mesh.flank_arc_length
        flanks.append(MeshedFlank(tooth, nodes, own[mesh.flank_edges], arc_length))
    whole = replace(
        body,
        mesh=WholeMesh(
            nodes=nodes,
            cells=((kind, number[np.vstack([data + t * count for t in range(5)])]),),
            fixed_nodes=np.unique([number[mesh.fixed_nodes + t * count] for t in range(5)]),
            flanks=tuple(flanks),
        ),
    )
    body_load = BodyLoad(
        strain=7e-4, held_strain=2e-4, speed_rad_per_s=1200.0, density_Ns2_per_mm4=7.85e-9
    )
    one, other = (
        flank_compliance(each, JobOptions(n_modes=3, plane="strain"), body_load=body_load)
        for each in (body, whole)
    )
    assert other.expansion.strain == pytest.approx(one.expansion.strain, rel=SOLVER)
    assert (
        one.job.counters["fe_load_cases_growth"] == other.job.counters["fe_load_cases_growth"] == 2
    )
    for name in ("temperature", "speed"):
        for row in other.expansion.shifts[name]:
            np.testing.assert_allclose(
                row, one.expansion.shifts[name][0], rtol=0, atol=SOLVER * 0.02
            )


def test_a_segment_grows_as_the_whole_body() -> None:
    body_load = BodyLoad(strain=7e-4)
    body = gear_body(17, 2.5)
    one, other = (
        flank_compliance(
            body, JobOptions(n_modes=4, plane="strain"), body_load=body_load, sectors=sectors
        )
        for sectors in (None, 3)
    )
    assert one.expansion.strain == other.expansion.strain
    np.testing.assert_array_equal(
        one.expansion.shifts["temperature"], other.expansion.shifts["temperature"]
    )


# --- gears ----------------------------------------------------------------------------------------
@cache
def solved(*effects: tuple[str, Any], torque: float = 0.0) -> fl.Result:
    """The pair with effects, even where growth takes up its backlash."""
    asked = {"beyond_limits": True, **dict(effects)}
    found = fl.solve(fl.Scene.from_dict({**PAIR, "load": {"torque_Nm": torque}, "effects": asked}))
    assert isinstance(found, fl.Result)
    return found


def enlarged(gear: dict[str, Any], strain: float) -> dict[str, Any]:
    """The same gear, all its lengths larger."""
    keys = {"module_mm", "tip_diameter_mm", "bore_diameter_mm"}
    return {k: v * (1 + strain) if k in keys else v for k, v in gear.items()}


def test_growth_closes_the_backlash_as_larger_gears_do() -> None:
    """The gap of the coast flanks is that of larger gears on the same centre distance."""
    strain = 11.5e-6 * 60
    found = solved(("temperature_rise_K", 60.0))
    larger = {"body_1": enlarged(ONE, strain), "body_2": enlarged(TWO, strain)}
    asked = {**PAIR, **larger, "load": {"torque_Nm": 0}, "effects": {"beyond_limits": True}}
    made = fl.solve(fl.Scene.from_dict(asked))
    assert isinstance(made, fl.Result)
    # the base circle of the larger gear is larger, too
    wanted = made.coast_flank_gap_um / (1 + strain)
    np.testing.assert_allclose(found.coast_flank_gap_um, wanted, rtol=0, atol=CURVES_UM)
    # twice the angle of the line of action's turn, to second order
    cosine = 20 * 4.5 * np.cos(np.radians(20)) / 91.5
    closed = 2000 * strain * 91.5 * np.sqrt(1 - cosine**2)
    change = solved().coast_flank_gap_um - found.coast_flank_gap_um
    np.testing.assert_allclose(change, closed, rtol=10 * strain)


def test_unloaded_rotation_follows_the_grown_involute() -> None:
    """Roll angles: a flank of base radius (1 + e) r_b moves the contact along the line of action.

    Body 1 expands, its mate does not: it turns back by e times the roll length of the contact,
    and of all pairs the one nearest to its tip touches.
    """
    strain = 11.5e-6 * 60
    plain, found = solved(), solved(("temperature_rise_K", (60.0, 0.0)))
    base = 0.5 * 16 * 4.5 * np.cos(np.radians(20))
    moved = (plain.rotation_rad - found.rotation_rad) * base
    cosine = base * (1 + 24 / 16) / 91.5
    at_pitch_point = base * np.tan(np.arccos(cosine))
    pitch = np.pi * 4.5 * np.cos(np.radians(20))
    roll = at_pitch_point + found.position_rad * base
    # the last pair in contact, as far as body 1's tip reaches
    longest = np.sqrt(41.23**2 - base**2)
    last = roll + pitch * np.floor((longest - roll) / pitch)
    # for a tenth of a pitch beyond the path the edge of the tip touches still
    on_path = longest - last < 0.9 * pitch
    assert on_path.sum() == 7
    np.testing.assert_allclose(moved[on_path], strain * last[on_path], rtol=0.01)


def test_all_that_grows_alike_stays_as_it_was() -> None:
    """Gears and centre distance expand alike: only the lever arm of the torque is larger.

    Position zero is that of the gears as they were made, so wind-ups are compared.
    """
    strain = 11.5e-6 * 60
    warm = fl.Scene.from_dict(
        {
            **PAIR,
            "pair": {"center_distance_mm": 91.5 * (1 + strain), "face_width_mm": 14},
            "load": {"torque_Nm": [0, 302]},
            "effects": {"temperature_rise_K": 60},
        }
    )
    (start, found), plain = fl.solve(warm).by_torque, solved(torque=302.0)
    windup = found.rotation_rad - start.rotation_rad
    wanted = plain.rotation_rad - solved().rotation_rad
    np.testing.assert_allclose(windup.mean(), wanted.mean(), rtol=3 * strain)
    # a turn by the strain moves positions beside the kinks
    np.testing.assert_allclose(windup, wanted, rtol=0.01)
    np.testing.assert_allclose(found.load_share, plain.load_share, rtol=0, atol=0.01)


def test_temperature_and_speed_add_up() -> None:
    both = solved(("temperature_rise_K", 60.0), ("speed_rpm", 12000.0), torque=302.0)
    heat = solved(("temperature_rise_K", 60.0), torque=302.0)
    speed = solved(("speed_rpm", 12000.0), torque=302.0)
    plain = solved(torque=302.0)
    sum_of_both = heat.rotation_rad + speed.rotation_rad - 2 * plain.rotation_rad
    np.testing.assert_allclose(both.rotation_rad - plain.rotation_rad, sum_of_both, rtol=0.003)
    assert (plain.rotation_rad - speed.rotation_rad > 0).all()
    assert speed.summary["power_W"] == pytest.approx(302.0 * 400.0 * np.pi, rel=1e-12)
    assert "power_W" not in plain.summary


def test_lumped_contact_sees_the_growth() -> None:
    """It agrees with cells to the accuracy of lumped contact, off sharp corners."""
    key_pair = (("temperature_rise_K", (60.0, 20.0)), ("support_expansion_per_K", 0.0))
    pairs = solved(*key_pair, torque=302.0)
    lumped = solved(*key_pair, ("contact", "lumped"), torque=302.0)
    smooth = ~pairs.corner_contact.any(axis=1)
    assert smooth.sum() >= 4
    apart = (lumped.transmission_error_um - pairs.transmission_error_um)[smooth]
    np.testing.assert_allclose(apart, 0.0, rtol=0, atol=LUMPED_UM)


def test_counters_count_the_expansion() -> None:
    assert solved(torque=302.0).cost["fe_load_cases_growth"] == 0
    assert solved(("temperature_rise_K", 60.0), torque=302.0).cost["fe_load_cases_growth"] == 0
    held = solved(("temperature_rise_K", 60.0), ("support_expansion_per_K", 0.0))
    assert held.cost["fe_load_cases_growth"] == 2
    assert held.cost["fe_factorisations"] == 2
    both = solved(
        ("temperature_rise_K", (60.0, 0.0)),
        ("support_expansion_per_K", 0.0),
        ("speed_rpm", 12000.0),
        torque=302.0,
    )
    assert both.cost["fe_load_cases_growth"] == 3
    assert both.cost["fe_factorisations"] == 2


def test_without_growth_nothing_is_enlarged() -> None:
    scene = fl.Scene.from_dict({**PAIR, "effects": {"temperature_rise_K": 0, "speed_rpm": 0}})
    assert [job.body_load for job in build_bodies(scene).jobs] == [None, None]
    np.testing.assert_array_equal(fl.solve(scene).rotation_rad, solved(torque=302.0).rotation_rad)


# --- other bodies ---------------------------------------------------------------------------------
def test_body_2_turns_by_the_ratio() -> None:
    scene = fl.Scene.from_dict(
        {**PAIR, "effects": {"speed_rpm": 3000, "density_kg_m3": [1e3, 2e3]}}
    )
    one, two = body_loads_of(scene, build_bodies(scene).pairing)
    assert one is not None
    assert two is not None
    assert one.speed_rad_per_s == pytest.approx(100 * np.pi, rel=1e-12)
    assert two.speed_rad_per_s == pytest.approx(100 * np.pi * 16 / 24, rel=1e-12)
    assert (one.density_Ns2_per_mm4, two.density_Ns2_per_mm4) == pytest.approx((1e-9, 2e-9))


@pytest.mark.parametrize("name", ["internal_gear", "spline", "cam", "toothed_sector"])
def test_other_kinds_of_bodies_grow(name: str) -> None:
    """A ring in a housing, conforming flanks, closed ones, whole meshes: without load."""
    file = SCENES / f"{name}.toml"
    scene = tomllib.loads(file.read_text("utf-8"))
    scene["positions"] = {"angles_deg": [0.0]}
    scene["accuracy"] = {"estimate": False, "tangents": False, "tolerance": 0.1}
    scene["load"] = {"torque_Nm": 0}
    plain = fl.solve(fl.Scene.from_dict(scene, file=file))
    scene["effects"] = {"temperature_rise_K": 5, "support_expansion_per_K": 0}
    found = fl.solve(fl.Scene.from_dict(scene, file=file))
    assert isinstance(found, fl.Result)
    assert isinstance(plain, fl.Result)
    assert found.cost["fe_load_cases_growth"] > 0
    assert plain.cost["fe_factorisations"] == 0
    turned = np.abs(found.rotation_rad - plain.rotation_rad)[0] * plain.reference_radius_mm
    assert 1e-5 < turned < 0.01


def test_files_and_rigid_bodies_grow_as_a_whole(tmp_path: Path) -> None:
    from flankload.cli import main

    assert main(["compliance", str(SCENES / "external_gear.toml"), "-o", str(tmp_path)]) == 0
    asked = tomllib.loads((SCENES / "external_gear.toml").read_text("utf-8"))
    asked["effects"] = {"temperature_rise_K": 60, "beyond_limits": True}
    asked["accuracy"] = {"estimate": False, "tangents": False}
    asked["positions"] = {"count": 2}
    from_elements = fl.solve(fl.Scene.from_dict(asked))
    for key in ("body_1", "body_2"):
        asked[key] = {"kind": "compliance", "file": str(tmp_path / f"{key}.npz")}
    from_files = fl.solve(fl.Scene.from_dict(asked))
    np.testing.assert_allclose(from_files.rotation_rad, from_elements.rotation_rad, rtol=SOLVER)
    rigid = fl.Scene.from_dict(
        {**PAIR, "body_2": {**TWO, "rigid": True}, "effects": asked["effects"]}
    )
    body_load = build_bodies(rigid).jobs[1].body_load
    assert body_load is not None
    assert body_load.strain == body_load.held_strain == pytest.approx(69e-5)
    assert fl.solve(rigid).cost["fe_factorisations"] == 1


def test_rigid_bodies_name_the_missing_expansion() -> None:
    scene = fl.Scene.from_dict(
        {**PAIR, "body_2": {**TWO, "rigid": True}, "effects": {"speed_rpm": 100}}
    )
    assert "body_2: rigid, so its speed does not stretch it" in build_bodies(scene).notes


def test_compliance_holds_the_parts_of_the_growth_by_name() -> None:
    scene = fl.Scene.from_dict(
        {
            **PAIR,
            "effects": {
                "temperature_rise_K": 60,
                "support_expansion_per_K": 0,
                "speed_rpm": 6000,
            },
        }
    )
    pair = build_bodies(scene)
    found = compliance_of(pair.body_1, scene, job=pair.jobs[0])
    assert sorted(found.expansion.shifts) == ["speed", "temperature"]
    # most of it is that of a larger figure
    lift = np.abs(found.shift_of(np.array([0]))).max()
    assert lift < 0.2 * abs(found.expansion.strain) * pair.body_1.reference_radius_mm


# --- meaningless scenes ---------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"effects__density_kg_m3": 7000},
            r"effects\.density_kg_m3: expected nothing, unless there is an effects\.speed_rpm",
        ),
        (
            {"effects__thermal_expansion_per_K": 1e-5},
            r"effects\.thermal_expansion_per_K: .* unless there is an effects\.temperature_rise_K",
        ),
        (
            {"effects__support_expansion_per_K": 0},
            r"effects\.support_expansion_per_K: .*effects\.temperature_rise_K, found 0",
        ),
        (
            {"effects__temperature_rise_K": [10, 500], "effects__thermal_expansion_per_K": 1e-4},
            (
                r"effects\.temperature_rise_K: expected so few K that they stretch the bodies by "
                r"0\.02 at most, with effects\.thermal_expansion_per_K 0\.0001, found 500"
            ),
        ),
        (
            {"effects__speed_rpm": 100, "effects__body": "tooth"},
            r"effects\.speed_rpm: expected nothing, since effects\.body is 'tooth'",
        ),
        (
            {"effects__speed_rpm": 100, "body_2": {"kind": "compliance", "file": "b.npz"}},
            r"effects\.speed_rpm: expected nothing, since body_2\.kind is 'compliance'",
        ),
        (
            {
                "effects__temperature_rise_K": 10,
                "effects__support_expansion_per_K": 0,
                "body_2": {"kind": "compliance", "file": "b.npz"},
            },
            r"effects\.support_expansion_per_K: .* body_2\.kind is 'compliance'",
        ),
        (
            {"effects__temperature_rise_K": [10, 20, 30]},
            r"effects\.temperature_rise_K: expected a list of 2 numbers",
        ),
    ],
)
def test_refusals(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.errors.SceneError, match=line):
        fl.Scene.from_dict(changed(**changes))


def test_another_program_gets_no_bodies_that_grow(capsys: pytest.CaptureFixture[str]) -> None:
    from flankload.cli import main

    scene = str(SCENES / "external_gear_warm.toml")
    assert main(["verify", scene, "--position", "0", "--no-run"]) == 2
    said = capsys.readouterr().err
    assert "effects.temperature_rise_K: expected nothing: expanding bodies are not written" in said
    assert "found [70.0, 50.0]" in said


def test_a_report_names_overlapping_flanks_and_load_cases() -> None:
    tight = solved(("temperature_rise_K", 150.0), ("support_expansion_per_K", 0.0), torque=10.0)
    assert "coast flanks        overlap of up to 9" in tight.table()
    assert "2 load cases of expansion" in tight.table()
    assert "growth" not in solved(torque=302.0).table()


def test_growth_that_takes_up_the_backlash_is_warned_of() -> None:
    """The flanks overlap before there is torque; under torque at least a part of that is known.

    Both are refused (test_premises.py), unless it is asked for.
    """
    warm = ("temperature_rise_K", 40.0)
    free, loaded = (solved(warm, torque=torque) for torque in (0.0, 302.0))
    overlap_um = -free.coast_flank_gap_um.min()
    assert overlap_um > 30
    (said,) = (found for found in free.warnings if "closes the backlash" in found)
    assert f"overlap by at least {overlap_um:.1f} um" in said
    assert loaded.coast_flank_gap_um.min() > 0  # turned as loaded, shaped as without load
    (said,) = (found for found in loaded.warnings if "closes the backlash" in found)
    least_um = float(said.partition("overlap by at least ")[2].split()[0])
    assert 0.8 * overlap_um < least_um < overlap_um
    for quiet in (solved(warm, ("coast_flank", True), torque=302.0), solved(torque=302.0)):
        assert not any("closes the backlash" in found for found in quiet.warnings)


def test_a_swinging_follower_has_no_speed() -> None:
    cam = tomllib.loads((SCENES / "cam.toml").read_text("utf-8"))
    with pytest.raises(fl.errors.SceneError, match=r"effects\.speed_rpm: .* body_2\.kind is 'cam'"):
        fl.Scene.from_dict({**cam, "effects": {"speed_rpm": 100}})
