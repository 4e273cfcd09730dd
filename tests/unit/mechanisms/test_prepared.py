"""Prepared scenes: the same bits as single runs, and elements only where a key reaches them."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.base.digest import digest_of
from flankload.bodies import Body
from flankload.elasticity.job_log import JobCost
from flankload.errors import PivotLimit
from flankload.flank import fit
from flankload.mechanisms import Earlier
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.reuse import MOST_PARTS, Parts, made_once
from flankload.scene.unmodified import UNMODIFIED, unmodified
from flankload.studies import prepared
from tests.support.gear_scenes import SCENE, example
from tests.support.mesh_files import COARSE_PINION, COARSE_WHEEL
from tests.support.paths import SCENES
from tests.support.scene_walk import BESIDE, other_values

#: Few positions, coarse elements and thin rims.
QUICK = {"accuracy.estimate": False, "positions": {"count": 2}}
#: Few cells, no tangents.
COARSE = {
    "accuracy.tangents": False,
    "accuracy.strips_per_half_width": 2.5,
    "accuracy.corner_strips_per_half_width": 2.5,
}
#: A rounding takes as long to place as the rest of its body; the walk rounds each body once.
SHARP = {"body_1.tip_radius_mm": None, "body_2.tip_radius_mm": None}
COARSE_3D = {
    "accuracy.axial_degree": 4,
    "accuracy.load_degree_z": 0,
    "accuracy.slices": 3,
    "accuracy.tangents": False,
}
BASES: dict[str, dict[str, Any]] = {
    "external_gear": {
        **{"accuracy.flank_element_mm": 6.0, "body_2.bore_diameter_mm": 85.0},
        "accuracy.tangents": False,
    },
    "helical_gear": {
        **{"accuracy.flank_element_mm": 8.0, "accuracy.modes": 3},
        **{"body_2.bore_diameter_mm": 160.0, **COARSE_3D},
    },
    "internal_gear": {
        **{"accuracy.flank_element_mm": 8.0, "body_2.outer_diameter_mm": 206.0, **COARSE},
        **SHARP,
    },
    "spline": {
        **{"accuracy.flank_element_mm": 4.0, "body_1.bore_diameter_mm": 36.0, **COARSE},
        **SHARP,
    },
    "cam": {
        **{"accuracy.flank_element_mm": 12.0, "positions": {"angles_deg": [40.0, 200.0]}, **COARSE}
    },
    "external_gear_mesh_profile": {
        **{"body_1.file": str(COARSE_PINION), "body_2.file": str(COARSE_WHEEL)},
        **COARSE,
    },
    "external_gear_compliance": COARSE,
}
#: Keys that reach the elements of a body, by the end of their path: section, material, holding,
#: modes. All others must not.
OF_BODY = (
    *("teeth", "module_mm", "pressure_angle_deg", "profile_shift", "tip_diameter_mm"),
    *("addendum_factor", "tip_alteration_factor"),
    *("tip_radius_mm", "tip_chamfer_mm", "dedendum_factor", "fillet_radius_factor"),
    *(
        "bore_diameter_mm",
        "bore",
        "rim",
        "root_diameter_mm",
        "outer_diameter_mm",
        "root_fillet_radius_mm",
    ),
    *("young_modulus_MPa", "poisson_ratio", "rigid", "helix_angle_deg", "face_width_mm"),
    *("material", "tooth_thickness_allowance_um", "span_measurement_mm", "span_teeth"),
    *("ball_measurement_mm", "measuring_ball_mm", "protuberance_mm", "protuberance_angle_deg"),
    "grinding_stock_mm",
    *("axial_offset_mm", "arm_mm", "arm_width_mm", "roller_radius_mm", "profile", "hand"),
    *(
        "web_width_mm",
        "web_offset_mm",
        "hub_width_mm",
        "flat_offset_mm",
        "flat_start_mm",
        "flat_end_mm",
        "reference_radius_mm",
    ),
)
#: Keys of the base pitch, which both bodies share.
OF_PITCH = ("module_mm", "pressure_angle_deg")
OF_BOTH = (
    *("accuracy.plane", "accuracy.flank_element_mm", "accuracy.modes", "accuracy.estimate"),
    *("accuracy.axial_degree", "accuracy.load_degree_z"),
    *("effects.dimension", "effects.friction_coefficient"),
    *("effects.near_field", "effects.influence", "effects.root_stress", "effects.body"),
    *("effects.segment_teeth", "effects.support_expansion_per_K", "effects.speed_rpm"),
    *("effects.density_kg_m3", "effects.coast_flank", "pair.face_width_mm"),
)
#: The first one is always solved anew; the outcome of the second depends on measured seconds.
TIMED = ("accuracy.tolerance", "effects.choose")
#: Keys that are walked for the first base alone: profiles of all kinds have them in common.
OF_FIRST = (
    *("material", "span_measurement_mm", "span_teeth", "ball_measurement_mm"),
    *("measuring_ball_mm", "tip_relief_knee_um", "protuberance_mm", "protuberance_angle_deg"),
    *("grinding_stock_mm", "addendum_factor", "tip_alteration_factor"),
    *("tip_relief_start_roll_angle_deg", "tip_relief_length_mm", "tip_relief_length"),
    *("root_relief_start_roll_angle_deg", "root_relief_length"),
)
#: Tables and keys of a base: of the first one nearly all, of the others those that they add.
WALKED = {
    "external_gear": r"body_1|pair|load|positions|effects|accuracy|body_2\.(bore|tip_relief|pitch)",
    "helical_gear": (
        r"body_1\.(lead|helix|tooth|end|shaft|face|pitch|web|profile_twist)|pair|load"
        r"|body_2\.(shaft|tip_relief)|accuracy\.(slices|axial)"
    ),
    "internal_gear": r"body_2|pair\.c",
    "spline": r"body_1|pair\.c",
    "cam": r"body|pair\.c",
    "external_gear_mesh_profile": r"body_1\.profile|body_2\.pitch|load",
    "external_gear_compliance": r"body|load",
}
#: Keys that make the first base three-dimensional: the bodies are made anew, whatever the key. All
#: keys of three dimensions that the helical base has are walked there.
SPATIAL_OF_FIRST = r"body_1\.(lead_crowning|face_width|axial|hub|rim|region|topography)|effects"
#: Keys that make a plane scene three-dimensional if no other key does.
MAKE_3D = (
    *("lead_crowning_um", "helix_slope_um", "end_relief_um", "_um_per_mm", "shaft"),
    *("profile_twist_um", "topography", "web_", "hub_", "rim_", "region_"),
)


@cache
def base(name: str) -> fl.Scene:
    return fl.read_scene(SCENES / f"{name}.toml").replace(QUICK | BASES[name])


def bits(result: fl.Result) -> list[bytes]:
    """Digests of results without their cost."""
    return [digest_of(without_cost(part)) for part in result.by_torque]


def without_cost(result: fl.Result) -> fl.Result:
    """A result without its cost and that of its compliances."""
    geometry = result.geometry
    if geometry is not None and geometry.coast is not None:
        contact = geometry.coast.contact
        compliances = tuple(replace(part, job=JobCost()) for part in contact.compliances)
        contact = replace(contact, compliances=compliances)
        geometry = replace(geometry, coast=replace(geometry.coast, contact=contact))
    return replace(result, cost={}, geometry=geometry)


def elements(result: fl.Result) -> list[str]:
    """Bodies whose elements were solved."""
    return [name[-6:] for name in result.cost["stages"] if name.startswith("compliance")]


def outcome(run: Any) -> Any:
    """Result of a run, or its error."""
    try:
        return run()
    except fl.FlankloadError as error:
        return str(error)


def adds_a_dimension(scene: fl.Scene, path: str) -> bool:
    """Whether a key makes a plane scene three-dimensional."""
    plane = not any(getattr(body, "helix_angle_deg", 0) for body in (scene.body_1, scene.body_2))
    widths = ("body_1.face_width_mm", "body_1.axial_offset_mm")
    return plane and (path in widths or any(word in path for word in MAKE_3D))


def expected_elements(scene: fl.Scene, path: str) -> set[str]:
    """Bodies whose elements a key may reach: the first modification adds tangential loads."""
    table, _, key = path.rpartition(".")
    body = getattr(scene, path[:6], None)
    if key in UNMODIFIED and body is not None and unmodified(body) == body:
        return {f"body {path[5]}"}
    if path in OF_BOTH or key in OF_PITCH or adds_a_dimension(scene, path):
        return {"body 1", "body 2"}
    if table.startswith("body_") and (key in OF_BODY or "file" in key or "_set" in key):
        return {f"body {table[5]}"}
    return set()


@pytest.mark.parametrize("name", BASES)
def test_every_key_gives_the_bits_of_a_single_run_and_only_some_reach_elements(name: str) -> None:
    scene = base(name)
    prepared = fl.prepare(scene)
    walked, tried, reached = [], set(), {}
    for path, all_changes in other_values(scene):
        once = name != "external_gear" and path.rpartition(".")[2] in OF_FIRST
        if once or path in TIMED or not re.match(WALKED[name], path):
            continue
        spatial = adds_a_dimension(scene, path)
        if name == "external_gear" and spatial and not re.match(SPATIAL_OF_FIRST, path):
            continue
        more = COARSE_3D if spatial else {}
        for own in all_changes:
            changes = own | more
            try:
                changed = scene.replace(changes)
            except fl.SceneError:
                continue
            tried.add(path)
            single = outcome(lambda changed=changed: fl.solve(changed))
            found = outcome(lambda changes=changes: prepared.solve(changes))
            if isinstance(single, str) or isinstance(found, str):
                assert found == single, path
                continue
            assert bits(found) == bits(single), path
            reached[path] = set(elements(found)) - expected_elements(scene, path)
            walked.append(path)
            break
    assert not {path: bodies for path, bodies in reached.items() if bodies}
    assert len(walked) > (50 if name == "external_gear" else 3)
    if name == "external_gear":
        missing = {f"body_1.{key}" for key in fl.Scene.from_dict(SCENE).body_1.__struct_fields__}
        of_three = ("axial", "hand", "helix", "end_relief", *MAKE_3D)
        left = {p for p in missing - tried if not any(word in p for word in of_three)}
        assert {p.rpartition(".")[2] for p in left} <= {
            *BESIDE,
            "tip_relief_shape",
            "root_relief_shape",
            *("module_mm", "pressure_angle_deg"),  # as of the other body
        }


@pytest.mark.parametrize("name", ["belt", "chain"])
def test_belts_and_chains_are_solved_anew(name: str) -> None:
    scene = fl.read_scene(SCENES / f"{name}.toml").replace({"accuracy.estimate": False})
    changes = {"load.torque_Nm": 0.9 * scene.torques_Nm[0]}
    found, single = fl.prepare(scene).solve(changes), fl.solve(scene.replace(changes))
    assert bits(found) == bits(single)
    assert found.cost["fe_factorisations"] == single.cost["fe_factorisations"]


RELIEF = {"body_1.tip_relief_um": 20.0, "body_1.tip_relief_start_diameter_mm": 80.0}


def with_modified_elements(scene: fl.Scene, monkeypatch: pytest.MonkeyPatch) -> fl.Result:
    """Result with elements on the modified flanks, as in decks for other programs."""
    with monkeypatch.context() as changed:
        changed.setattr("flankload.mechanisms.scene_bodies.unmodified", lambda table: table)
        return fl.solve(scene)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"body_1.tip_radius_mm": 0.4},
        {"body_1.root_relief_um": 3.0, "body_1.root_relief_start_diameter_mm": 70.5},
        {"effects.root_stress": True},
        {"effects.near_field": "nodes", "accuracy.flank_element_mm": 0.3},
        {"effects.temperature_rise_K": 40.0, "effects.coast_flank": True},
        {"effects.speed_rpm": 5000.0},
        {"effects.dimension": 3, "accuracy.flank_element_mm": 2.0, **COARSE_3D},
    ],
)
def test_elements_on_unmodified_flanks_change_little(
    more: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = fl.Scene.from_dict(example("external_gear")).replace(
        {**RELIEF, **more, "accuracy.estimate": False, "positions": {"count": 4}}
    )
    one, two = (build_bodies(scene, modified_elements=on).body_1 for on in (False, True))
    assert bits_of_curve(one) == bits_of_curve(two)  # the flank in contact has its relief
    found, expected = fl.solve(scene), with_modified_elements(scene, monkeypatch)
    apart = np.abs(found.transmission_error_um / expected.transmission_error_um - 1.0).max()
    assert 0.0 < apart < (1e-3 if "effects.near_field" in more else 1e-4)


def bits_of_curve(body: Body) -> bytes:
    return digest_of((body.curve, body.mode_range_mm, body.outline))


def test_a_scan_of_modifications_solves_elements_once() -> None:
    scene = base("external_gear").replace({**RELIEF, "accuracy.modes": 10})
    prepared = fl.prepare(scene)
    for changes in (
        {"body_1.tip_relief_um": 0.0},
        {"body_1.tip_relief_um": 25.0, "body_1.tip_relief_shape": "parabolic"},
        {"body_1.profile_crowning_um": 10.0},
    ):
        assert elements(prepared.solve(changes)) == []


def test_modes_of_any_number_have_the_elements_of_the_unmodified_flank() -> None:
    """Regression: the number of modes, which sets the elements, came from the modified flank."""
    scene = base("external_gear").replace({**RELIEF, "accuracy.modes": 10})
    one, two = (
        build_bodies(scene.replace({"body_1.tip_relief_um": um})).body_1 for um in (0.0, 400.0)
    )
    assert np.array_equal(one.mesh.nodes, two.mesh.nodes)


def test_the_former_key_of_elements_has_no_effect_but_a_warning() -> None:
    scene = base("external_gear")
    with pytest.warns(FutureWarning, match=r"gear\.toml: accuracy\.unmodified_elements no longer"):
        same = scene.replace({"accuracy.unmodified_elements": False})
    assert same == scene
    with pytest.raises(fl.SceneError, match=r"accuracy\.unmodified_elements: expected a known"):
        scene.replace({"accuracy.unmodified_elements": "yes"})


def test_tangents_are_left_out_where_they_are_not_wanted() -> None:
    scene = base("external_gear").replace({"accuracy.tangents": True})
    quiet = fl.solve(scene.replace({"accuracy.tangents": False}))
    found = fl.solve(scene)
    assert found.cost["contact_passes"] > quiet.cost["contact_passes"]
    for name in ("rotation_rad", "transmission_error_um", "stiffness_secant_Nm_per_rad"):
        assert np.array_equal(getattr(found, name), getattr(quiet, name))
    apart = quiet.stiffness_tangent_Nm_per_rad / found.stiffness_tangent_Nm_per_rad - 1.0
    assert 1e-4 < np.abs(apart).max() < 1e-2


def test_changed_files_are_read_again(tmp_path: Any) -> None:
    mesh = (SCENES / "../meshes/fzg_c_pinion.msh").read_text("utf-8")
    (tmp_path / "pinion.msh").write_text(mesh, encoding="utf-8")
    scene = base("external_gear_mesh_profile").replace(
        {
            "body_1.file": str(tmp_path / "pinion.msh"),
            "body_2.file": str((SCENES / "../meshes/fzg_c_wheel.msh").resolve()),
        }
    )
    prepared = fl.prepare(scene)
    assert elements(prepared.solve()) == []
    # the same mesh with its bore nearer to the axis
    (tmp_path / "pinion.msh").write_text(re.sub("BORE", "HOLE", mesh), encoding="utf-8")
    with pytest.raises(fl.SceneError, match="BORE"):
        prepared.solve()


def test_held_fits_of_profiles_have_the_bits_of_new_ones() -> None:
    scene = base("internal_gear")
    reliefs = (3.0, 9.0, 0.0)

    def curves() -> list[bytes]:
        pairs = [build_bodies(scene.replace({"body_2.tip_relief_um": um})) for um in reliefs]
        return [bits_of_curve(pair.body_2) for pair in pairs]

    held = curves()
    assert fit._of_method.cache_info().hits > 0
    for um, expected in zip(reliefs, held, strict=True):
        fit._of_method.cache_clear()
        pair = build_bodies(scene.replace({"body_2.tip_relief_um": um}))
        assert bits_of_curve(pair.body_2) == expected


def test_parts_are_dropped_in_the_order_of_their_last_use() -> None:
    parts = Parts()
    calls = [partial(math.sqrt, float(k)) for k in range(1, MOST_PARTS + 2)]
    for call in calls[:-1]:
        made_once(call, parts)
    assert parts.find(calls[0])[1] == 1.0  # used: the next one is the oldest
    made_once(calls[-1], parts)
    assert len(parts) == MOST_PARTS
    assert parts.find(calls[0])[1] == 1.0
    assert parts.find(calls[1])[1] is None


def test_digests_are_those_of_bits() -> None:
    same = [np.arange(3.0), (1, "a", None), {"a": 1.5}, SCENES]
    assert [digest_of(x) for x in same] == [digest_of(x) for x in same]
    unlike = [0.0, -0.0, 0, False, None, "", "0.0", (), (0.0,), [0.0], ((),), np.zeros(1)]
    unlike += [np.zeros(2), np.zeros((1, 2)), np.zeros(2, dtype=int), ("ab", "c"), ("a", "bc")]
    assert len({digest_of(x) for x in unlike}) == len(unlike)
    with pytest.raises(TypeError, match="data: expected numbers, text, arrays and tables"):
        digest_of(object())


def test_other_pitch_errors_build_no_body(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = base("external_gear")
    prepared = fl.prepare(scene)
    changes = {"body_2.pitch_errors_um": [0.5 * (i % 3) for i in range(24)]}
    with monkeypatch.context() as without:
        without.setattr("flankload.mechanisms.scene_bodies.build_body", None)
        found = prepared.solve(changes)
    assert bits(found) == bits(fl.solve(scene.replace(changes)))
    assert bits(found) != bits(prepared.solve())


# --- contacts that slices refuse ------------------------------------------------------------------
def test_contacts_without_a_state_in_slices_are_solved_with_cells(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Regression: short contacts had no result in slices, the default of three dimensions."""

    def once(
        scene: fl.Scene, *_: object, earlier: Earlier, plan: object = None
    ) -> tuple[tuple[fl.Scene, tuple[str, ...]]]:
        assert plan is None
        if scene.effects.contact == "lumped":
            raise PivotLimit("position 1: no state")
        return ((scene, earlier.notes),)

    monkeypatch.setattr(prepared, "run_once", once)
    found, notes = solve_found(fl.read_scene(SCENES / "helical_gear.toml"))
    assert found.effects.contact == "pairs"
    assert notes == ("position 1: no state: solved with cells instead (effects.contact = 'pairs')",)
    for path, level in (("helical_gear", "lumped"), ("external_gear_friction", "lumped")):
        scene = fl.read_scene(SCENES / f"{path}.toml").replace({"effects.contact": level})
        with pytest.raises(PivotLimit, match="no state"):
            solve_found(scene)


def solve_found(scene: fl.Scene) -> Any:
    """Results of the only run of a scene."""
    return prepared.solve_scene(scene, None, None)
