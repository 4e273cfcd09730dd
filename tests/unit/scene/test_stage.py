"""Tables of planetary stages and their refusals."""

import pytest

import flankload as fl
from tests.support.planetary_stages import four, scene_of

HELICAL = {"helix_angle_deg": 10, "hand": "right"}


def refused(**changes):
    with pytest.raises(fl.SceneError) as error:
        scene_of(**changes)
    return str(error.value)


def test_a_stage_reads_and_writes_itself():
    scene = scene_of(stage={"pin_tangential_errors_um": [20, 0, 0, 0]})
    assert scene.stage is not None
    assert scene.stage.nominal_angles_deg == (0.0, 90.0, 180.0, 270.0)
    assert fl.Scene.from_dict(scene.to_dict()) == scene


def test_a_typed_stage_equals_its_scene():
    scene = fl.Scene.from_dict(
        four(effects=None, positions=None, accuracy=None, body_2={"outer_diameter_mm": 204.0})
    )
    typed = fl.PlanetaryStage(
        fl.Gear(teeth=25, module_mm=3, tip_diameter_mm=3 * 26.9, bore_diameter_mm=30),
        fl.Gear(teeth=17, module_mm=3, tip_diameter_mm=3 * 18.9, bore_diameter_mm=24),
        fl.Ring(
            teeth=59,
            module_mm=3,
            tip_diameter_mm=172.8,
            root_diameter_mm=184.5,
            outer_diameter_mm=204,
        ),
        planets=4,
        floating="sun",
        center_distance_mm=63,
        face_width_mm=20,
        torque_Nm=600,
        name="four planets in turn",
    )
    assert typed.to_scene() == scene


def test_the_centre_distance_follows_from_sun_and_planet():
    scene = scene_of(pair={"center_distance_mm": None})
    assert scene.pair.center_distance_mm == pytest.approx(63.0, rel=1e-12)


def test_a_long_relief_of_the_ring_refers_to_its_mesh_with_the_planet():
    keys = {"tip_relief_um": 20, "tip_relief_length": "long"}
    scene = scene_of(body_2=keys)
    start = scene.body_2.tip_relief_start_diameter_mm
    assert 172.8 < start < 184.5


def test_a_broken_assembly_condition_names_the_nearest_angles():
    text = refused(stage={"planets": 5})
    assert "68.57142857 and 72.85714286" in text
    text = refused(stage={"planets": None, "angles_deg": [0, 90, 181, 270]})
    assert "stage.angles_deg[2]" in text
    assert "180 and 184.2857143" in text


def test_rounded_angles_are_assembled():
    angles = [0, 85.7142857, 180, 265.7142857]
    scene = scene_of(stage={"planets": None, "angles_deg": angles})
    from flankload.scene.stage import assembled_places

    assert assembled_places(scene.stage, 84) == (0, 20, 42, 62)


def test_planets_that_collide():
    assert "28.0376" in refused(stage={"planets": 14})


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"planet": None}, "planet: expected a table, beside [stage], found nothing"),
        ({"stage": None}, "stage: expected a table, beside [planet], found nothing"),
        (
            {"stage": {"ring_support": "free"}},
            "a free rim floats beside the floating sun, so that the position of both",
        ),
        (
            {"stage": {"floating": "none", "ring_support": "free"}},
            "nothing centres a free rim, found 'free'",
        ),
        (
            {"stage": {"floating": "ring", "sun_weight_N": 5}},
            "stage.sun_weight_N: expected nothing, unless stage.floating is 'sun'",
        ),
        (
            {"stage": {"pin_radial_errors_um": [1, 2]}},
            "stage.pin_radial_errors_um: expected one entry per planet: 4, found 2 entries",
        ),
        (
            {"stage": {"pin_clearance_um": [20, 20]}},
            "stage.pin_clearance_um: expected one entry per planet: 4, found 2 entries",
        ),
        ({"stage": {"angles_deg": [0, 90]}}, "either planets or angles_deg, found both"),
        (
            {"effects": {"friction_coefficient": 0.1}},
            "that friction between several meshes has one solution is not proven",
        ),
        ({"effects": {"choose": "auto"}}, "the choice of effects compares runs of a pair"),
        (
            {
                "stage": {"ring_support": "bolts", "bolts": 8, "bolt_stiffness_N_per_um": 50},
                "effects": {"root_stress": True},
            },
            "effects.root_stress: expected false with stage.ring_support = 'bolts'",
        ),
        (
            {"planet": {"helix_angle_deg": 10, "hand": "left"}},
            "planet.helix_angle_deg: expected 0, as in body_1.helix_angle_deg (parallel axes)",
        ),
        (
            {"body_1": HELICAL, "planet": {**HELICAL, "hand": "left"}, "body_2": HELICAL},
            "body_2.hand: expected 'left', as planet.hand, since body_2 has internal teeth",
        ),
        (
            {"planet": {"shaft": {"compliance": [[0.0] * 6] * 6}}, "effects": {"dimension": 3}},
            "planet.shaft: expected nothing with [stage]: the members of a stage are on the sup",
        ),
        (
            {"stage": {"planet_ring_flank": {"end_relief_um": [5, 5]}}},
            "stage.planet_ring_flank.end_relief_length_mm: expected a list of 2 numbers",
        ),
        (
            {"pair": {"inclination_um_per_mm": 0.1}},
            "pair.inclination_um_per_mm: expected nothing with [stage], which has several axes",
        ),
        ({"planet": {"module_mm": 3.1}}, "planet.module_mm: expected 3, as in body_1.module_mm"),
        (
            {"load": {"torque_Nm": 0}, "stage": {"sun_weight_N": 5}},
            "load.torque_Nm: expected a number > 0 with stage.sun_weight_N",
        ),
        ({"stage": {"ring_support": "bolts"}}, "stage.bolts: expected a value, with stage.ring_s"),
        (
            {"stage": {"bolts": 8}},
            "stage.bolts: expected nothing, unless stage.ring_support is 'bolts', found 8",
        ),
        (
            {
                "stage": {
                    "ring_support": "bolts",
                    "bolts": 8,
                    "bolt_stiffness_N_per_um": 50,
                    "floating": "ring",
                }
            },
            "stage.floating: expected 'none', 'sun' or 'carrier': bolts hold the ring, found",
        ),
        (
            {
                "stage": {"ring_support": "bolts", "bolts": 8, "bolt_stiffness_N_per_um": 50},
                "body_2": {"rigid": True},
            },
            "body_2.rigid: expected false, with stage.ring_support = 'bolts'",
        ),
        (
            {"stage": {"floating": "carrier", "ring_support": "free"}},
            "a free rim floats beside the floating carrier",
        ),
        (
            {"stage": {"planets": None, "angles_deg": [0, 90, 180]}},
            "unless there are planets on all sides of the axis: nothing else holds the sun",
        ),
        ({"positions": {"adaptive": True}}, "positions.adaptive: expected false with [stage]"),
    ],
)
def test_refusals(changes, line):
    assert line in refused(**changes)
