"""Small three-dimensional scenes from the examples, and how far their results differ."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np

import flankload as fl
from tests.support.gear_scenes import example
from tests.support.solving import solve

#: Bodies of coarse elements, for properties that do not depend on these.
SMALL: dict[str, Any] = {
    "accuracy__flank_element_mm": 3.0,
    "accuracy__modes": 3,
    "accuracy__axial_degree": 5,
    "accuracy__load_degree_z": 1,
    "accuracy__slices": 8,
    "positions__count": 4,
}
HELICAL = "helical_gear"
OTHER_HANDS = {"body_1__hand": "left", "body_2__hand": "right"}
#: Sums over slices of thousands of N, after rounding of the scene's numbers.
MIRRORED = 1e-10


def tree_of(name: str, changes: dict[str, Any]) -> dict[str, Any]:
    """An example without estimate and tangents, with keys changed; None removes a key."""
    tree = example(name)
    tree.setdefault("accuracy", {}).update(estimate=False, tangents=False)
    for path, value in changes.items():
        table, _, key = path.partition("__")
        keys = tree.setdefault(table, {})
        if value is None:
            keys.pop(key, None)
        else:
            keys[key] = value
    return tree


@cache
def _solved_text(text: str) -> fl.Result:
    found = solve(fl.Scene.from_dict(json.loads(text)))
    assert isinstance(found, fl.Result)
    return found


def solved(name: str, changes: dict[str, Any]) -> fl.Result:
    """The small example with keys changed; a scene is solved once."""
    return _solved_text(json.dumps(tree_of(name, {**SMALL, **changes}), sort_keys=True))


def deviation(one: Any, two: Any) -> float:
    """Largest difference, relative to the largest value."""
    one, two = np.asarray(one), np.asarray(two)
    return float(np.abs(one - two).max() / np.abs(two).max())


@cache
def _prepared(name: str) -> fl.Prepared:
    return fl.prepare(fl.Scene.from_dict(tree_of(name, SMALL)))


@cache
def _solved(name: str, changes: str) -> fl.Result:
    return _prepared(name).solve(json.loads(changes))


def solve_small(name: str, changes: dict[str, Any]) -> fl.Result:
    """A small example with keys changed: solved once, its bodies and elements reused."""
    paths = {path.replace("__", "."): value for path, value in changes.items()}
    return _solved(name, json.dumps(paths, sort_keys=True))
