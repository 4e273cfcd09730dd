"""Planetary stages: whole-body finite elements, closed forms, symmetries."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload.contact.meshes import solve_meshes
from flankload.contact.meshes_contact import meshes_problem
from flankload.mechanisms import Parts
from flankload.mechanisms.displaced import are_displaced, run_displaced
from flankload.mechanisms.registry import mechanism_of
from flankload.mechanisms.several.states import counted_work
from flankload.mechanisms.stage.assembly import NAMES, assemble
from flankload.mechanisms.stage.states import compliances_of
from flankload.mechanisms.stage_clock import StageClock
from flankload.pairing.stage import surviving_order
from flankload.report.turning import turning
from flankload.studies.benchmark.case import read_cases
from tests.support.planetary_stages import four, scene_of
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
#: Curves of flanks are accurate to 1e-9 mm, levers and torques to this part.
LEVERS = 2e-9
#: Orders that must vanish, um.
NO_ORDER_UM = 1e-9
#: Relative error of difference quotients over small errors of the pins (measured 4e-11).
DIFFERENCE = 1e-9
#: Curves that are evaluated at other angles (measured 5e-13).
TURNED = 1e-12
#: Forces that converge from another start, to the largest (measured 2e-9).
CONTINUED = 1e-8
#: Squares of displacements over the radii of curvature, to the approach under a small load.
SQUARES = 1e-5
#: Positions off sharp corners.
SMOOTH = {"count": None, "angles_deg": [1.8, 5.4]}


def stage(**changes):
    return solve(fl.Scene.from_dict(four(**changes)))


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
@pytest.mark.parametrize("name", ["planetary_stage_floating", "planetary_stage_pin_error"])
def test_whole_body_finite_elements(name, contact):
    (case,) = (case for case in read_cases(BENCHMARKS) if case.name == name)
    scene = fl.read_scene(BENCHMARKS / name / "scene.toml")
    found = solve(scene.replace({"effects.contact": contact}))
    known = {key: quantity.value for key, quantity in case.quantities.items()}
    for p in range(found.position_rad.size):
        te = known[f"transmission_error[{p}]"]
        assert found.transmission_error_um[p] == pytest.approx(te, rel=1e-3)
        for j in range(3):
            share = known[f"load_share[{p}, {j + 1}]"]
            assert found.planet_load_share[p, j] == pytest.approx(share, abs=5e-4)
        factor = known.get(f"mesh_load_factor[{p}]", 1.0) - 1.0
        assert found.mesh_load_factor[p] - 1.0 == pytest.approx(factor, rel=2e-3, abs=1e-9)
    assert not found.status.any()


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_only_the_orders_of_the_planets_survive(contact):
    """Planets out of phase, contact on sharp corners: multiples of 4, orbit 1, -3, 5, ..."""
    count = 16
    found = stage(positions={"count": count}, effects={"contact": contact})
    assert found.corner_contact.any()
    error = np.abs(np.fft.fft(found.transmission_error_um)) / count
    survives = np.arange(count) % 4 == 0
    assert error[~survives].max() < NO_ORDER_UM
    assert error[4] > 0.1
    orbit = np.abs(np.fft.fft(found.sun_orbit_um @ [1, 1j])) / count
    assert orbit[np.arange(count) % 4 != 1].max() < NO_ORDER_UM
    assert orbit[1] > 1.0
    assert found.summary["surviving_orders"] == [4, 8, 12]


def test_counter_phase_shares_unevenly_without_any_error():
    teeth = {
        "body_1": {"teeth": 18, "tip_diameter_mm": 59.7},
        "planet": {"teeth": 18, "tip_diameter_mm": 59.7},
        "body_2": {
            "teeth": 54,
            "tip_diameter_mm": 157.8,
            "root_diameter_mm": 169.5,
            "outer_diameter_mm": 192,
        },
    }
    found = stage(**teeth, pair={"center_distance_mm": 54}, load={"torque_Nm": 400})
    count = found.position_rad.size
    error = np.abs(np.fft.fft(found.transmission_error_um)) / count
    assert error[1::2].max() < NO_ORDER_UM
    assert error[2] > 0.1
    assert np.abs(found.sun_orbit_um).max() < NO_ORDER_UM
    assert found.mesh_load_factor.max() > 1.02
    assert f"MPa on planet {found.summary['peak_pressure_pair']} at" in found.table()
    assert "loaded planets" in found.table()


def test_derivatives_to_errors_of_planets():
    """Also of lists that the scene does not have: those of difference quotients."""
    scene = scene_of(
        positions=SMOOTH, stage={"pin_tangential_errors_um": [15, 0, 3, 0], "floating": "none"}
    )
    names = ("pin_tangential_errors_um[0]", "planet_thickness_errors_um[2]")
    paths = [f"stage.{name}" for name in names]
    found = fl.sensitivity(scene, paths).derivative("planet_load_share")[:, 0]
    for path, value, slopes in zip(paths, (15.0, 0.0), found, strict=True):
        sides = [solve(scene.replace({path: value + step})) for step in (0.05, -0.05)]
        quotient = (sides[0].planet_load_share - sides[1].planet_load_share) / 0.1
        np.testing.assert_allclose(slopes, quotient, atol=1e-6 * np.abs(quotient).max())
        assert np.abs(quotient).max() > 1e-3


def test_torques_of_ring_and_carrier():
    angles = {"count": None, "angles_deg": [1.8]}
    found = stage(positions=angles, stage={"pin_tangential_errors_um": [20, 0, 0, 0]})
    assert not found.corner_contact.any()
    np.testing.assert_allclose(found.ring_torque_Nm, 600 * 59 / 25, rtol=LEVERS)
    np.testing.assert_allclose(found.carrier_torque_Nm, 600 * 84 / 25, rtol=LEVERS)
    centers = 63.0 * np.stack([[1, 0, -1, 0], [0, 1, 0, -1]], axis=-1)
    x, y = np.moveaxis(found.pin_force_N, -1, 0)
    moments = (centers[:, 0] * y - centers[:, 1] * x).sum(axis=1) / 1000
    np.testing.assert_allclose(found.carrier_torque_Nm, moments, rtol=LEVERS)


def test_shares_follow_the_harmonics_of_the_stiffness_between_the_paths():
    """Planets in phase: a floating sun removes the harmonics 1 and n - 1 of those of a fixed one.

    Derivatives of the shares by the path error of planet 1, with the coupling through the bodies.
    """
    teeth = {
        "body_1": {"teeth": 25, "tip_diameter_mm": 80.7},
        "stage": {"planets": 5, "floating": "none"},
        "body_2": {
            "teeth": 60,
            "tip_diameter_mm": 175.8,
            "root_diameter_mm": 187.5,
            "outer_diameter_mm": 207,
        },
        "planet": {"teeth": 17},
        "pair": {"center_distance_mm": 64.0},
    }
    slopes = {}
    for floating in ("none", "sun"):
        sides = []
        for error in (-0.1, -0.05, 0.05, 0.1):
            errors = {"planets": 5, "floating": floating}
            errors["pin_tangential_errors_um"] = [error, 0, 0, 0, 0]
            found = stage(
                **{**teeth, "stage": errors}, positions={"count": None, "angles_deg": [1.8]}
            )
            sides.append(found.planet_load_share[0])
        # difference quotients of fourth order (Richardson)
        slopes[floating] = (8.0 * (sides[2] - sides[1]) - (sides[3] - sides[0])) / 0.6
    fixed, free = (np.fft.fft(slopes[name]) for name in ("none", "sun"))
    largest = np.abs(fixed).max()
    np.testing.assert_allclose(free[2:4], fixed[2:4], atol=DIFFERENCE * largest)
    assert np.abs(free[[0, 1, 4]]).max() < DIFFERENCE * largest
    assert np.abs(fixed[[1, 4]]).min() > 0.5 * largest


def test_a_stage_turned_and_renumbered():
    errors = [15.0, 3.0, -4.0, 7.0]
    one = stage(positions=SMOOTH, stage={"pin_tangential_errors_um": errors})
    angles = {"planets": None, "angles_deg": [30, 120, 210, 300]}
    turned = stage(positions=SMOOTH, stage={**angles, "pin_tangential_errors_um": errors})
    # planet 2 becomes planet 1, a quarter of a pitch of the sun later
    later = [angle + 14.4 / 4 for angle in SMOOTH["angles_deg"]]
    renumbered = stage(
        positions={"count": None, "angles_deg": [angle - 2 * 14.4 / 4 for angle in later]},
        stage={"pin_tangential_errors_um": np.roll(errors, -1).tolist()},
    )
    np.testing.assert_allclose(turned.transmission_error_um, one.transmission_error_um, rtol=TURNED)
    orbit = turned.sun_orbit_um @ [1, 1j] * np.exp(-1j * np.pi / 6)
    np.testing.assert_allclose(orbit, one.sun_orbit_um @ [1, 1j], rtol=TURNED)
    np.testing.assert_allclose(
        renumbered.transmission_error_um, one.transmission_error_um, rtol=TURNED
    )
    shares = np.roll(renumbered.planet_load_share, 1, axis=1)
    np.testing.assert_allclose(shares, one.planet_load_share, rtol=TURNED)


def test_one_planet_is_two_pairs_in_series():
    """Without coupling of its flanks through the planet, the approaches of two pairs add up."""
    single = stage(
        positions=SMOOTH,
        stage={"planets": 1, "floating": "none"},
        effects={"contact": "lumped", "mesh_coupling": False},
        load={"torque_Nm": 150},
    )
    scene = four()
    approach = np.zeros(2)
    for kind, names, ratio in (
        ("sun", ("body_1", "planet"), 1.0),
        ("ring", ("planet", "body_2"), 17 / 25),
    ):
        mesh = single.mesh(1, kind)
        pair = {key: scene[key] for key in ("pair", "effects", "accuracy")}
        pair |= {f"body_{z + 1}": scene[name] for z, name in enumerate(names)}
        pair["load"] = {"torque_Nm": 150 * ratio}
        pair["positions"] = {"angles_deg": mesh.position_deg.tolist()}
        own = solve(fl.Scene.from_dict(pair))
        approach += own.transmission_error_um
        np.testing.assert_allclose(
            mesh.transmission_error_um, own.transmission_error_um, rtol=SOLVER
        )
        np.testing.assert_allclose(
            mesh.site_force_N.sum(axis=1), own.site_force_N.sum(axis=1), rtol=LEVERS
        )
    np.testing.assert_allclose(single.transmission_error_um, approach, rtol=SOLVER)


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_radial_errors_of_equal_angles_leave_the_shares_alone(contact):
    """Radial errors change gaps only to second order, apart from varying normals in a contact."""
    shares = [
        stage(
            positions=SMOOTH,
            stage={"pin_radial_errors_um": errors, "floating": "none"},
            load={"torque_Nm": 30},
            effects={"contact": contact},
        ).planet_load_share
        for errors in ([12, 6, 23, -8], [])
    ]
    np.testing.assert_allclose(*shares, rtol=0, atol=SQUARES)


def test_planets_that_lift_off():
    """A floating sun with 4 planets: at most two carry, the others are free."""
    found = stage(positions=SMOOTH, stage={"pin_tangential_errors_um": [300, 0, 0, 0]})
    np.testing.assert_allclose(found.mesh_load_factor, 2.0, rtol=2e-3)
    assert found.planet_load_share[:, [1, 3]].max() < SOLVER
    assert not found.status.any()


def test_weight_and_support_of_the_sun():
    heavy = stage(positions=SMOOTH, stage={"sun_weight_N": 200.0})
    light = stage(positions=SMOOTH)
    force = np.sum(heavy.planet_force_N - light.planet_force_N, axis=1)
    np.testing.assert_allclose(force, [[0, -200]] * 2, atol=0.05)
    stiff = stage(positions=SMOOTH, stage={"sun_stiffness_N_per_um": 1e6})
    fixed = stage(positions=SMOOTH, stage={"floating": "none"})
    np.testing.assert_allclose(stiff.transmission_error_um, fixed.transmission_error_um, rtol=1e-4)


def test_thicker_planets():
    """Thicker teeth of all planets turn the sun back."""
    plain = stage(positions=SMOOTH)
    thick = stage(positions=SMOOTH, stage={"planet_thickness_errors_um": [2.0] * 4})
    # half of 2 um in each mesh: the sun turns back by 2 um
    change = thick.transmission_error_um - plain.transmission_error_um
    np.testing.assert_allclose(change, -2.0, rtol=1e-6)


def test_a_run_out_of_the_ring_moves_a_floating_sun():
    """With equal pressure angles, the sun moves as far as the ring: half the run-out."""
    plain = stage(positions=SMOOTH, stage={"planets": 3})
    out = stage(positions=SMOOTH, stage={"planets": 3, "ring_run_out_um": 20.0})
    np.testing.assert_allclose(out.planet_load_share, plain.planet_load_share, atol=2e-4)
    moved = np.hypot(*(out.sun_orbit_um - plain.sun_orbit_um).T)
    np.testing.assert_allclose(moved, 10.0, rtol=1e-3)


def test_a_floating_carrier_is_balanced():
    """It moves against sun and ring, as both would together: forces on its pins have no sum."""
    found = stage(
        positions=SMOOTH,
        stage={"floating": "carrier", "pin_tangential_errors_um": [20, 0, 0, 0]},
    )
    sums = np.abs(found.pin_force_N.sum(axis=1))
    assert sums.max() < SOLVER * np.abs(found.pin_force_N).max()
    assert np.abs(found.carrier_orbit_um).max() > 1.0
    sun = stage(positions=SMOOTH, stage={"pin_tangential_errors_um": [20, 0, 0, 0]})
    np.testing.assert_allclose(found.mesh_load_factor, sun.mesh_load_factor, rtol=5e-3)


def test_a_free_rim_beside_a_sun_on_a_spring():
    """A stiff spring is a fixed sun, which centres the planets in a free ring."""
    free = {"ring_support": "free", "pin_tangential_errors_um": [20, 0, 0, 0]}
    sprung = {"floating": "sun", "sun_stiffness_N_per_um": 1e6}
    found = stage(positions=SMOOTH, stage={**free, **sprung})
    fixed = stage(positions=SMOOTH, stage={**free, "floating": "ring"})
    np.testing.assert_allclose(found.transmission_error_um, fixed.transmission_error_um, rtol=1e-5)
    np.testing.assert_allclose(found.ring_orbit_um, fixed.ring_orbit_um, atol=1e-3)


@pytest.mark.parametrize(("floating", "part"), [("none", 1.0), ("sun", 0.5), ("carrier", 0.5)])
def test_without_load_the_sun_turns_until_it_is_held(floating, part):
    """An early pin holds a fixed sun alone; one that floats turns on, to where a second holds."""
    errors = {"floating": floating, "pin_tangential_errors_um": [20, 0, 0, 0]}
    found = stage(positions=SMOOTH, stage=errors, load={"torque_Nm": 0}, effects={})
    turned = -20.0 * 2.0 * np.cos(np.radians(20.0))
    np.testing.assert_allclose(found.transmission_error_um, part * turned, atol=1e-4)
    assert not found.site_force_N.any()


@pytest.mark.parametrize(
    ("floating", "errors", "torque", "at"),
    [
        ("carrier", [18.107, 8.927, -10.739, 11.622], 100, 5.4),
        ("sun", [20, 0, 20, 0], 1, 0.0),
        ("carrier", [20, 0, 0, 0], 0.01, 3.6),
    ],
)
def test_two_planets_carry_all(floating, errors, torque, at):
    """Regression: lumped contacts of free planets were omitted or had no levers."""
    found = stage(
        positions={"count": None, "angles_deg": [at]},
        load={"torque_Nm": torque},
        stage={"floating": floating, "pin_tangential_errors_um": errors},
    )
    np.testing.assert_allclose(found.mesh_load_factor, 2.0, rtol=1e-2)


def test_the_work_of_the_elements_is_predicted():
    """Regression: it was 0, so a plan predicted no time for them."""
    bolts = {"ring_support": "bolts", "bolts": 8, "bolt_stiffness_N_per_um": 100}
    scene = scene_of(positions={"count": 1}, stage=bolts)
    stages = fl.solve(scene).cost["stages"]
    for name, predicted in counted_work(scene, assemble(scene)).items():
        found = stages[name]["counters"] | {"bytes": stages[name]["bytes"]}
        assert {key: found.get(key, 0) for key in predicted} == dict(predicted), name


def test_numbers_of_a_published_stage():
    """NREL's gearbox of 5 MW, stage 1 (Nejad 2016): profile shifts of the ring as of its space."""
    keys = {"kind": "gear", "module_mm": 45}
    hub = {"bore_diameter_mm": 400}
    scene = {
        "body_1": {**keys, **hub, "teeth": 19, "profile_shift": 0.617, "tip_diameter_mm": 995},
        "planet": {**keys, **hub, "teeth": 17, "profile_shift": 0.802, "tip_diameter_mm": 910},
        "body_2": {
            **keys,
            "kind": "ring",
            "teeth": 56,
            "profile_shift": 0.501,
            "tip_diameter_mm": 2475,
            "root_diameter_mm": 2645,
            "outer_diameter_mm": 3100,
        },
        "stage": {"planets": 3, "floating": "sun"},
        "pair": {"center_distance_mm": 863, "face_width_mm": 491},
        "load": {"torque_Nm": 1e6},
    }
    pairing = assemble(fl.Scene.from_dict(scene)).pairing
    gears = (pairing.meshes[0].pairing.gear_geometry, pairing.meshes[-1].pairing.gear_geometry)
    sun, ring = (mesh.pressure_angle_rad for mesh in gears)
    np.testing.assert_allclose(np.degrees([sun, ring]), [28.118, 17.161], atol=6e-4)
    radial = (np.sin(sun) - np.sin(ring)) / (np.cos(sun) + np.cos(ring))
    assert radial == pytest.approx(0.0959, abs=5e-5)
    assert surviving_order(pairing.count, pairing.teeth[0]) == 3


def test_a_relieved_ring_on_bolts(monkeypatch):
    """Elements that follow the flank without reliefs move the rim as those of the relieved one."""
    scene = scene_of(
        positions={"count": 2},
        body_2={"tip_relief_um": 30, "tip_relief_start_diameter_mm": 175.5},
        stage={"ring_support": "bolts", "bolts": 12, "bolt_stiffness_N_per_um": 20},
    )
    found = fl.solve(scene)
    monkeypatch.setattr("flankload.mechanisms.scene_bodies.unmodified", lambda table: table)
    expected = fl.solve(scene)
    # 0.06, 2 and 70 % with the normals of the flank without reliefs
    within = {"transmission_error_um": 1e-4, "ring_deflection_um": 1e-3, "ring_orbit_um": 0.02}
    for name, apart in within.items():
        one, two = (getattr(result, name) for result in (found, expected))
        assert np.abs(one - two).max() < apart * np.abs(two).max()


def test_a_ring_on_bolts():
    """Stiff bolts behind all teeth are nearly a clamp; soft ones move by the force on the ring."""
    keys = {"floating": "none", "pin_tangential_errors_um": [20, 0, 0, 0], "ring_support": "bolts"}
    clamped = stage(positions=SMOOTH, stage={**keys, "ring_support": None})
    stiff = {"bolts": 59, "bolt_stiffness_N_per_um": 1e8}
    found = stage(positions=SMOOTH, stage={**keys, **stiff})
    # bolts hold the means of the sectors only
    np.testing.assert_allclose(
        found.transmission_error_um, clamped.transmission_error_um, rtol=0.02
    )
    soft = {"bolts": 59, "bolt_stiffness_N_per_um": 10}
    found = stage(positions=SMOOTH, stage={**keys, **soft})
    on_ring = (found.planet_force_N - found.pin_force_N).sum(axis=1)
    # forces are projected onto the pressure modes
    largest = np.abs(found.planet_force_N).max()
    np.testing.assert_allclose(590 * found.ring_orbit_um, on_ring, atol=2e-4 * largest)
    assert found.ring_deflection_um.shape == (2, 59)
    # pushed outwards by planet 1, at the first space
    assert found.ring_deflection_um[:, 0].min() > 0.0
    assert not clamped.ring_deflection_um.any()


def test_the_turning_picture_shows_all_bodies_and_a_spectrum_marks_orders():
    """Regression: it showed the sun alone."""
    found = stage(positions={"count": 4})
    shown = turning([found])
    assert shown.numbers == (1, 2, 1, 1, 1, 1)
    np.testing.assert_allclose(
        shown.centers_mm[2:], 63.0 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]), atol=1e-12
    )
    assert len(shown.data["turn"]) == 6
    assert list(found.engagement.marked_orders) == [4, 8, 12]


def test_rows_of_two_pairs_of_a_mesh_in_one_start():
    """Regression: rows equal to 1e-10 in one start left the floating sun without a state."""
    found = stage(positions={"count": None, "angles_deg": [2.249, 2.25, 2.26, 2.3]})
    assert not found.status.any()


def test_planets_bend_to_both_sides_and_slide_in_both_meshes():
    """A tooth is bent by the sun and, half a turn later, back by the ring: a mean of nearly 0."""
    found = stage(
        positions={"count": None, "angles_deg": [1.8]},
        effects={"contact": "lumped", "root_stress": True},
    )
    bending = found.stage.planet_bending
    working = bending.points.working
    for kind, member, side in (("sun", 1, working), ("ring", 0, ~working)):
        mesh = found.mesh(1, kind)
        stress = mesh.root_stress[member]
        # other teeth carry the load of the other mesh
        own = stress.stress_MPa[:, :, stress.points.working].max()
        assert bending.largest_MPa[0, side].max() == pytest.approx(own, rel=2e-2)
        losses = getattr(found.stage, f"{kind}_mesh_sliding_loss_Nm")[:, 0]
        speed = np.nan_to_num(np.abs(mesh.sliding_mm_per_rad)) * (1.0 if kind == "sun" else 25 / 17)
        np.testing.assert_allclose(
            losses, (speed * mesh.site_force_N).sum(axis=1) / 1000, rtol=1e-5
        )
    worst = found.summary["planet_root_stress"]
    assert abs(worst["mean_MPa"]) < 0.1 * worst["range_MPa"]
    assert "root stress of planet" in found.stage.words()


def test_a_contact_that_just_opens_ends_the_passes():
    """Regression: passes alternated between a wide closed and a narrow open contact."""
    pins = [3.8430450479977516, -5.150694656166997, -7.4430286744256, 4.6972221673278085]
    errors = {"pin_tangential_errors_um": pins, "pin_stiffness_N_per_um": 300}
    found = stage(
        positions={"count": None, "angles_deg": [10.2]},
        stage=errors,
        body_2={"outer_diameter_mm": 207},
    )
    assert not found.status.any()


def test_stages_with_other_pins_share_a_run():
    """Each state starts from that of another design; one planet lifts off in the last one."""
    scene = scene_of(positions={"count": 4}, stage={"pin_tangential_errors_um": [0, 0, 0, 0]})
    pins = [[3, 0, 0, 0], [5, -4, 2, 8], [0, 30, 0, 0], [200, 0, 0, 0]]
    scenes = [scene.replace({"stage.pin_tangential_errors_um": errors}) for errors in pins]
    assert are_displaced(scenes[0], scenes[1])
    assert not are_displaced(scenes[0], scene.replace({"stage.floating": "none"}))
    together = run_displaced(scenes, Parts())
    for one, (found,) in zip(scenes, together, strict=True):
        alone = solve(one)
        for name in ("transmission_error_um", "planet_load_share", "planet_force_N"):
            expected = getattr(alone, name)
            atol = CONTINUED * np.abs(expected).max()
            np.testing.assert_allclose(getattr(found, name), expected, rtol=0, atol=atol)
        assert not found.status.any()
    # forces are estimated for the first design alone
    of_second = [one.cost["of_this_torque"] for one in (together[1][0], solve(scenes[1]))]
    assert of_second[0]["lumped_solutions"] < of_second[1]["lumped_solutions"]


def test_fields_of_all_bodies_have_the_forces_of_the_contacts(tmp_path):
    """Nodes under forces are beside the contacts; sums are those of planets and pins."""
    scene = scene_of(
        positions={"count": None, "angles_deg": [1.8]},
        stage={"planets": 3, "pin_tangential_errors_um": [20, 0, 0]},
        accuracy={"flank_element_mm": 2.0, "modes": 3},
    )
    found = solve(scene)
    table = found.pairs(0)
    places = np.column_stack([table.x_mm, table.y_mm])[table.force_N > 0]
    largest = np.abs(found.pin_force_N).max()
    bodies = mechanism_of(scene).fields_of_bodies(scene)
    assert list(bodies) == ["body_1", *(f"planet_{j}" for j in (1, 2, 3)), "body_2"]
    for j, body in enumerate(bodies.values()):
        fields = body.at(found, 0)
        loaded = np.abs(fields.force_N).sum(axis=1) > 0
        apart = np.linalg.norm(fields.points_mm[loaded, None, :2] - places, axis=2).min(axis=1)
        assert apart.max() < 2.0  # the length of an element
        on_sun = found.planet_force_N[0].sum(axis=0)
        on_ring = on_sun - found.pin_force_N[0].sum(axis=0)
        wanted = (-on_sun, *found.pin_force_N[0], on_ring)[j]
        np.testing.assert_allclose(fields.force_N[:, :2].sum(axis=0), wanted, atol=2e-4 * largest)
        # the planets are pushed along the forces on their pins
        pushed = (fields.displacement_mm * fields.force_N).sum()
        assert pushed > 0.0
    lines = fl.write_vtu(scene, found, tmp_path)
    assert len(lines) == 5
    assert (tmp_path / "planet_2_0000.vtu").is_file()


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_a_stage_in_a_mirror(contact):
    """Frames, pins and motions mirrored about the x axis: forces are the mirror images."""
    scene = scene_of(
        positions={"count": None, "angles_deg": [1.8, 5.4]},
        stage={
            "pin_tangential_errors_um": [15.0, 3.0, -4.0, 7.0],
            "pin_radial_errors_um": [2.0, 0.0, 5.0, -3.0],
            "pin_stiffness_N_per_um": [200, 300],
            "sun_weight_N": 80,
        },
        effects={"contact": contact},
        accuracy={"flank_element_mm": 2.0, "modes": 3},
    )
    assembly = assemble(scene)
    assembly, compliances = compliances_of(scene, assembly, StageClock(None, NAMES, 1, {}), {})
    one = assembly.contact(scene, compliances)
    meshes = [replace(m, frame_rad=-m.frame_rad, sense=-m.sense) for m in one.pairing.meshes]
    mirrored = replace(one.pairing, angles_rad=-one.pairing.angles_rad, meshes=tuple(meshes))
    image = replace(one, pairing=mirrored)
    problems = [meshes_problem(c, assembly.position_rad, scene.torques_Nmm) for c in (one, image)]
    flip = np.array([1.0, -1.0, -1.0])
    bodies, of_meshes, motions, angles, loads, moved = problems[1]
    turned = [m if m.kind == "x" else replace(m, sign=-m.sign) for m in motions]
    plain = solve_meshes(*problems[0], keep_pairs=False)
    # displacements are those of the errors, not of the mirrored pairing
    moved = problems[0][-1] * flip
    found = solve_meshes(bodies, of_meshes, turned, angles, loads, moved, keep_pairs=False)
    for name, part in (
        ("motion", TURNED),
        ("site_force_N", TURNED),
        ("site_peak_N_per_mm", SOLVER),
    ):
        wanted = getattr(plain, name)
        np.testing.assert_allclose(
            getattr(found, name), wanted, rtol=0, atol=part * np.abs(wanted).max()
        )
    largest = np.abs(plain.resultant).max(axis=(0, 1, 2))
    assert (np.abs(found.resultant * flip - plain.resultant) < TURNED * largest).all()


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_a_planet_is_at_the_end_of_its_clearance(contact):
    """Clearance acts as a pin displaced along the force; equal clearances only turn the sun."""
    working = {"count": None, "angles_deg": [1.8]}
    changes = {"positions": working, "effects": {"contact": contact}}
    plain = stage(**changes)
    equal = stage(**changes, stage={"pin_clearance_um": 20})
    # both pressure angles are 20 degrees, so that the force is tangential
    turned = 2.0 * 10.0 * np.cos(np.radians(20.0))
    exact = LEVERS if contact == "lumped" else SQUARES
    np.testing.assert_allclose(equal.planet_load_share, plain.planet_load_share, rtol=exact)
    np.testing.assert_allclose(
        equal.transmission_error_um - plain.transmission_error_um, turned, rtol=exact
    )
    loose = stage(**changes, stage={"pin_clearance_um": [30, 20, 20, 20], "floating": "none"})
    late = stage(
        **changes,
        stage={"pin_tangential_errors_um": [-15, -10, -10, -10], "floating": "none"},
    )
    np.testing.assert_allclose(loose.planet_load_share, late.planet_load_share, rtol=exact)
    assert loose.planet_load_share[0, 0] < 0.2


def test_a_planet_with_much_clearance_carries_nothing():
    """The three others hold a floating sun as a lever does: one of them carries nothing, too."""
    keys = {"pin_clearance_um": [200, 20, 20, 20]}
    touching, found = stage(positions=SMOOTH, load={"torque_Nm": [0, 50]}, stage=keys)
    assert not found.status.any()
    expected = np.tile([0.0, 0.5, 0.0, 0.5], (2, 1))
    np.testing.assert_allclose(found.planet_load_share, expected, atol=1e-3)
    turned = 2.0 * 10.0 * np.cos(np.radians(20.0))
    np.testing.assert_allclose(touching.transmission_error_um, turned, rtol=SQUARES)


def test_files_name_planets():
    """Heads said "pair" for planets."""
    found = stage(positions={"count": None, "angles_deg": [1.8]})
    assert found.to_xarray()["site"].attrs["long_name"] == "planet number"
