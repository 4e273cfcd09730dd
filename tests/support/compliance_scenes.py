"""Scenes of the FZG type C pair whose bodies may come from compliance files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import flankload as fl
from tests.support.gear_pair import GEARS

FROM_FILE_1 = {"kind": "compliance", "file": "body_1.npz"}
FROM_FILE_2 = {"kind": "compliance", "file": "body_2.npz"}
POSITIONS = {"count": 16}


def scene_of(folder: Path | None = None, **tables: Any) -> fl.Scene:
    whole = {
        **GEARS,
        "positions": POSITIONS,
        "accuracy": {"estimate": False, "tangents": False},
        **tables,
    }
    return fl.Scene.from_dict(whole, file=None if folder is None else folder / "scene.toml")


def solved(folder: Path | None = None, **tables: Any) -> fl.Result:
    result = fl.solve(scene_of(folder, **tables))
    assert isinstance(result, fl.Result)
    return result


def toml_of(scene: dict[str, Any]) -> str:
    """The tables of a scene as TOML: numbers, texts, booleans and lists."""
    lines = []
    for name, table in scene.items():
        lines.append(f"[{name}]")
        lines += [f"{key} = {str(value).lower() if isinstance(value, bool) else repr(value)}"
                  for key, value in table.items()]  # fmt: skip
    return "\n".join(lines) + "\n"


def assert_same(found: fl.Result, expected: fl.Result) -> None:
    """Check bitwise equality."""
    for name in ("rotation_rad", "site_force_N", "peak_pressure_MPa", "sites"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
