"""REXS models for tests: the example in XML, JSON and ZIP, and a spur stage with few attributes."""

import io
import json
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from tests.support.paths import ROOT

EXAMPLE = ROOT / "examples" / "gearboxes" / "two_stages.rexs"
TEXT = EXAMPLE.read_text(encoding="utf-8")
HEAD = '<model version="1.4" applicationId="a" applicationVersion="1" date="2026-11-23">'


def in_json(text: str) -> str:
    """The model of an XML text in the JSON form, each value with the type of the database."""
    root = ElementTree.fromstring(text)
    parts = [_component(part) for part in root.iterfind("components/component")]
    relations = [
        {
            "id": int(part.get("id", "")),
            "type": part.get("type"),
            "refs": [
                {"id": int(ref.get("id", "")), "role": ref.get("role"), "hint": ref.get("hint")}
                for ref in part
            ],
        }
        for part in root.iterfind("relations/relation")
    ]
    cases = [
        {
            "id": int(case.get("id", "")),
            "components": [_component(part) for part in case],
        }
        for case in root.iterfind("load_spectrum/load_case")
    ]
    model: dict[str, Any] = {**root.attrib, "relations": relations, "components": parts}
    if cases:
        model["load_spectrum"] = {"id": 1, "load_cases": cases}
    return json.dumps({"model": model})


def _component(part: ElementTree.Element) -> dict[str, Any]:
    named = {} if part.get("name") is None else {"name": part.get("name")}
    return {
        "id": int(part.get("id", "")),
        "type": part.get("type"),
        **named,
        "attributes": [
            {"id": item.get("id"), "unit": item.get("unit"), **_value(item)} for item in part
        ],
    }


def _value(item: ElementTree.Element) -> dict[str, Any]:
    if len(item):
        return {"floating_point_array": [float(cell.text or "") for cell in item[0]]}
    text = item.text or ""
    if text in ("true", "false"):
        return {"boolean": text == "true"}
    if item.get("id") in ("number_of_teeth", "reference_component_for_position"):
        return {"integer": int(text)}
    try:
        return {"floating_point": float(text)}
    except ValueError:
        return {"enum": text}


def zipped(**files: str) -> bytes:
    """An archive; `_` in a name is a dot."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name.replace("_", "."), content)
    return stream.getvalue()


def without(attribute: str, component: int, text: str = TEXT) -> str:
    """The text without an attribute of a component."""
    return changed(attribute, component, None, text)


def changed(attribute: str, component: int, line: str | None, text: str = TEXT) -> str:
    """The text with another line for an attribute of a component."""
    head, mark, tail = text.partition(f'<component id="{component}" ')
    assert mark
    part, end, rest = tail.partition("</component>")
    lines = part.splitlines()
    (place,) = [k for k, found in enumerate(lines) if f'id="{attribute}"' in found]
    lines[place : place + 1] = [] if line is None else [line]
    return head + mark + "\n".join(lines) + "\n" + end + rest


def added(component: int, *lines: str, text: str = TEXT) -> str:
    """The text with further attributes of a component."""
    head, mark, tail = text.partition(f'<component id="{component}" ')
    part, end, rest = tail.partition("</component>")
    assert mark
    return head + mark + part + "\n".join(lines) + end + rest


def spur(torque: str = "302", unit: str = "N m") -> str:
    """The pair of examples/scenes/external_gear.toml as a stage, in names of REXS 1.0 to 1.2."""
    gears = ((1, 16, 82.46, 30, 0.182), (2, 24, 118.36, 40, 0.171))
    distance = attribute_line("center_distance", "mm", 91.5)
    stage = '<component id="9" type="cylindrical_stage" name="FZG type C">'
    parts = [f"{stage}{distance}</component>"]
    relations = [("stage", ("stage", 9), ("gear_1", 1), ("gear_2", 2))]
    for k, teeth, tip, bore, shift in gears:
        lines = [
            attribute_line("number_of_teeth", "none", teeth),
            attribute_line("normal_module", "mm", 4.5),
            attribute_line("tip_diameter", "mm", tip),
            attribute_line("inner_diameter", "mm", bore),
            attribute_line("face_width", "mm", 14),
            attribute_line("helix_angle_reference_diameter", "°", 0),
        ]
        flank = attribute_line("normal_pressure_angle", "°", 20)
        flank += attribute_line("addendum_modification_coefficient", "none", shift)
        data = attribute_line("torque", unit, torque) if k == 1 else ""
        parts += [
            f'<component id="{k}" type="cylindrical_gear">{"".join(lines)}</component>',
            f'<component id="{10 + k}" type="flank_geometry">{flank}</component>',
            f'<component id="{20 + k}" type="stage_gear_data">{data}</component>',
        ]
        relations += [
            ("flank", ("gear", k), ("left", 10 + k), ("right", 10 + k)),
            ("stage_gear_data", ("stage", 9), ("gear", k), ("stage_gear_data", 20 + k)),
        ]
    return model_text(relations, parts)


def model_text(relations: list[Any], parts: list[str]) -> str:
    """A model of relations (type and pairs of role and id) and components."""
    rows = [
        f'<relation id="{k}" type="{kind}">'
        + "".join(f'<ref id="{number}" role="{role}"/>' for role, number in refs)
        + "</relation>"
        for k, (kind, *refs) in enumerate(relations, start=1)
    ]
    return (
        f"{HEAD}<relations>{''.join(rows)}</relations>"
        f"<components>{''.join(parts)}</components></model>"
    )


def attribute_line(attribute: str, unit: str, value: object) -> str:
    """An attribute."""
    return f'<attribute id="{attribute}" unit="{unit}">{value}</attribute>'


def written(folder: Path, content: str | bytes, name: str = "box.rexs") -> Path:
    """A file with this content."""
    path = folder / name
    path.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
    return path
