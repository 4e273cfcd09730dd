"""The public names: their short forms, refused arguments, imports."""

import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import make_dataclass
from typing import Any, cast

import numpy as np
import pytest
from scipy.stats import norm

import flankload as fl
from flankload.base.card import Card
from flankload.result.drives import BeltDrive, ChainDrive
from flankload.result.friction import FrictionResult
from flankload.result.optional_results import CoastContact, ShaftLoads
from flankload.result.root_stress import RootStress
from flankload.result.slices import SliceLoads
from tests.support.made_up_result import made_up_result
from tests.support.paths import SCENES

SCENE = fl.read_scene(SCENES / "external_gear.toml")
WRONG = cast("Any", 5)
NO_SCENE = (
    "scene: expected a Scene, a GearPair or its like, the path of a scene file, or a dictionary, "
    "found "
)
TORQUES = {"load.torque_Nm": [100, 302]}
RELIEF = [{"paths": "body_1.tip_relief_um", "lower": 0, "upper": 80}]
OF_SCENE: dict[str, Callable[[Any], Any]] = {
    "solve": fl.solve,
    "prepare": fl.prepare,
    "plan": fl.plan,
    "accuracy": fl.accuracy,
    "study": lambda scene: fl.study(scene, TORQUES),
    "sensitivity": lambda scene: fl.sensitivity(scene, ["load.torque_Nm"]),
    "optimise": lambda scene: fl.optimise(scene, RELIEF, "peak_pressure_MPa"),
    "robust": lambda scene: fl.robust(scene, {"load.torque_Nm": norm(302, 3)}),
    "verify": fl.verify,
    "explore": lambda scene: fl.explore(scene, open_browser=False),
}


def test_dir_shows_the_public_names() -> None:
    assert dir(fl) == sorted(fl.__all__)
    assert all(getattr(fl, name) is not None for name in dir(fl))


@pytest.mark.parametrize("name", OF_SCENE)
@pytest.mark.parametrize("wrong", [5, None, [1, 2], "made-up"])
def test_an_argument_that_is_no_scene_is_refused_in_one_line(name: str, wrong: Any) -> None:
    given = made_up_result() if wrong == "made-up" else wrong
    with pytest.raises(fl.InputError) as caught:
        OF_SCENE[name](given)
    line = str(caught.value)
    assert line.startswith(NO_SCENE)
    assert "\n" not in line
    assert len(line) < 200


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (lambda: fl.solve(SCENE, WRONG), "progress: expected a function, found 5"),
        (lambda: fl.solve(SCENE, plan=WRONG), "plan: expected a Plan, found 5"),
        (lambda: fl.read_scene(WRONG), "path: expected the path of a scene file, found 5"),
        (
            lambda: fl.Scene.from_dict(SCENE.to_dict(), file=WRONG),
            "file: expected a path, found 5",
        ),
        (
            lambda: fl.sensitivity(SCENE, "load.torque_Nm"),
            "paths: expected a sequence of paths, found 'load.torque_Nm'",
        ),
        (
            lambda: fl.sensitivity(SCENE, cast("Any", None)),
            "paths: expected a sequence of paths, found None",
        ),
        (
            lambda: fl.accuracy(SCENE, "transmission_error"),
            "quantities: expected a sequence of names, found 'transmission_error'",
        ),
        (
            lambda: fl.accuracy(SCENE, budget_s=cast("Any", "long")),
            "budget_s: expected a number, found 'long'",
        ),
        (lambda: fl.accuracy(SCENE, resume=WRONG), "resume: expected a path, found 5"),
        (lambda: fl.study(SCENE, TORQUES, store=WRONG), "store: expected a path, found 5"),
        (
            lambda: fl.study(SCENE, TORQUES, executor=cast("Executor", WRONG)),
            "executor: expected an Executor, found 5",
        ),
        (
            lambda: fl.study(SCENE, TORQUES, quantities=WRONG),
            "quantities: expected a non-empty list of names, found 5",
        ),
        (
            lambda: fl.verify(SCENE, position=cast("Any", 1.5)),
            "position: expected an integer, found 1.5",
        ),
        (lambda: fl.verify(SCENE, folder=WRONG), "folder: expected a path, found 5"),
        (
            lambda: fl.iso_1328(7, teeth=cast("Any", "x"), module_mm=2, face_width_mm=10),
            "teeth: expected a number, found 'x'",
        ),
    ],
)
def test_wrong_arguments_are_refused_by_name(call: Callable[[], Any], line: str) -> None:
    with pytest.raises(fl.FlankloadError) as caught:
        call()
    assert str(caught.value) == line


def test_a_result_is_shown_in_few_lines() -> None:
    one = made_up_result(name="<b>bold</b> & Co")
    lines = repr(one).splitlines()
    assert lines[0] == "Result '<b>bold</b> & Co'"
    assert len(lines) <= 20
    shown = {line.split()[0]: line.split(maxsplit=1)[1] for line in lines[1:]}
    assert shown["torque_Nm"] == "302"
    assert shown["positions"] == "32 from 0 to 21.7969 deg, over the whole period"
    assert shown["peak_pressure_MPa"].endswith("(+- 0.8%)")
    assert shown["warnings"] == "1: see result.warnings"
    page = one._repr_html_()
    assert "&lt;b&gt;bold&lt;/b&gt; &amp; Co" in page
    assert "<b>" not in page
    several = repr(fl.Result.of_torques([made_up_result(torque_Nm=100.0 + t) for t in range(40)]))
    assert len(several.splitlines()) <= 20
    assert max(map(len, several.splitlines())) < 150
    assert "100, 101, 102" in several


def test_values_of_a_card_are_escaped_and_long_ones_are_cut() -> None:
    fields = [("word", str, "a < b\nc"), *((f"field_{n}", int, n) for n in range(30))]
    card = make_dataclass("Long", fields, bases=(Card,), frozen=True, repr=False)()
    lines = repr(card).splitlines()
    assert len(lines) == 20
    assert lines[:2] == ["Long", "  word      a < b c"]
    assert lines[-1] == "  ...       13 more"
    assert "a &lt; b c" in card._repr_html_()
    wide = make_dataclass(
        "Wide", [("numbers", tuple, tuple(range(200)))], bases=(Card,), repr=False
    )
    assert len(repr(wide())) < 120


def test_public_objects_are_short() -> None:
    state = fl.solve_contact(
        np.eye(60), np.ones(60), np.zeros(60), 2.0, normal_lever_arms=np.ones(60)
    )
    result, prepared = made_up_result(), fl.Prepared.__new__(fl.Prepared)
    prepared.scene = SCENE
    for shown in (state, SCENE, result.pairs(0), result.stiffness_table(), prepared):
        assert len(repr(shown).splitlines()) <= 20
        assert len(repr(shown)) < 2500
    assert "teeth = 16" in repr(SCENE)
    assert "float64 array (60,)" in repr(state)
    for name in ("Plan", "AccuracyStudy", "DesignStudy", "Robust", "Verification", "Sensitivity"):
        assert getattr(fl, name).__repr__ is Card.__repr__
    for part in (BeltDrive, ChainDrive, CoastContact, FrictionResult, RootStress, ShaftLoads):
        assert part.__repr__ is Card.__repr__
    assert SliceLoads.__repr__ is Card.__repr__


def test_the_former_name_of_accuracy_studies_is_accepted_with_a_warning() -> None:
    """`fl.Study` was mistaken for the result of `fl.study`."""
    assert "Study" not in fl.__all__
    with pytest.warns(DeprecationWarning, match="AccuracyStudy, which accuracy returns"):
        assert fl.Study is fl.AccuracyStudy


def test_import_and_run_load_no_package_for_tables() -> None:
    code = (
        "import sys, flankload as fl; assert 'numpy' not in sys.modules; fl.solve; "
        "import flankload.cli; assert not {'pandas', 'xarray', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_dataframes_have_a_row_per_position_pair_or_torque() -> None:
    pytest.importorskip("pandas")
    one = made_up_result()
    found = fl.Result.of_torques([made_up_result(torque_Nm=100.0), one])
    table = found.to_dataframe()
    assert len(table) == 64
    assert list(table.columns[:5]) == [
        "torque_Nm",
        "position_rad",
        "position_deg",
        "rotation_rad",
        "rotation_deg",
    ]
    own = table[table.torque_Nm == 302.0]
    np.testing.assert_array_equal(own.transmission_error_um, one.transmission_error_um)
    np.testing.assert_allclose(own.position_deg, np.degrees(one.position_rad))
    pairs = found.pairs_dataframe()
    assert len(pairs) == 2 * 32 * 3
    shares = pairs.groupby(["torque_Nm", "position_rad"]).load_share.sum()
    np.testing.assert_allclose(shares, 1.0)
    middle = pairs[(pairs.pair == 0) & (pairs.torque_Nm == 302.0)]
    np.testing.assert_array_equal(middle.site_force_N, one.site_force_N[:, 1])
    assert len(one.pairs_dataframe()) == 32 * 3
    summary = found.summary_dataframe().set_index("torque_Nm")
    assert summary.peak_pressure_MPa[302.0] == one.summary["peak_pressure_MPa"]
    harmonics = one.summary["transmission_error_harmonics_um"]
    assert summary["transmission_error_harmonics_um.1"][302.0] == harmonics[1]


@pytest.mark.parametrize("method", ["to_dataframe", "pairs_dataframe", "summary_dataframe"])
def test_without_pandas_the_extra_is_named(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError) as caught:
        getattr(made_up_result(), method)()
    line = f"{method} needs the package pandas: pip install 'flankload[pandas]'"
    assert str(caught.value) == line
