"""Every reference is met; ``./dev reference`` makes them anew and prints the changes."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

from . import compare
from .compare import (
    REFERENCES,
    movements,
    read_reference,
    reference_of,
    table,
    write_reference,
)
from .contact_cases import contact_cases
from .nodal_cases import nodal_cases
from .scene_cases import parents, scene_cases

CASES = contact_cases() | nodal_cases() | scene_cases()
#: Variants that find the state of their parent at more positions, torques or in more quantities.
MORE_IS_SEEN = {
    f"variant_{name}"
    for name in ("two_torques", "root_stress", "adaptive", "harmonics", "estimates", "sliding")
}
#: Least change of the largest number by a variant: ten times the tolerance of a reference.
LEAST_DIFFERENCE = 1e-5
NAMES = sorted(path.stem for path in REFERENCES.glob("*.json"))


@pytest.fixture
def no_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Imports of scipy fail: its import would take longer than many runs."""
    for name in ["scipy", *sys.modules]:
        if name.partition(".")[0] == "scipy":
            monkeypatch.setitem(sys.modules, name, None)


@pytest.mark.usefixtures("no_scipy")
@pytest.mark.parametrize("name", NAMES)
def test_reference(name: str) -> None:
    assert name in CASES, f"{name}.json belongs to no case any more"
    reference = read_reference(name)
    found = reference_of(name, CASES[name])
    assert found["inputs"] == reference["inputs"], "another problem than that of the reference"
    moved = movements(reference, found)
    assert not any(row.is_drift for row in moved), "\n" + table(name, moved)


def found_at(reference: dict[str, Any], places: list[float]) -> dict[str, np.ndarray]:
    """Rotations and load shares at some of its positions."""
    values = {key: about["value"] for key, about in reference["quantities"].items()}
    rows = [values["position_rad"].index(place) for place in places]
    return {
        key: np.reshape(values[key], (len(values["position_rad"]), -1))[rows]
        for key in ("rotation_rad", "load_share", "site_force_N")
    }


@pytest.mark.parametrize(("name", "parent"), parents().items(), ids=parents())
def test_variant_differs_from_its_parent(name: str, parent: str) -> None:
    """Regression: two variants equalled the plain gear; their keys affected no tooth in mesh."""
    before, now = read_reference(parent), read_reference(name)
    if name in MORE_IS_SEEN:
        one, two = before["quantities"], now["quantities"]
        assert set(two) - set(one) or len(two["position_rad"]["value"]) > len(
            one["position_rad"]["value"]
        )
        return
    common = [
        place
        for place in before["quantities"]["position_rad"]["value"]
        if place in now["quantities"]["position_rad"]["value"]
    ]
    assert common, "no position at which both can be compared"
    one, two = found_at(before, common), found_at(now, common)
    assert any(
        one[key].shape != two[key].shape
        or np.abs(one[key] - two[key]).max() > LEAST_DIFFERENCE * np.abs(one[key]).max()
        for key in one
    ), f"all the same as {parent}"


def test_there_are_enough_of_each_kind() -> None:
    assert len(NAMES) >= 25
    for method in (
        "single",
        "block",
        "cascade",
        "primal",
        "load_path",
        "paper",
        "torques",
        "rows_exchanged",
    ):
        assert f"contact_gear_{method}" in NAMES
    for path in REFERENCES.glob("*.json"):
        assert path.stat().st_size < 32_000, f"{path.name} is no small file"


def made_up(value: Any, **changes: Any) -> dict[str, Any]:
    about = {"unit": "N", "rtol": 1e-3, "atol": 0.0, "reason": "made up", "value": value}
    return {"quantities": {"force": about | changes}}


def test_quantities_that_move_too_far_are_named() -> None:
    (row,) = movements(made_up([1.0, 200.0]), made_up([1.1, 200.1]))
    assert not row.is_drift
    np.testing.assert_allclose(row.allowed, 0.2, rtol=1e-12, atol=0)
    (row,) = movements(made_up([1.0, 200.0]), made_up([1.3, 200.1]))
    assert row.is_drift
    assert "! force  moved 3.00e-01 N, allowed 2.0e-01: 1 -> 1.3" in table("made_up", [row])


@pytest.mark.parametrize(
    ("before", "now"),
    [([1.0], [1.0, 2.0]), ("solved", "NegativeForce"), ([1.0], [float("nan")]), ("solved", 1.0)],
)
def test_a_change_of_kind_is_drift(before: Any, now: Any) -> None:
    (row,) = movements(made_up(before), made_up(now))
    assert row.is_drift


def test_an_added_or_missing_quantity_is_drift() -> None:
    nothing: dict[str, Any] = {"quantities": {}}
    assert movements(made_up([1.0]), nothing)[0].is_drift
    assert movements(nothing, made_up([1.0]))[0].is_drift


def test_what_is_written_is_read(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(compare, "REFERENCES", tmp_path)
    reference = made_up([1.5, 2.0, -3.25e-9]) | {
        "name": "made_up",
        "inputs": {"matrix": [[1, 2], [3, 4]], "scene": {"count": 3, "words": ["a, b", "c"]}},
    }
    write_reference(reference)
    assert read_reference("made_up") == reference
