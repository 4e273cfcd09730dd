"""Planetary stages of REXS models: gears, places of the planets, torque, faults."""

import re
from pathlib import Path
from typing import Any

import pytest

from flankload.errors import SceneError
from flankload.exchange.rexs import Choices, Translation, read_model, scene_of_stage, stage_rows
from flankload.scene import read_scene
from tests.support.paths import ROOT, SCENES

EXAMPLE = ROOT / "examples" / "gearboxes" / "planetary_stage.rexs"
TEXT = EXAMPLE.read_text(encoding="utf-8")
RING = {"body_2.outer_diameter_mm": 207, "stage.floating": "sun"}
PLANET_2 = '<component id="55" type="cylindrical_gear" name="planet 2">'
#: Places of the planets in the example, as in the file.
PLACES = [f"<c>100</c><c>{y}</c><c>{z}</c>" for y, z in ((0, 63), (-63, 0), (0, -63), (63, 0))]


def made(folder: Path, text: str, **choices: Any) -> Translation:
    path = folder / "box.rexs"
    path.write_text(text, encoding="utf-8")
    return scene_of_stage(read_model(path), Choices(**{"settings": RING, **choices}))


def test_the_example_is_the_scene_of_its_values(tmp_path: Path) -> None:
    wanted = read_scene(SCENES / "planetary_stage.toml").to_dict()
    for key in ("pin_tangential_errors_um", "pin_stiffness_N_per_um"):
        del wanted["stage"][key]
    found = made(tmp_path, TEXT)
    assert found.scene.to_dict() == wanted
    assert found.stage == "planetary_stage 9"
    assert "not taken: cylindrical_gear 55: equal to cylindrical_gear 54" in found.lines
    assert not [line for line in found.lines if "has no key" in line]


def test_the_stages_of_the_example() -> None:
    rows = stage_rows(read_model(EXAMPLE))
    gears, teeth = "53, 54, 55, 56, 57, 58", "25, 17, 17, 17, 17, -59"
    assert rows[1] == ("9", gears, teeth, "planetary", "planetary stage")
    assert len(rows) == 10


def test_planets_that_are_not_equally_spaced_have_angles(tmp_path: Path) -> None:
    """Planet 2 at 90 + 360/84 deg from planet 1, counter-clockwise about the u axis (x)."""
    text = TEXT.replace(PLACES[1], "<c>100</c><c>-62.8238</c><c>-4.7078</c>")
    stage = made(tmp_path, text).scene.stage
    assert stage is not None
    assert stage.angles_deg == pytest.approx([0.0, 90.0 + 360.0 / 84.0, 180.0, 270.0], abs=1e-12)
    text = text.replace("<c>-62.8238</c>", "<c>-60</c>")
    with pytest.raises(SceneError, match=r"stage.angles_deg\[1\]: expected an angle of planet 2"):
        made(tmp_path, text)


def test_without_positions_planets_are_equally_spaced(tmp_path: Path) -> None:
    found = made(tmp_path, re.sub(r'<attribute id="support_vector".*\n', "", TEXT))
    assert found.scene.stage is not None
    assert found.scene.stage.planets == 4
    assert any("the planets are equally spaced" in line for line in found.lines)


def bearing(number: int, planet: int, clearance: float) -> tuple[str, str]:
    """Relation and component of a bearing of a planet."""
    refs = f'<ref id="{number}" role="assembly"/><ref id="{planet}" role="outer_part"/>'
    values = '<attribute id="radial_stiffness" unit="N / m">1.5e8</attribute>'
    values += f'<attribute id="radial_bearing_clearance" unit="mum">{clearance}</attribute>'
    kind = "rolling_bearing_with_catalog_geometry"
    return (
        f'<relation id="{number}" type="side">{refs}</relation>',
        f'<component id="{number}" type="{kind}" name="bearing">{values}</component>',
    )


def test_bearings_of_the_planets(tmp_path: Path) -> None:
    """Two for each planet, of 150 N/um; one of them has more clearance."""
    both = [
        bearing(900 + 2 * j + k, 54 + j, 30 if (j, k) == (2, 1) else 20)
        for j in range(4)
        for k in range(2)
    ]
    relations, components = ("".join(parts) for parts in zip(*both, strict=True))
    text = TEXT.replace("</relations>", f"{relations}</relations>")
    text = text.replace("</components>", f"{components}</components>")
    found = made(tmp_path, text)
    stage = found.scene.stage
    assert stage is not None
    assert stage.pin_stiffness_N_per_um == 300.0
    assert stage.pin_clearance_um == (20.0, 20.0, 30.0, 20.0)
    assert any("the clearance of its bearings is that before mounting" in x for x in found.lines)
    assert not any("rolling_bearing" in line for line in found.lines)
    text = text.replace('unit="N / m">1.5e8</attribute>', 'unit="N / m">2e8</attribute>', 1)
    uneven = made(tmp_path, text)
    assert uneven.scene.stage.pin_stiffness_N_per_um is None  # type: ignore[union-attr]
    assert any("planets have different bearings" in line for line in uneven.lines)


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        (
            '<ref id="58" role="gear_2" hint="ring_gear"/>',
            '<ref id="58" role="gear_3" hint="ring_gear"/>',
            "cylindrical_stage 20: expected one cylindrical_gear or ring_gear as gear_2",
        ),
        (
            '<ref id="20" role="part" hint="cylindrical_stage"/>',
            '<ref id="20" role="parts" hint="cylindrical_stage"/>',
            "planetary_stage 9: expected planets that are in mesh with the sun and with the ring",
        ),
        (
            PLANET_2,
            f"{PLANET_2}<attribute id='root_diameter' unit='mm'>43</attribute>",
            "cylindrical_gear 55: expected a planet equal to cylindrical_gear 54",
        ),
        (
            '<attribute id="center_distance" unit="mm">-63</attribute>',
            '<attribute id="center_distance" unit="mm">-64</attribute>',
            "cylindrical_stage 20: center_distance: expected 63 mm as in cylindrical_stage 10",
        ),
        ('unit="N m">600<', 'unit="N m">0<', "planetary_stage 9: expected --torque-Nm, since"),
    ],
)
def test_each_fault_has_its_line(tmp_path: Path, old: str, new: str, line: str) -> None:
    assert old in TEXT
    with pytest.raises(SceneError) as caught:
        made(tmp_path, TEXT.replace(old, new, 1), stage=9)
    assert line in str(caught.value)
