"""Tables of gear trains and their refusals."""

from typing import Any

import pytest

import flankload as fl
from tests.support.planetary_stages import gear

KINDS = {"idler": (20, 33, 27), "two_pinions": (60, 20, 20), "double_helical": (20, 33)}
#: Keys of helices.
RIGHT, LEFT = ({"helix_angle_deg": 15, "hand": hand} for hand in ("right", "left"))
HELICES = {"body_1": RIGHT, "body_2": LEFT, "body_3": None}


def scene_of(kind: str, **changes: Any) -> fl.Scene:
    """A train; other tables by name, None removes one."""
    bodies = {f"body_{k + 1}": gear(z, 3, 1.8, 20) for k, z in enumerate(KINDS[kind])}
    tree: dict[str, Any] = {
        **bodies,
        "train": {"kind": kind},
        "pair": {"face_width_mm": 20},
        "load": {"torque_Nm": 200},
    }
    for name, keys in changes.items():
        tree[name] = {**tree.get(name, {}), **keys} if isinstance(keys, dict) else keys
    return fl.Scene.from_dict({name: keys for name, keys in tree.items() if keys is not None})


def test_distances_without_backlash_are_those_of_both_meshes():
    scene = scene_of("idler")
    assert scene.train is not None
    assert scene.pair.center_distance_mm == pytest.approx(1.5 * (20 + 27), rel=1e-12)
    assert scene.train.center_distance_2_mm == pytest.approx(1.5 * (27 + 33), rel=1e-12)
    assert fl.Scene.from_dict(scene.to_dict()) == scene
    assert "center_distance_2_mm" not in scene.to_dict()["train"]


def test_a_long_relief_of_body_2_refers_to_its_own_mesh():
    keys = {"tip_relief_um": 20, "tip_relief_length": "long"}
    ends = [
        scene_of("idler", body_2=keys, body_1=other).body_2.tip_relief_start_diameter_mm
        for other in ({}, {"teeth": 24, "tip_diameter_mm": 3 * 25.8})
    ]
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "changes", "line"),
    [
        ("idler", {"body_3": None}, "body_3: expected a table, beside [train], found nothing"),
        ("idler", {"train": None}, "train: expected a table, beside [body_3], found nothing"),
        ("idler", {"body_2": {"kind": "ring"}}, "body_2"),
        (
            "idler",
            {"train": {"floating": True}},
            "train.floating: expected nothing with train.kind = 'idler', found true",
        ),
        (
            "idler",
            {"train": {"timing_error_um": 5}},
            "train.timing_error_um: expected nothing with train.kind = 'idler', found 5",
        ),
        (
            "two_pinions",
            {"train": {"floating": True, "angle_deg": 90}},
            "train.angle_deg: expected 180 with train.floating: otherwise no position balances",
        ),
        (
            "two_pinions",
            {"train": {"floating": True, "bearing_stiffness_N_per_um": 5}},
            "train.bearing_stiffness_N_per_um: expected nothing with train.floating, found 5",
        ),
        (
            "two_pinions",
            {"body_3": {"module_mm": 4}},
            "body_3.module_mm: expected 3, as in body_1.module_mm",
        ),
        (
            "idler",
            {"body_1": {"rigid": True}, "body_3": {"rigid": True}},
            "body_3.rigid: expected false, since body_1.rigid is true, found true",
        ),
        (
            "idler",
            {"body_1": RIGHT, "body_3": LEFT, "body_2": LEFT},
            "body_2.hand: expected 'right', the opposite of body_3.hand, found 'left'",
        ),
        (
            "two_pinions",
            {"pair": {"deviation_um_per_mm": 0.1}},
            "pair.deviation_um_per_mm: expected nothing with this [train], which has several axes",
        ),
        (
            "idler",
            {"train": {"groove_width_mm": 10}},
            "train.groove_width_mm: expected nothing with train.kind = 'idler', found 10",
        ),
        (
            "double_helical",
            HELICES,
            "train.groove_width_mm: expected a value with train.kind = 'double_helical'",
        ),
        (
            "double_helical",
            {"train": {"groove_width_mm": 10}},
            "body_1.helix_angle_deg: expected a number > 0 with train.kind = 'double_helical'",
        ),
        (
            "double_helical",
            {
                **HELICES,
                "body_1": {**RIGHT, "axial_offset_mm": 1},
                "train": {"groove_width_mm": 10},
            },
            "body_1.axial_offset_mm: expected 0 with train.kind = 'double_helical'",
        ),
        (
            "double_helical",
            {"body_3": gear(20, 3, 1.8, 20)},
            "body_3: expected nothing with train.kind = 'double_helical', found a table",
        ),
        (
            "idler",
            {"effects": {"friction_coefficient": 0.1}},
            "effects.friction_coefficient: expected nothing with [train]: that friction between",
        ),
        ("idler", {"positions": {"adaptive": True}}, "positions.adaptive: expected false with"),
    ],
)
def test_refusals(kind, changes, line):
    with pytest.raises(fl.SceneError) as error:
        scene_of(kind, **changes)
    assert line in str(error.value)
