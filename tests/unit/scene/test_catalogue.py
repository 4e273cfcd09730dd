"""Names in place of keys: profiles of belts, chains and materials."""

import tomllib
from collections.abc import Callable
from typing import Any, get_args

import pytest

import flankload as fl
from flankload.errors import SceneError
from flankload.scene.belt_profiles import BELT_PROFILES, ProfileName, shore_modulus
from flankload.scene.chain_sizes import CHAIN_SIZES, ChainName
from flankload.scene.materials import MATERIALS, MaterialName
from flankload.scene.usual import question_notes
from tests.support.gear_scenes import changed
from tests.support.paths import DOCS
from tests.support.tolerances import ROUND_OFF

BELT: dict[str, Any] = {
    "body_1": {"kind": "pulley", "teeth": 24, "profile": "T10"},
    "body_2": {"kind": "belt", "wrapped_teeth": 5, "width_mm": 16},
    "load": {"torque_Nm": 10, "slack_tension_N": 320},
}
CHAIN: dict[str, Any] = {
    "body_1": {"kind": "sprocket", "teeth": 20},
    "body_2": {"kind": "chain", "chain": "08B", "wrap_angle_deg": 180},
    "load": {"torque_Nm": 77, "slack_tension_N": 100},
}
#: Keys of a belt that no table confirms, by profile.
ASKED = {
    "T20": ("land_distance_mm", "back_mm"),
    "AT5": ("back_mm",),
    "AT10": ("back_mm",),
    "AT20": ("land_distance_mm",),
}


def belt(profile: str, **keys: Any) -> fl.Scene:
    tables = {**BELT, "body_1": {**BELT["body_1"], "profile": profile}}
    return fl.Scene.from_dict({**tables, "body_2": {**BELT["body_2"], **keys}})


def test_names_of_the_schema_are_those_of_the_catalogues() -> None:
    assert get_args(ProfileName) == tuple(BELT_PROFILES)
    assert get_args(ChainName) == tuple(CHAIN_SIZES)
    assert get_args(get_args(get_args(MaterialName)[0])[0]) == tuple(MATERIALS)


@pytest.mark.parametrize("profile", BELT_PROFILES)
def test_a_profile_gives_all_keys_that_tables_confirm(profile: str) -> None:
    asked = ASKED.get(profile, ())
    if asked:
        with pytest.raises(SceneError) as refused:
            belt(profile)
        more = f" (also missing: {', '.join(asked[1:])})" if asked[1:] else ""
        line = f"body_2.{asked[0]}: expected a number from 0.001 to 100000{more}, found nothing"
        assert str(refused.value) == line
    pitch = BELT_PROFILES[profile].pitch_mm
    scene = belt(profile, **{key: (0.1 if "land" in key else 0.3) * pitch for key in asked})
    assert scene.body_1.pitch_mm == scene.body_2.pitch_mm == pitch
    assert scene.body_1.tooth_shape == ("HTD" if profile.startswith("HTD") else "T")
    notes = question_notes(scene)
    assert any("body_2.cord_stiffness_N_per_mm" in note for note in notes)
    assert any("polyurethane of 92 Shore A" in note for note in notes)


def test_own_keys_have_precedence_and_are_no_estimates() -> None:
    scene = belt("T10", cord_stiffness_N_per_mm=25000, flank_angle_deg=25, young_modulus_MPa=100)
    assert scene.body_2.cord_stiffness_N_per_mm == 25000
    assert (scene.body_2.flank_angle_deg, scene.body_2.tooth_width_mm) == (25, 5.3)
    assert question_notes(scene) == ()


def test_another_name_replaces_the_values_of_the_first() -> None:
    scene = belt("T10", back_mm=2.2)
    tree = scene.to_dict()
    assert tree["body_2"] == {**BELT["body_2"], "back_mm": 2.2}
    assert fl.Scene.from_dict(tomllib.loads(scene.to_toml())) == fl.Scene.from_dict(tree)
    other = scene.replace({"body_1.profile": "T5"}).body_2
    assert (other.pitch_mm, other.tooth_height_mm, other.back_mm) == (5.0, 1.2, 2.2)


def test_a_chain_gives_the_keys_of_chain_and_sprocket() -> None:
    scene = fl.Scene.from_dict(CHAIN)
    assert (scene.body_1.pitch_mm, scene.body_1.roller_diameter_mm) == (12.7, 8.51)
    assert scene.body_2.link_stiffness_N == pytest.approx(3.16e6, rel=0.01)
    assert [note.split(" ")[0] for note in question_notes(scene)] == [
        "body_2.link_stiffness_N",
        "body_2.contact_stiffness_N_per_mm",
    ]
    other = scene.replace({"body_2.chain": "60", "body_2.roller_diameter_mm": 12.0})
    assert (other.body_1.pitch_mm, other.body_1.roller_diameter_mm) == (19.05, 12.0)
    assert other == fl.Scene.from_dict(other.to_dict())


def test_estimates_follow_their_formulas() -> None:
    assert shore_modulus(40.0) == pytest.approx(29.83, abs=0.01)
    size = CHAIN_SIZES["80"]  # two plates of 3.175 x (20.828 - 7.925) mm, pins of 7.925 mm
    plates = 206000 * 2 * 3.175 * (0.82 * 25.4 - size.pin_diameter_mm)
    assert 0.7 * plates < size.link_stiffness_N < 0.9 * plates
    # the load of one contact at half the displacement of both in series
    force = 125.0 * size.tensile_strength_kN
    each = 0.5 * force / size.contact_stiffness_N_per_mm
    load = 35948 * size.inner_width_mm ** (8 / 9) * each ** (10 / 9)
    assert load == pytest.approx(force, rel=ROUND_OFF * 100)


def test_several_missing_keys_are_named_at_once() -> None:
    tables = {**CHAIN, "body_2": {"kind": "chain", "pitch_mm": 12.7}}
    with pytest.raises(SceneError) as refused:
        fl.Scene.from_dict({**tables, "body_1": {**CHAIN["body_1"], "pitch_mm": 12.7}})
    assert "(also missing: roller_diameter_mm)" not in str(refused.value)
    assert str(refused.value).startswith("body_1.roller_diameter_mm: expected a number")
    sprocket = {**CHAIN["body_1"], "pitch_mm": 12.7, "roller_diameter_mm": 8.51}
    with pytest.raises(SceneError) as refused:
        fl.Scene.from_dict({**tables, "body_1": sprocket})
    assert "also missing: wrap_angle_deg, link_stiffness_N, contact_" in str(refused.value)


def test_a_material_gives_elastic_constants_expansion_and_density() -> None:
    warm = {"effects__temperature_rise_K": 60.0, "effects__speed_rpm": 3000.0}
    tree = changed(body_1__material="PA66", **warm)
    for key in ("young_modulus_MPa", "poisson_ratio"):
        tree["body_1"].pop(key, None)
    scene = fl.Scene.from_dict(tree)
    assert (scene.body_1.young_modulus_MPa, scene.body_1.poisson_ratio) == (1400.0, 0.4)
    assert scene.effects.thermal_expansion_per_K == (1e-4, 11.5e-6)
    assert scene.effects.density_kg_m3 == (1140.0, 7850.0)
    steel = scene.replace({"body_1.material": "steel", "body_1.poisson_ratio": 0.28})
    assert (steel.body_1.young_modulus_MPa, steel.body_1.poisson_ratio) == (206000.0, 0.28)
    assert steel.effects.thermal_expansion_per_K == (11.5e-6, 11.5e-6)


def test_the_default_modulus_beside_another_material_is_kept() -> None:
    scene = fl.Scene.from_dict(changed(body_1__material="bronze", body_1__young_modulus_MPa=206000))
    assert scene.replace({"body_1.poisson_ratio": 0.3}).body_1.young_modulus_MPa == 206000


PAGE = DOCS / "guide" / "catalogues.md"


def belt_table() -> list[str]:
    """Lines of the table of belt profiles; a value that the scene has to set is a dash."""
    keys = ("tooth_height_mm", "tooth_width_mm", "flank_angle_deg", "land_distance_mm", "back_mm")
    lines = [
        (
            "| profile | pitch | tooth height | width at the land | flank angle | land to cord "
            "| back | cord, N/mm | source of the dimensions |"
        ),
        "|" + "---|" * 9,
    ]
    for name, profile in BELT_PROFILES.items():
        values = [f"{profile.belt[key]:g}" if key in profile.belt else "–" for key in keys]
        if "tooth_width_mm" in profile.estimates:
            values[1] = f"{profile.estimates['tooth_width_mm'].value:g} (est.)"
        values[2] = "round" if name.startswith("HTD") else values[2]
        cord = profile.estimates["cord_stiffness_N_per_mm"].value
        cells = [name, f"{profile.pitch_mm:g}", *values, f"{cord:g}", profile.source]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def chain_table() -> list[str]:
    """Lines of the table of chains."""
    lines = [
        (
            "| chain | pitch | roller diameter | inner width | pin diameter | strength, kN "
            "| link stiffness, N | contact stiffness, N/mm |"
        ),
        "|" + "---|" * 8,
    ]
    for name, size in CHAIN_SIZES.items():
        stiffness = [f"{estimate.value:g}" for estimate in size.estimates.values()]
        cells = [name, *(f"{value:g}" for value in size), *stiffness]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def material_table() -> list[str]:
    """Lines of the table of materials."""
    lines = [
        "| material | E, MPa | Poisson's ratio | expansion, 1/K | density, kg/m³ | source |",
        "|" + "---|" * 6,
    ]
    for name, material in MATERIALS.items():
        cells = [f"`{name}`", *(f"{value:g}" for value in material[:4]), material.source]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


@pytest.mark.parametrize("table", [belt_table, chain_table, material_table])
def test_the_page_of_catalogues_has_the_tables(table: Callable[[], list[str]]) -> None:
    """If this fails, insert the output of python -m tests.unit.scene.test_catalogue."""
    page, lines = PAGE.read_text(encoding="utf-8").splitlines(), table()
    first = page.index(lines[0])
    assert page[first : first + len(lines)] == lines


if __name__ == "__main__":
    print(*belt_table(), "", *chain_table(), "", *material_table(), sep="\n")


def test_typed_bodies_may_have_names_in_place_of_keys() -> None:
    belt = fl.BeltAndPulley(
        fl.Pulley(teeth=24, profile="T10"),
        fl.Belt(wrapped_teeth=5, width_mm=16),
        torque_Nm=10,
        slack_tension_N=320,
    )
    chain = fl.ChainAndSprocket(
        fl.Sprocket(teeth=20),
        fl.Chain(chain="08B", wrap_angle_deg=180),
        torque_Nm=77,
        slack_tension_N=100,
    )
    for typed, tables in ((belt, BELT), (chain, CHAIN)):
        scene, same = typed.to_scene(), fl.Scene.from_dict(tables)
        assert (scene.body_1, scene.body_2) == (same.body_1, same.body_2)
        assert "pitch_mm" not in typed.to_toml()


def test_typed_bodies_without_names_need_the_keys() -> None:
    belt = fl.BeltAndPulley(
        fl.Pulley(teeth=24), fl.Belt(wrapped_teeth=5, width_mm=16), torque_Nm=10, slack_tension_N=9
    )
    with pytest.raises(SceneError, match=r"^body_1\.pitch_mm: expected a number from 0.001 to"):
        belt.to_scene()


@pytest.mark.parametrize(
    ("tables", "key", "value"),
    [(BELT, "body_1.profile", "T11"), (CHAIN, "body_2.chain", "8B"), (CHAIN, "body_2.chain", 40)],
)
def test_an_unknown_name_is_refused_before_the_keys_that_it_does_not_give(
    tables: dict[str, Any], key: str, value: object
) -> None:
    body, name = key.split(".")
    with pytest.raises(SceneError) as refused:
        fl.Scene.from_dict({**tables, body: {**tables[body], name: value}})
    assert refused.value.key == key
