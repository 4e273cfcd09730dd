"""Public classes come back as they are from pickles, copies and other processes."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import tomllib
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

import flankload as fl
from flankload import errors
from flankload.studies.accuracy import accuracy
from tests.support.paths import SCENES
from tests.support.planetary_stages import four
from tests.support.small_job import SCENE

WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
    "oldest pickle": lambda one: pickle.loads(pickle.dumps(one, protocol=0)),
    "copy": copy.copy,
    "deep copy": copy.deepcopy,
}
PLACED = {"key": "body_1.teeth", "expected": "an integer", "found": "'six'", "file": "a.toml"}


def held() -> fl.ContactState:
    """Two springs that share a torque."""
    return fl.solve_contact(np.eye(2), np.ones(2), np.zeros(2), 2.0, normal_lever_arms=np.ones(2))


def raised() -> dict[str, errors.FlankloadError]:
    """An error of each class, with all that it may carry."""
    several = errors.PivotLimit("position 3: too many pivots")
    several.place, several.states = (3, 0), (held(), None)
    several.add_note("a note")
    return {
        "FlankloadError": errors.FlankloadError("something"),
        "SceneError": errors.SceneError(**PLACED),
        "PremiseError": errors.PremiseError(**PLACED),
        "MeshError": errors.MeshError(**PLACED),
        "ComplianceFileError": errors.ComplianceFileError(**PLACED),
        "OtherProgramError": errors.OtherProgramError("no answer", folder=Path("out")),
        "ContactError": errors.ContactError("nothing"),
        "NoContactState": errors.NoContactState(
            "no state", proven=True, largest_torque=3.0, motion=np.ones(2)
        ),
        "PivotLimit": several,
        "SingularContact": errors.SingularContact("no pair", motion=np.ones(1)),
        "InputError": errors.InputError("not a number", code=-7),
        "NegativeForce": errors.NegativeForce("tension", state=held()),
    }


def tables() -> dict[str, Any]:
    """One of each table of a scene, and of the pairs made of them."""
    scenes = [fl.read_scene(path) for path in sorted(SCENES.glob("*.toml"))]
    bodies = [body for scene in scenes for body in (scene.body_1, scene.body_2)]
    found: dict[str, Any] = {type(body).__name__: body for body in bodies}
    pairs: dict[Any, tuple[str, str, dict[str, Any]]] = {
        fl.GearPair: ("Gear", "Ring", {"face_width_mm": 14}),
        fl.Spline: ("SplineShaft", "SplineHub", {"face_width_mm": 14}),
        fl.CamAndFollower: ("Follower", "Cam", {"face_width_mm": 14}),
        fl.ChainAndSprocket: ("Sprocket", "Chain", {}),
        fl.BeltAndPulley: ("Pulley", "Belt", {}),
    }
    for kind, (one, two, keys) in pairs.items():
        found[kind.__name__] = kind(found[one], found[two], torque_Nm=10, **keys)
    stage = (found["Gear"], found["Gear"], found["Ring"])
    found["PlanetaryStage"] = fl.PlanetaryStage(*stage, planets=3, torque_Nm=10)
    for train in (fl.IdlerTrain, fl.TwoPinions):
        found[train.__name__] = train(*[found["Gear"]] * 3, face_width_mm=20, torque_Nm=10)
    keys = {"helix_angle_deg": 15, "tip_diameter_mm": 66, "bore_diameter_mm": 25}
    helices = [fl.Gear(teeth=20, module_mm=3, hand=hand, **keys) for hand in ("right", "left")]
    found["DoubleHelicalPair"] = fl.DoubleHelicalPair(
        *helices, groove_width_mm=10, face_width_mm=20, torque_Nm=10
    )
    profiles = (getattr(body, "profile", None) for body in bodies)
    return {
        **found,
        "Accuracy": scenes[0].accuracy,
        "Effects": scenes[0].effects,
        "Positions": scenes[0].positions,
        "Profile": next(one for one in profiles if isinstance(one, fl.Profile)),
        "Carrier": fl.Carrier(plate_distance_mm=40.0, pin_diameter_mm=20.0),
        "PlanetFlank": fl.PlanetFlank(helix_slope_um=5.0),
        "Shaft": fl.Shaft(diameters_mm=(30.0,), lengths_mm=(100.0,)),
    }


@pytest.fixture(scope="module")
def examples(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """One of each public class."""
    tree = tomllib.loads(SCENE)
    tree["body_2"]["rigid"] = True
    tree["positions"]["count"] = 4
    tree["accuracy"] = {"flank_element_mm": 2.25}
    scene = fl.Scene.from_dict(tree)
    del tree["body_2"]["rigid"]
    wheels = fl.Scene.from_dict(tree)
    return {
        **raised(),
        **tables(),
        "ContactState": held(),
        "DesignStudy": fl.study(scene, {"load.torque_Nm": [100, 302]}),
        "FlankTolerances": fl.iso_1328(7, teeth=24, module_mm=4.5, face_width_mm=14),
        "Optimum": fl.optimise(
            scene,
            [{"paths": "pair.center_distance_mm", "lower": 91.5, "upper": 91.6}],
            "peak_pressure_MPa",
            starts=1,
        ),
        "Plan": fl.plan(scene),
        "Prepared": fl.prepare(scene),
        "Result": fl.solve(scene),
        "Robust": fl.robust(scene, {"load.torque_Nm": norm(302, 3)}),
        "Scene": scene,
        "Sensitivity": fl.sensitivity(scene, ["load.torque_Nm"]),
        "StageModes": fl.natural_modes(four(accuracy={"flank_element_mm": 3.0}))[0],
        "AccuracyStudy": accuracy(scene, ("transmission_error",), 1e-9),
        "Verification": fl.verify(
            wheels,
            run=False,
            folder=tmp_path_factory.mktemp("deck"),
            elements_per_half_width=1.0,
        ),
    }


def test_every_public_class_has_an_example(examples: dict[str, Any]) -> None:
    public = {name for name in fl.__all__ if isinstance(getattr(fl, name), type)}
    of_errors = {name for name in vars(errors) if isinstance(vars(errors)[name], type)}
    of_errors = {name for name in of_errors if issubclass(vars(errors)[name], Exception)}
    public -= {"Explorer"}  # a server that runs
    assert set(examples) == public | of_errors


@pytest.mark.parametrize("way", WAYS)
def test_public_classes_come_back_as_they_are(way: str, examples: dict[str, Any]) -> None:
    for name, example in examples.items():
        if name == "Result":
            assert example.load_share.flags.writeable is False  # kept by the result from here on
        found = WAYS[way](example)
        assert type(found) is type(example)
        if isinstance(example, Exception):
            assert str(found) == str(example)
        before, after = (list(_leaves(one)) for one in (example, found))
        assert [place for place, _ in after] == [place for place, _ in before], name
        for (place, value), (_, other) in zip(before, after, strict=True):
            assert _same(value, other), f"{name}{place}"


def _leaves(one: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """All objects inside an object, with their paths."""
    if isinstance(one, dict):
        for key, value in one.items():
            yield from _leaves(value, f"{place}[{key!r}]")
    elif isinstance(one, list | tuple):
        yield f"{place} length", len(one)
        for k, value in enumerate(one):
            yield from _leaves(value, f"{place}[{k}]")
    elif hasattr(one, "__dict__") and not isinstance(one, type):
        yield f"{place} args", str(getattr(one, "args", ""))
        for key, value in vars(one).items():
            yield from _leaves(value, f"{place}.{key}")
    else:
        yield place, one


def _same(one: Any, other: Any) -> bool:
    """Equal to the last bit, NaN to NaN, and arrays as read-only as they were."""
    if isinstance(one, np.ndarray):
        return (
            one.flags.writeable == other.flags.writeable
            and one.dtype == other.dtype
            and one.shape == other.shape
            and one.tobytes() == other.tobytes()
        )
    return type(one) is type(other) and (one == other or one != one)


@pytest.mark.parametrize("name", ["chain", "belt"])
def test_scene_without_a_pair_is_valid_after_a_pickle(name: str) -> None:
    scene = fl.read_scene(SCENES / f"{name}.toml")
    scene.check()
    found = pickle.loads(pickle.dumps(scene))
    assert found == scene
    found.check()


def test_error_of_another_process_arrives() -> None:
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool, pytest.raises(fl.SceneError) as caught:
        pool.submit(fl.Scene.from_dict, {}).result(timeout=60)
    assert str(caught.value).startswith("body_1.kind: expected 'gear' or ")
