"""Planetary stages in three dimensions: limits, statics, symmetries, tilts."""

import numpy as np
import pytest

import flankload as fl
from flankload.contact.meshes_contact import sweep_displaced
from flankload.errors import SceneError
from flankload.mechanisms.registry import mechanism_of
from flankload.mechanisms.several.states import counted_work
from flankload.mechanisms.stage.assembly import NAMES, assemble
from flankload.mechanisms.stage.states import compliances_of
from flankload.mechanisms.stage_clock import StageClock
from flankload.mechanisms.toggles import toggled
from tests.support.paths import SCENES
from tests.support.solving import solve
from tests.support.stages_with_width import stage, wide
from tests.support.tolerances import SOLVER

#: Levers of flanks whose curves are accurate to 1e-9 mm (measured 4e-11).
LEVERS = 1e-9
#: Curves that are evaluated at other angles.
TURNED = 1e-11
#: Change by a rotation of 20 um, which moves contacts along the flanks (measured 3e-5).
MOVED = 1e-4
KINDS = ("sun", "ring")
#: Forces on edges of elements, which are chords of the flanks.
FLANKS = 2e-3
TILTING = {"pin_tilt_stiffness_Nm_per_mrad": 50}


def line_loads(found, planet, kind):
    """(J,) Forces of all flanks of a mesh at the first position."""
    return found.mesh(planet, kind).slices.force_N[0].sum(axis=0)


def test_a_stage_without_helix_is_the_plane_stage():
    """It lies between plane strain and plane stress; a vanishing helix angle changes nothing."""
    spur = stage(0.0)
    bounds = [
        solve(
            fl.Scene.from_dict(
                {
                    name: {key: value for key, value in keys.items() if key not in SOLID}
                    if isinstance(keys, dict)
                    else keys
                    for name, keys in wide(0.0, accuracy={"plane": plane}).items()
                }
            )
        ).transmission_error_um[0]
        for plane in ("strain", "stress")
    ]
    assert bounds[0] < spur.transmission_error_um[0] < bounds[1]
    nearly = stage(1e-4)
    np.testing.assert_allclose(nearly.transmission_error_um, spur.transmission_error_um, rtol=1e-6)
    assert spur.mesh_load_factor[0] == pytest.approx(nearly.mesh_load_factor[0], abs=1e-8)


#: Keys that a plane scene does not have.
SOLID = ("dimension", "slices", "axial_degree", "load_degree_z")


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_statics_of_a_helical_stage(contact):
    """Torques, axial forces M tan(beta)/r, and the moment that tilts a planet."""
    found = stage(stage=TILTING, effects={"contact": contact})
    exact = LEVERS if contact == "lumped" else 1e-5  # cells past the end of an involute
    radius = 0.5 * 25 * 3.0 / np.cos(np.radians(15.0))
    axial = 450e3 * np.tan(np.radians(15.0)) / radius
    loads = found.stage
    np.testing.assert_allclose(found.ring_torque_Nm, 450 * 59 / 25, rtol=exact)
    np.testing.assert_allclose(loads.sun_axial_force_N, axial, rtol=LEVERS)
    np.testing.assert_allclose(loads.ring_axial_force_N, -axial, rtol=exact)
    np.testing.assert_allclose(loads.planet_axial_force_N, 0.0, atol=exact * axial)
    moments = np.zeros((3, 2))
    for j, kind in ((j, kind) for j in range(3) for kind in KINDS):
        mesh, sense = found.mesh(j + 1, kind), 1 if kind == "sun" else -1
        x, y, across, up, force, z = _columns(mesh.pair_tables[0])
        # of the frame of the mesh with its body 1 at the origin; the force is that on body 2
        slope = -mesh.drawing.axial[0].twist_rad_per_mm * (x * up - y * across)
        force = sense * force / np.hypot(1.0, slope)
        x = x - mesh.drawing.center_distance_mm if kind == "sun" else x
        in_mesh = np.array(
            [np.sum(force * (y * slope - z * up)), np.sum(force * (z * across - x * slope))]
        )
        angle = found.stage.planet_angles_rad[j] + (0.0 if kind == "sun" else np.pi)
        # a moment is an axial vector, which changes its sign in a mirror image
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        moments[j] += turn @ (in_mesh * [sense, 1.0] if sense > 0 else in_mesh * [-1.0, 1.0])
    np.testing.assert_allclose(loads.planet_moment_Nm[0], moments / 1000, atol=1e-9 * axial)
    np.testing.assert_allclose(
        loads.planet_tilt_urad, loads.planet_moment_Nm * 1000 / 50, rtol=SOLVER
    )


def test_bearings_carry_forces_and_moments_of_planets():
    """A linear distribution with their resultants; one pin displaced along its force is late."""
    loose = {**TILTING, "pin_clearance_um": [10, 0, 0], "pin_bearing_width_mm": 16}
    found = stage(stage={**loose, "floating": "none"})
    at_ends, width = found.stage.pin_line_force_N_per_mm, 16.0
    forces = found.stage.pin_force_N
    np.testing.assert_allclose(at_ends.mean(axis=2) * width, forces, atol=LEVERS)
    (x, y), (about_x, about_y) = (
        np.moveaxis(part, -1, 0)
        for part in (at_ends[:, :, 1] - at_ends[:, :, 0], 1000 * found.stage.planet_moment_Nm)
    )
    np.testing.assert_allclose(x * width**2 / 12, about_y, rtol=LEVERS)
    np.testing.assert_allclose(y * width**2 / 12, -about_x, rtol=LEVERS)
    assert found.summary["pin_line_force_max_N_per_mm"] == np.hypot(*at_ends.T).max()
    late = {**TILTING, "pin_tangential_errors_um": [-5, 0, 0], "floating": "none"}
    np.testing.assert_allclose(found.load_share, stage(stage=late).load_share, rtol=MOVED)


def _columns(table):
    names = ("x_mm", "y_mm", "normal_x", "normal_y", "force_N", "z_mm")
    return (getattr(table, name) for name in names)


@pytest.mark.parametrize(
    "tilting",
    [
        {},
        {**TILTING, "ring_support": "bolts", "bolts": 9, "bolt_stiffness_N_per_um": 100},
    ],
)
def test_planets_in_phase_are_alike(tilting):
    """Symmetric: equal shares, line loads and tilts, turned from planet to planet."""
    per = 1 / np.cos(np.radians(15.0))
    found = stage(
        body_1={"teeth": 24, "tip_diameter_mm": 72 * per + 5.4},
        planet={"teeth": 18, "tip_diameter_mm": 54 * per + 5.4},
        body_2={
            "teeth": 60,
            "tip_diameter_mm": 180 * per - 4.2,
            "root_diameter_mm": 180 * per + 7.5,
            "outer_diameter_mm": 180 * per + 27,
        },
        pair={"center_distance_mm": 63 * per},
        stage=tilting,
    )
    np.testing.assert_allclose(found.load_share, 1 / 3, rtol=TURNED)
    assert np.abs(found.sun_orbit_um).max() < 1e-9
    for kind in KINDS:
        first = line_loads(found, 1, kind)
        for j in (2, 3):
            np.testing.assert_allclose(
                line_loads(found, j, kind), first, rtol=0, atol=TURNED * first.max()
            )
    tilts = found.stage.planet_tilt_urad[0] @ [1, 1j] * np.exp(-2j * np.pi * np.arange(3) / 3)
    np.testing.assert_allclose(tilts, tilts[0], rtol=TURNED)
    loads = [found.mesh(1, kind).summary["peak_line_load_N_per_mm"] for kind in KINDS]
    assert found.summary["peak_line_load_N_per_mm"] == pytest.approx(max(loads), rel=TURNED)
    assert "sun_orbit" not in found.engagement.pictures(found)
    assert abs(tilts[0]) > 100 if tilting else abs(tilts[0]) == 0


def test_the_other_hand_is_a_mirror_image_over_the_width():
    slopes = {"body_1": 8.0, "planet": -5.0, "body_2": 3.0}
    offsets = {"body_1": 1.0, "planet": -0.5, "body_2": 0.0}

    def found(hand):
        keys = {
            name: {"helix_slope_um": hand * slope, "axial_offset_mm": hand * offsets[name]}
            for name, slope in slopes.items()
        }
        return stage(15.0, hand, **keys, stage=TILTING)

    right, left = found(1), found(-1)
    np.testing.assert_allclose(left.transmission_error_um, right.transmission_error_um, rtol=TURNED)
    for kind in KINDS:
        forces = line_loads(right, 2, kind)
        np.testing.assert_allclose(
            line_loads(left, 2, kind)[::-1], forces, rtol=0, atol=1e-10 * forces.max()
        )


def test_one_planet_is_two_pairs_in_three_dimensions():
    """Line loads of the internal and of the external pair; a rigid planet couples no flanks."""
    single = stage(
        planet={"rigid": True},
        stage={"planets": 1, "floating": "none"},
        load={"torque_Nm": 150},
    )
    scene = wide(planet={"rigid": True})
    approach = 0.0
    for kind, names, ratio in (
        ("sun", ("body_1", "planet"), 1.0),
        ("ring", ("planet", "body_2"), 17 / 25),
    ):
        mesh = single.mesh(1, kind)
        pair = {key: scene[key] for key in ("pair", "effects", "accuracy")}
        pair |= {f"body_{z + 1}": dict(scene[name]) for z, name in enumerate(names)}
        if kind == "ring":  # in the mirror image
            for z in (1, 2):
                pair[f"body_{z}"]["hand"] = "right"
        pair["load"] = {"torque_Nm": 150 * ratio}
        pair["positions"] = {"angles_deg": mesh.position_deg.tolist()}
        own = solve(fl.Scene.from_dict(pair))
        approach += own.transmission_error_um
        forces = own.slices.force_N
        np.testing.assert_allclose(mesh.slices.force_N, forces, rtol=0, atol=1e-8 * forces.max())
        assert mesh.slices.face_load_factor == pytest.approx(own.slices.face_load_factor, rel=1e-8)
    np.testing.assert_allclose(single.transmission_error_um, approach, rtol=1e-8)


def test_opposite_slopes_of_all_bodies_cancel():
    """Metal is removed evenly from both flanks of a planet: only the sun turns."""
    plain = stage()
    slopes = {"body_1": -10.0, "planet": 10.0, "body_2": -10.0}
    sloped = stage(**{name: {"helix_slope_um": slope} for name, slope in slopes.items()})
    change = sloped.transmission_error_um - plain.transmission_error_um
    np.testing.assert_allclose(change, 20.0, rtol=MOVED)
    for kind in KINDS:
        forces = line_loads(plain, 1, kind)
        np.testing.assert_allclose(
            line_loads(sloped, 1, kind), forces, rtol=0, atol=MOVED * forces.max()
        )
    alone = stage(planet={"helix_slope_um": 10.0})
    assert (alone.stage.mesh_face_load_factor > plain.stage.mesh_face_load_factor + 0.03).all()


def test_both_flanks_of_a_planet():
    """A slope of the flanks in mesh with the ring, against that of the ring: the other is plain."""
    plain = stage()
    sloped = stage(
        body_2={"helix_slope_um": -10.0}, stage={"planet_ring_flank": {"helix_slope_um": 10.0}}
    )
    change = sloped.transmission_error_um - plain.transmission_error_um
    np.testing.assert_allclose(change, 10.0, rtol=MOVED)
    for kind in KINDS:
        forces = line_loads(plain, 1, kind)
        np.testing.assert_allclose(
            line_loads(sloped, 1, kind), forces, rtol=0, atol=MOVED * forces.max()
        )
    # instead of those of [planet]
    one = stage(planet={"lead_crowning_um": 8.0}, stage={"planet_ring_flank": {}})
    sun, ring = (one.stage.mesh_face_load_factor - plain.stage.mesh_face_load_factor)[:, 0]
    assert sun > 0.05
    assert abs(ring) < 0.3 * sun


def test_each_mesh_has_an_estimate():
    """It covers the change by twice as many slices; without torque there is no estimate."""
    scene = {"stage": TILTING, "load": {"torque_Nm": [0, 450]}}
    rough = solve(fl.Scene.from_dict(wide(**scene, accuracy={"estimate": True})))
    fine = stage(stage=TILTING, accuracy={"slices": 10})
    for kind in KINDS:
        mesh, finer = rough[1].mesh(1, kind), fine.mesh(1, kind)
        change = mesh.slices.face_load_factor / finer.slices.face_load_factor - 1
        assert abs(change) < mesh.estimate["face_load_factor"] < 1.0
        assert rough[0].mesh(1, kind).estimate is None
    assert "meshes" not in rough[1].estimate


def test_positions_of_a_stage_have_an_error():
    """It covers the change of mean and peak to peak by eight times as many positions."""
    one = wide(accuracy={"estimate": True})
    assert "positions" not in solve(fl.Scene.from_dict(one)).estimate["by_source"]
    few, many = (
        solve(fl.Scene.from_dict(one | {"positions": {"count": count}})) for count in (4, 32)
    )
    errors = few.estimate["by_source"]["positions"]
    for name in ("transmission_error_mean", "transmission_error_peak_to_peak"):
        one, two = (result.summary[f"{name}_um"] for result in (few, many))
        assert 0.0 < abs(two / one - 1.0) < errors[name]
    assert "face_load_factor" in few.mesh(1, "sun").estimate["by_source"]["positions"]


def test_a_sun_that_tilts():
    """Planets in turn load it unevenly; a stiff spring holds it."""
    rigid = stage(stage={"floating": "none"})
    soft, held = (
        stage(stage={"floating": "none", "sun_tilt_stiffness_Nm_per_mrad": stiffness})
        for stiffness in (0.1, 1e9)
    )
    np.testing.assert_allclose(held.transmission_error_um, rigid.transmission_error_um, rtol=1e-8)
    np.testing.assert_allclose(
        held.stage.mesh_face_load_factor, rigid.stage.mesh_face_load_factor, rtol=1e-8
    )
    assert np.hypot(*soft.stage.sun_tilt_urad[0]) > 10.0
    assert soft.transmission_error_um[0] > rigid.transmission_error_um[0]


ROOTS = {"effects": {"root_stress": True}}
#: Most of the difference of root stress in the plane and in the middle of 20 mm, with few modes.
PLANE_ROOTS = 0.07


@pytest.mark.parametrize("helix_deg", [0.0, 15.0])
def test_loads_on_coast_flanks_bend_roots_in_the_mirror_image(helix_deg):
    """A straight body is its mirror image; half a turn about a tooth reverses a helix along z."""
    scene = fl.Scene.from_dict(wide(helix_deg, **ROOTS))
    _, compliances = compliances_of(scene, assemble(scene), StageClock(None, NAMES, 1, {}), {})
    own = compliances[1]
    found, image = own.root.response, own.root.in_mirror_image().response
    functions, modes = np.ogrid[: found.shape[2], : found.shape[3]]
    sign = (-1.0) ** (functions + modes % own.modes_per_place) if helix_deg else 1.0
    size = np.abs(found).max()
    np.testing.assert_allclose(image, sign * found, rtol=0, atol=1e-11 * size)


def test_root_stress_of_planets_over_their_width():
    """Without a helix it is that of the plane; extremes are taken over both meshes of a tooth."""
    spur, helical = stage(0.0, **ROOTS), stage(stage=TILTING, **ROOTS)
    keys = wide(0.0, **ROOTS)
    plane = solve(
        fl.Scene.from_dict(
            {
                name: {key: value for key, value in table.items() if key not in SOLID}
                if isinstance(table, dict)
                else table
                for name, table in keys.items()
            }
        )
    )
    np.testing.assert_allclose(
        spur.stage.planet_bending.range_MPa, plane.stage.planet_bending.range_MPa, rtol=PLANE_ROOTS
    )
    for kind, z in ((kind, z) for kind in KINDS for z in (0, 1)):
        one, two = (each.mesh(1, kind).root_stress[z].tension for each in (spur, plane))
        np.testing.assert_allclose(one.stress_MPa, two.stress_MPa, rtol=1.5 * PLANE_ROOTS)
        np.testing.assert_array_equal(one.working, two.working)
    bending = helical.stage.planet_bending
    # a tooth of 17 has load on one flank only: forces of the other mesh are far away
    for kind, z in (("sun", 1), ("ring", 0)):
        for extreme, sign in (("tension", 1.0), ("compression", -1.0)):
            alone = [
                (sign * getattr(helical.mesh(j, kind).root_stress[z], extreme).stress_MPa).max()
                for j in (1, 2, 3)
            ]
            found = bending.largest_MPa if sign > 0 else -bending.least_MPa
            assert (found.max(axis=1) > 0.95 * np.array(alone)).all()
    assert helical.summary["planet_root_stress"]["z_mm"] in bending.z_mm


def test_the_work_of_the_elements_is_predicted():
    """Also that of the coast flanks of planets and ring."""
    scene = fl.Scene.from_dict(wide(body_1={"rigid": True}, **ROOTS))
    stages = fl.solve(scene).cost["stages"]
    for name, predicted in counted_work(scene, assemble(scene)).items():
        found = stages[name]["counters"] | {"bytes": stages[name]["bytes"]}
        assert {key: found.get(key, 0) for key in predicted} == dict(predicted), name


def test_a_free_rim_over_its_width():
    """It lies between plane strain and plane stress, and far from a clamped rim."""
    free = {"stage": {"floating": "ring", "ring_support": "free"}}
    found = stage(0.0, **free)
    bounds = [
        solve(
            fl.Scene.from_dict(
                {
                    name: {key: value for key, value in keys.items() if key not in SOLID}
                    if isinstance(keys, dict)
                    else keys
                    for name, keys in wide(0.0, accuracy={"plane": plane}, **free).items()
                }
            )
        ).transmission_error_um[0]
        for plane in ("strain", "stress")
    ]
    assert bounds[0] < found.transmission_error_um[0] < bounds[1]
    assert bounds[0] > 2 * stage(0.0).transmission_error_um[0]
    deflection = found.ring_deflection_um[0]
    # under three planets it is pushed outwards, between them inwards, without a motion of its own
    assert deflection[0] > 0.0 > deflection[10]
    turns = np.exp(2j * np.pi * np.arange(59) / 59)
    assert abs(turns @ deflection) < 1e-2 * np.abs(deflection).sum()
    helical = stage(**free)
    np.testing.assert_allclose(helical.ring_torque_Nm, 450 * 59 / 25, rtol=LEVERS)


def test_bolts_of_a_ring_with_width():
    """Soft equal ones move by the force on the ring; stiff ones of a spur ring are a clamp."""
    keys = {"floating": "none", "pin_tangential_errors_um": [20, 0, 0], "ring_support": "bolts"}
    for helix in (0.0, 15.0):
        soft = {"bolts": 59, "bolt_stiffness_N_per_um": 10}
        found = stage(helix, stage={**keys, **soft})
        on_ring = (found.planet_force_N - found.pin_force_N).sum(axis=1)
        # forces are projected onto the pressure modes, bolts onto polynomials
        largest = np.abs(found.planet_force_N).max()
        np.testing.assert_allclose(590 * found.ring_orbit_um, on_ring, atol=1e-3 * largest)
        assert found.ring_deflection_um[0, 0] > 0.0
    stiff = stage(0.0, stage={**keys, "bolts": 59, "bolt_stiffness_N_per_um": 1e8})
    clamped = stage(0.0, stage={**keys, "ring_support": "clamped"})
    # bolts hold the means of the sectors only
    np.testing.assert_allclose(
        stiff.transmission_error_um, clamped.transmission_error_um, rtol=0.02
    )


#: An elastic carrier whose webs twist.
CARRIER = {
    "plate_distance_mm": 36,
    "pin_diameter_mm": 22,
    "torsional_stiffness_Nm_per_mrad": 200,
    "torque_end": "I",
}
#: Under a light load, springs and known errors differ at the ends of contact lines only, where the
#: normals of both flanks do (measured 7e-5).
LIGHT, KNOWN = {"torque_Nm": 4.5}, 1e-4


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_pins_displaced_by_their_load_are_pins_with_errors(contact):
    """Carrier, bearings and known errors move flanks in the same way."""
    springs = {"carrier": CARRIER, "pin_stiffness_N_per_um": 500, **TILTING}
    soft = stage(stage=springs, load=LIGHT, effects={"contact": contact})
    scene = fl.Scene.from_dict(wide(stage=springs))
    assembly = assemble(scene)
    compliance = assembly.supports.compliances(assembly.pairing)[1:-1, :, 1:-1]
    wrenches = np.zeros((3, 6))
    wrenches[:, :2], wrenches[:, 2] = soft.pin_force_N[0], soft.stage.planet_axial_force_N[0]
    wrenches[:, 3:5] = 1000 * soft.stage.planet_moment_Nm[0]
    moved = np.einsum("ixjy,jy->ix", compliance, wrenches)
    np.testing.assert_allclose(soft.stage.planet_tilt_urad[0], 1e6 * moved[:, 3:5], rtol=KNOWN)
    angle = soft.stage.planet_angles_rad
    inwards = -np.stack([np.cos(angle), np.sin(angle)], axis=1)
    against = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    slopes = np.stack([moved[:, 4], -moved[:, 3]], axis=1)
    errors = {}
    for along, direction in (("radial", inwards), ("tangential", against)):
        errors[f"pin_{along}_errors_um"] = 1e3 * (moved[:, :2] * direction).sum(axis=1)
        errors[f"pin_{along}_inclinations_um_per_mm"] = 1e3 * (slopes * direction).sum(axis=1)
    errors = {name: values.tolist() for name, values in errors.items()}
    rigid = stage(stage=errors, load=LIGHT, effects={"contact": contact})
    np.testing.assert_allclose(rigid.transmission_error_um, soft.transmission_error_um, rtol=KNOWN)
    for kind in KINDS:
        forces = line_loads(soft, 1, kind)
        np.testing.assert_allclose(
            line_loads(rigid, 1, kind), forces, rtol=0, atol=KNOWN * forces.max()
        )


def test_a_carrier_that_twists():
    """The load moves to the plate that does not turn; a spur stage seen from the other end."""
    one, other = (
        stage(0.0, stage={"carrier": {**CARRIER, "torque_end": end}}) for end in ("I", "II")
    )
    rigid = stage(0.0, stage={"carrier": {**CARRIER, "torsional_stiffness_Nm_per_mrad": 1e9}})
    np.testing.assert_allclose(one.transmission_error_um, other.transmission_error_um, rtol=1e-10)
    for kind in KINDS:
        forces = line_loads(one, 1, kind)
        np.testing.assert_allclose(
            line_loads(other, 1, kind)[::-1], forces, rtol=0, atol=1e-10 * forces.max()
        )
        assert forces[0] > 1.1 * forces[-1]
    assert (one.stage.mesh_face_load_factor > 1.05 * rigid.stage.mesh_face_load_factor).all()
    turned = one.stage.planet_tilt_urad[0] @ [1, 1j] * np.exp(-1j * one.stage.planet_angles_rad)
    assert np.abs(turned).min() > 10.0


def test_designs_of_a_helical_stage_share_their_positions():
    """Regression: crownings were divided by the levers of slices instead of the section."""
    scenes = [
        fl.Scene.from_dict(
            wide(body_1={"lead_crowning_um": 10.0}, stage={"pin_tangential_errors_um": [e, 0, 0]})
        )
        for e in (0.0, 5.0)
    ]
    assemblies = [assemble(scene) for scene in scenes]
    alone = [solve(scene).transmission_error_um for scene in scenes]
    clock = StageClock(None, NAMES, 1, {})
    assembly, compliances = compliances_of(scenes[0], assemblies[0], clock, {})
    contacts = [one.contact(scenes[0], compliances) for one in assemblies]
    found = sweep_displaced(contacts, assembly.position_rad, scenes[0].torques_Nmm)
    radius = assembly.bodies[0].reference_radius_mm
    for (sweep,), one in zip(found, alone, strict=True):
        np.testing.assert_allclose(1000 * radius * sweep.whole.rotation_rad, one, rtol=1e-8)


def test_the_plane_section_of_a_helical_stage():
    """Regression: its planets were helical, so the plan of a stage ended in an error."""
    keys = {"carrier": CARRIER, "pin_radial_inclinations_um_per_mm": [1.0, 0.0, 0.0]}
    scene = fl.Scene.from_dict(wide(stage=keys))
    section = toggled(scene, "three_dimensions", on=True).scene
    assert section.planet.helix_angle_deg == 0.0
    assert section.stage.carrier is None
    plane = solve(section).transmission_error_um[0]
    assert plane == pytest.approx(stage().transmission_error_um[0], rel=0.1)


def test_fields_of_all_bodies_are_in_equilibrium():
    """Forces on the elements of a mesh's bodies are equal and opposite, on a common line."""
    scene = fl.Scene.from_dict(wide(stage={"pin_tangential_errors_um": [20, 0, 0]}))
    found, moments = solve(scene), []
    for body in mechanism_of(scene).fields_of_bodies(scene).values():
        fields = body.at(found, 0)
        moments.append(np.cross(fields.points_mm, fields.force_N).sum(axis=0) / 1000.0)
        assert (fields.force_N * fields.displacement_mm).sum() > 0.0
    assert moments[0][2] == pytest.approx(-450.0, rel=FLANKS)
    np.testing.assert_allclose(sum(moments), 0.0, atol=FLANKS * np.abs(moments[1]).max())


@pytest.mark.parametrize(
    ("name", "key", "value", "expected"),
    [
        ("helical_stage", "stage.pin_bearing_width_mm", 21, "the width of the planets, 20 mm"),
        ("planetary_stage", "stage.pin_bearing_width_mm", 21, "the width of the planets, 20 mm"),
        ("double_helical", "train.groove_diameter_mm", 90, "the tip diameter of body_1, 88.1 mm"),
    ],
)
def test_impossible_sizes_are_refused(name, key, value, expected):
    scene = fl.read_scene(SCENES / f"{name}.toml").replace({key: value})
    message = f"{name}.toml: {key}: expected at most {expected}, found {value} mm"
    with pytest.raises(SceneError, match=message):
        fl.solve(scene)
