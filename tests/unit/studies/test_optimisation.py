"""Optimisation: the search on closed forms, a spur pair against all points of a grid, errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.cli import main
from flankload.studies.optimisation.evaluation import Evaluator
from flankload.studies.optimisation.figures import DIRECTIONS, MAXIMA, figure_of
from flankload.studies.optimisation.local_model import Goals, Maximum, Point
from flankload.studies.optimisation.problem import (
    Constraint,
    Objective,
    Options,
    variables_of,
)
from flankload.studies.optimisation.run_optimisation import hypercube
from flankload.studies.optimisation.search import (
    CONVERGED,
    SHORT,
    USED_UP,
    Descent,
    best_of,
    descend,
    gradient_norm,
)
from tests.support.paths import ROOT, SCENES
from tests.support.tolerances import ROUND_OFF

PEAK_TO_PEAK = "transmission_error_peak_to_peak_um"
PRESSURE, MEAN = "peak_pressure_MPa", "transmission_error_mean_um"
COARSE = {
    "positions.count": 8,
    "accuracy.flank_element_mm": 4.0,
    "accuracy.strips_per_half_width": 2.5,
    "accuracy.corner_strips_per_half_width": 2.5,
    "accuracy.estimate": False,
    "accuracy.tangents": False,
}
RELIEF = {
    "body_1.tip_relief_um": 20.0,
    "body_2.tip_relief_um": 20.0,
    "body_1.tip_relief_start_diameter_mm": 78.0,
    "body_2.tip_relief_start_diameter_mm": 114.0,
}
AMOUNT: dict[str, Any] = {
    "paths": ["body_1.tip_relief_um", "body_2.tip_relief_um"],
    "lower": 0,
    "upper": 80,
}
START: dict[str, Any] = {
    "paths": "body_1.tip_relief_start_diameter_mm",
    "lower": 73,
    "upper": 81,
}

ON_KINK: dict[str, Any] = {
    "body_1.tip_relief_start_diameter_mm": 76.5,
    "body_2.tip_relief_start_diameter_mm": 112.5,
    "load.torque_Nm": 20.0,
    "positions": {"angles_deg": [7.0]},
}


def scene(**changes: Any) -> fl.Scene:
    return fl.read_scene(SCENES / "external_gear.toml").replace(COARSE | RELIEF | changes)


@cache
def grid() -> np.ndarray:
    """Peak to peak, mean, amount and start diameter at all points of a grid."""
    prepared = fl.prepare(scene())
    rows = []
    for amount in np.linspace(30.0, 50.0, 5):
        for diameter in np.linspace(75.0, 79.0, 5):
            changes = dict.fromkeys(AMOUNT["paths"], amount) | {START["paths"]: diameter}
            summary = prepared.solve(changes).summary
            rows.append([summary[PEAK_TO_PEAK], summary[MEAN], amount, diameter])
    return np.array(rows)


# --- the search on closed forms -------------------------------------------------------------------
def searched(
    functions: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    start: tuple[float, ...],
    *,
    rows: tuple[int, ...],
    limits: tuple[float, ...] = (),
    impossible: Callable[[np.ndarray], bool] = lambda x: False,
    **options: Any,
) -> tuple[Descent, int]:
    """Search in a box from -3 to 3; each function belongs to a row, row 0 is the objective."""
    count = 0
    low, width = -3.0, 6.0

    def solve(part: np.ndarray) -> Point | None:
        nonlocal count
        count += 1
        x = low + width * part
        if impossible(x):
            return None
        values, gradients = functions(x)
        maxima = [
            Maximum(r, values[np.array(rows) == r], width * gradients[np.array(rows) == r])
            for r in sorted(set(rows))
        ]
        return Point(part, tuple(maxima), 1 + len(limits))

    first = solve((np.array(start) - low) / width)
    assert first is not None
    goals = Goals(np.eye(1 + len(limits)), 1, np.array(limits))
    goals = replace(goals, scale=abs(goals.objective(first)), margin=1e-3)
    return descend(solve, first, goals, Options(**options)), count


def crescent(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Problem CB2 of C. Charalambous and A. R. Conn (1978): minimax of three functions."""
    a, b = x
    e = 2.0 * np.exp(b - a)
    values = np.array([a**2 + b**4, (2 - a) ** 2 + (2 - b) ** 2, e])
    return values, np.array([[2 * a, 4 * b**3], [2 * (a - 2), 2 * (b - 2)], [-e, e]])


def test_search_finds_the_optimum_of_a_minimax_problem() -> None:
    end, count = searched(crescent, (1.0, -0.1), rows=(0, 0, 0), tolerance=1e-7)
    # its published optimum
    np.testing.assert_allclose(-3 + 6 * end.point.x, [1.139038, 0.899560], rtol=0, atol=2e-4)
    assert end.goals.objective(end.point) == pytest.approx(1.952224, rel=1e-6)
    assert count <= 50
    assert gradient_norm(end.point, end.goals) < 1e-2


def test_search_keeps_a_limit_and_raises_the_penalty_that_is_too_small() -> None:
    """Minimum of 50 a + 50 b within the circle a^2 + b^2 <= 2, relative multiplier 1/2."""

    def functions(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([50 * x.sum(), x @ x]), np.array([[50.0, 50.0], 2 * x])

    for start in ((0.01, 0.0), (2.0, 2.5)):  # a scale of 0.5: a relative multiplier of 100
        end, _ = searched(functions, start, rows=(0, 1), limits=(2.0,), most_evaluations=200)
        np.testing.assert_allclose(-3 + 6 * end.point.x, [-1.0, -1.0], rtol=0, atol=0.1)
        assert end.goals.objective(end.point) == pytest.approx(-100.0, rel=5e-3)
        assert end.goals.excess(end.point).max() <= 1e-3


def test_search_goes_around_points_without_a_solution() -> None:
    """A parabola with its minimum where no scene has a solution: the search ends at the border."""

    def bowl(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([1.0 + x @ x]), 2.0 * x[None]

    end, _ = searched(bowl, (2.0, 1.0), rows=(0,), impossible=lambda x: x[0] < 0.5)
    a, b = -3 + 6 * end.point.x
    assert 0.5 <= a < 0.6
    assert abs(b) < 1.0
    assert end.reason in (SHORT, CONVERGED)
    end, count = searched(bowl, (2.0, 1.0), rows=(0,), most_evaluations=2)
    assert (count, end.reason) == (2, USED_UP)


def test_a_point_within_the_limits_is_better_than_one_of_less_merit() -> None:
    goals = Goals(np.eye(2), 1, np.array([1.0]), penalty=10.0)

    def point(objective: float, figure: float) -> Point:
        numbers = [(0, objective), (1, figure)]
        maxima = [Maximum(row, np.array([x]), np.zeros((1, 1))) for row, x in numbers]
        return Point(np.zeros(1), tuple(maxima), 2)

    kept, beyond, far = point(2.0, 1.0), point(1.0, 1.01), point(1.5, 1.1)
    assert goals.merit(beyond) < goals.merit(kept)
    assert best_of([beyond, kept, far], goals) is kept
    assert best_of([far, beyond], goals) is beyond
    assert best_of([], goals) is None
    # the end of a search at a limit is within its margin
    goals = Goals(np.eye(2), 1, np.array([1.0]), margin=0.02, penalty=10.0)
    assert best_of([kept, beyond, far], goals) is beyond


def test_starting_points_are_in_different_layers_and_repeatable() -> None:
    points = hypercube(8, 3, 5)
    for column in points.T:
        assert sorted((8 * column).astype(int)) == list(range(8))
    np.testing.assert_array_equal(points, hypercube(8, 3, 5))
    assert np.abs(points - hypercube(8, 3, 6)).max() > 0


# --- key figures ----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("external_gear", COARSE | {"effects.root_stress": True}),
        (
            "helical_gear",
            {
                "positions.count": 2,
                "accuracy.flank_element_mm": 5.0,
                "accuracy.axial_degree": 4,
                "accuracy.load_degree_z": 0,
                "accuracy.slices": 3,
                "accuracy.estimate": False,
                "accuracy.tangents": False,
            },
        ),
    ],
)
def test_largest_entries_are_the_key_figures_of_the_summary(
    name: str, changes: dict[str, Any]
) -> None:
    result = fl.solve(fl.read_scene(SCENES / f"{name}.toml").replace(changes))
    three = result.slices is not None
    plane_only = ("root_stress_1.tension.stress_MPa", "root_stress_2.tension.stress_MPa")
    spatial_only = ("face_load_factor", "line_load_factor")
    names = [x for x in MAXIMA if x not in (plane_only if three else spatial_only)]
    for figure in (figure_of(x, result, "objective.quantity") for x in names):
        found = sum(np.nanmax(numbers(result)) for numbers in figure.maxima)
        assert found == pytest.approx(figure.value(result), rel=100 * ROUND_OFF)
    if not three:
        harmonic = figure_of("transmission_error_mesh_harmonics_um[1]", result, "")
        (numbers,) = harmonic.maxima
        amplitude = harmonic.value(result)
        assert np.cos(np.pi / DIRECTIONS) * amplitude <= numbers(result).max()
        assert numbers(result).max() <= amplitude * (1 + 100 * ROUND_OFF)


def test_gradients_follow_factors_ranges_and_weights() -> None:
    variables = variables_of([AMOUNT | {"factors": [1.0, 0.5]}, START])
    names = (MEAN, PRESSURE)
    evaluator = Evaluator(
        scene(**{"positions.count": 2}),
        variables,
        Objective(quantity=names, weights=(1.0, 0.01)),
        (Constraint(quantity=PRESSURE, at_most=2000.0),),
        Options(tolerance=0.01),
    )
    x, step = np.array([0.25, 0.5]), np.array([1e-4, 2e-4])
    point = evaluator.solve_surely(x)
    after = evaluator.solve_surely(x + step)
    before = evaluator.solve_surely(x - step)
    change = evaluator.goals.objective(after) - evaluator.goals.objective(before)
    predicted = evaluator.goals.objective(point, step) - evaluator.goals.objective(point, -step)
    assert predicted == pytest.approx(change, rel=0.02)
    assert evaluator.values_of(x) == (20.0, 77.0)
    np.testing.assert_allclose(evaluator.goals.limits, [1980.0], rtol=ROUND_OFF)


# --- a spur pair ----------------------------------------------------------------------------------
def test_optimum_is_as_good_as_the_best_point_of_a_grid() -> None:
    optimum = fl.optimise(scene(), [AMOUNT, START], PEAK_TO_PEAK)
    assert optimum.objective <= 1.02 * grid()[:, 0].min()
    assert optimum.evaluations <= 12
    assert optimum.failed == 0
    assert optimum.states >= 8 * optimum.evaluations
    assert optimum.continued_states > 0
    assert optimum.reason == CONVERGED
    assert optimum.gradient_norm < 0.1 * optimum.objective_before
    assert optimum.objective == pytest.approx(optimum.results[0].summary[PEAK_TO_PEAK])
    assert optimum.scene == scene().replace(
        dict.fromkeys(AMOUNT["paths"], optimum.variables[0].after)
        | {START["paths"]: optimum.variables[1].after}
    )
    assert optimum.settings == {}  # the scene has them already


def test_limit_is_kept_where_the_best_point_breaks_it() -> None:
    free = grid()[:, 1][grid()[:, 0].argmin()]
    limit = 44.75
    assert free > limit
    kept = grid()[grid()[:, 1] <= limit]
    table = {"quantity": MEAN, "at_most": limit}
    optimum = fl.optimise(scene(), [AMOUNT | {"step": 2}, START], PEAK_TO_PEAK, [table])
    assert optimum.objective <= 1.02 * kept[:, 0].min()
    assert optimum.keeps_limits
    assert optimum.active == (MEAN,)
    assert optimum.variables[0].after % 2 == 0
    assert optimum.rounding_loss is not None
    text = str(optimum)
    limited = optimum.constraints[0]
    assert f"{MEAN}  {limited.before:.6g}  {limited.after:.6g}    44.75  active" in text
    loss = 100 * optimum.rounding_loss / optimum.objective_before
    assert f"loss by rounding to steps: {loss:.2f} % of the objective before" in text


def test_a_start_with_all_contact_on_corners_has_no_pressure_to_improve() -> None:
    """At 7 deg the only loaded pair touches with the kink of its relief."""
    pair = scene(**ON_KINK)
    reason = "peak_pressure_MPa has no value: all contact is on sharp corners, where no finite"
    with pytest.raises(fl.FlankloadError, match=reason):
        fl.optimise(pair, [AMOUNT], PRESSURE)
    found = fl.study(pair, {"load.torque_Nm": [20, 30]}, quantities=[PRESSURE, MEAN])
    assert np.isnan(found.values(PRESSURE)).all()
    assert np.isfinite(found.values(MEAN)).all()
    assert f"{PRESSURE} has no value in 2 designs: all contact is on sharp" in str(found)


def test_a_limit_that_nothing_can_keep_is_said() -> None:
    table = {"quantity": PRESSURE, "at_most": 500.0}
    optimum = fl.optimise(scene(), [AMOUNT], PEAK_TO_PEAK, [table], most_evaluations=4)
    assert not optimum.keeps_limits
    assert str(optimum).endswith("limits are exceeded")


def test_worst_torque_counts_and_points_without_a_solution_are_counted() -> None:
    pair = scene(**{"load.torque_Nm": [150.0, 302.0], "positions.count": 4})
    # above the tip diameter of 82.46 mm there is no start of a relief
    diameter = START | {"upper": 90, "start": 79}
    optimum = fl.optimise(pair, [AMOUNT, diameter], PEAK_TO_PEAK, starts=2, seed=1)
    assert optimum.failed > 0
    assert f", {optimum.failed} of them without a solution" in str(optimum)
    assert optimum.ends[1] is None  # its start of the relief is at 89 mm
    assert "ends of the 2 starts: " in str(optimum)
    figures = [result.summary[PEAK_TO_PEAK] for result in optimum.results]
    assert optimum.objective == max(figures) < optimum.objective_before
    assert repr(optimum).startswith(f"Optimum({PEAK_TO_PEAK}, worst of 2 torques: ")
    # at the optimum both torques have the same peak to peak, after few evaluations nearly
    assert min(figures) == pytest.approx(max(figures), rel=0.02)


def test_weighted_sums_of_harmonics_and_torques() -> None:
    pair = scene(**{"load.torque_Nm": [150.0, 302.0], "positions.count": 6})
    names = [f"transmission_error_mesh_harmonics_um[{k}]" for k in (0, 1)]
    objective = {
        "quantity": names,
        "weights": [1.0, 0.5],
        "over": "sum",
        "torque_weights": [2.0, 1.0],
    }
    optimum = fl.optimise(pair, [AMOUNT], objective)
    one, two = (
        result.summary["transmission_error_mesh_harmonics_um"] for result in optimum.results
    )
    expected = 2 * (one[0] + 0.5 * one[1]) + two[0] + 0.5 * two[1]
    assert optimum.objective == pytest.approx(expected)
    assert optimum.objective_name == (f"{names[0]} + 0.5 {names[1]}, sum over 2 weighted torques")
    # the gradient vanishes along the only variable
    step = 0.05
    changes = dict.fromkeys(AMOUNT["paths"], optimum.variables[0].after)
    for sign in (-1, 1):
        near = fl.solve(pair.replace({key: x + sign * step for key, x in changes.items()}))
        one, two = near.summary["transmission_error_mesh_harmonics_um"]
        beside = 2 * (one[0] + 0.5 * one[1]) + two[0] + 0.5 * two[1]
        assert beside > optimum.objective * (1 - 1e-3)


def test_keys_are_set_during_the_search_only() -> None:
    pair = scene(**{"accuracy.tolerance": 0.1, "accuracy.tangents": None})
    optimum = fl.optimise(pair, [AMOUNT], PEAK_TO_PEAK, most_evaluations=2)
    assert optimum.settings == {
        "accuracy.tangents": False,
        "accuracy.tolerance": None,
    }
    assert optimum.scene.accuracy == pair.accuracy
    assert optimum.results[0].accuracy is not None  # solved to the tolerance of the scene
    assert "accuracy.tolerance = absent" in str(optimum)


# --- errors ---------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("variable", "line"),
    [
        ({"paths": None}, "variables[0].paths: expected a non-empty string or a non-empty list"),
        ({"paths": []}, "variables[0].paths: expected a non-empty list of non-empty strings"),
        (
            {"factors": [1, 2]},
            "variables[0].factors: expected 1 numbers, one per path, found [1.0, 2.0]",
        ),
        ({"factors": [0.0]}, "variables[0].factors: expected numbers other than 0, found [0.0]"),
        ({"upper": 70}, "variables[0].upper: expected a number above lower = 73, found 70"),
        ({"start": 90}, "variables[0].start: expected a number from 73 to 81, found 90"),
        ({"step": 50}, "variables[0].step: expected a multiple of it between lower and upper"),
        ({"most": 5}, "variables[0].most: expected a known key"),
        (
            {"lower": 80},
            "variables[0].start: expected a number from 80 to 81, found 78.0, the value of the",
        ),
        (
            {"paths": "body_1.end_relief_length_mm"},
            "variables[0].start: expected a number from 73 to 81, found nothing, and the scene has",
        ),
        (
            {"paths": "body_1.tip_releif_um", "start": 75},
            f"{SCENES}/external_gear.toml: body_1.tip_releif_um: expected a known key (did you",
        ),
    ],
)
def test_wrong_variables_are_refused_in_one_line(variable: dict[str, Any], line: str) -> None:
    table = {key: x for key, x in (START | variable).items() if x is not None}
    with pytest.raises(fl.SceneError) as caught:
        fl.optimise(scene(), [table], PEAK_TO_PEAK)
    assert str(caught.value).startswith(line)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ({"variables": []}, "variables: expected at least one table, found nothing"),
        ({"variables": START}, "variables: expected a list of tables, found a table"),
        ({"variables": [START, START]}, "variables[1].paths: expected paths that occur once"),
        (
            {"variables": [{"paths": list("abcdefghi"), "lower": 0, "upper": 1, "start": 1}] * 2},
            "variables[1].paths: expected paths that occur once, found a",
        ),
        ({"objective": {}}, "objective.quantity: expected a non-empty string or a non-empty list"),
        (
            {"objective": {"quantity": PRESSURE, "weights": [1, 2]}},
            "objective.weights: expected a list of 1 numbers, found [1.0, 2.0]",
        ),
        (
            {"objective": {"quantity": PRESSURE, "over": "mean"}},
            "objective.over: expected 'sum' or 'worst', found 'mean'",
        ),
        ({"objective": "pressure"}, "objective.quantity: expected a key figure of this scene ("),
        (
            {"constraints": [{"quantity": "K", "at_most": 1}]},
            "constraints[0].quantity: expected a key figure of this scene (",
        ),
        (
            {"constraints": [{"quantity": PRESSURE}]},
            "constraints[0].at_most: expected a number, found nothing",
        ),
        ({"starts": 0}, "starts: expected an integer from 1 to 1000, found 0"),
        ({"start": 3}, "start: expected a known key (did you mean starts?)"),
    ],
)
def test_wrong_problems_are_refused_in_one_line(arguments: dict[str, Any], line: str) -> None:
    arguments = {"variables": [AMOUNT], "objective": PEAK_TO_PEAK} | arguments
    with pytest.raises(fl.SceneError) as caught:
        fl.optimise(scene(**{"positions.count": 2}), **arguments)
    assert str(caught.value).startswith(line)


def test_effects_must_be_named() -> None:
    with pytest.raises(fl.SceneError, match=r"effects\.choose: expected no such key"):
        fl.optimise(scene(**{"effects.choose": "auto"}), [AMOUNT], PEAK_TO_PEAK)


# --- the command ----------------------------------------------------------------------------------
FILE = """scene = "pair.toml"
most_evaluations = 3
[[variables]]
paths = "body_1.tip_relief_um"
lower = 0
upper = 40
[objective]
quantity = "transmission_error_peak_to_peak_um"
[[constraints]]
quantity = "peak_pressure_MPa"
at_most = 20000
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "pair.toml").write_text(scene(**{"positions.count": 2}).to_toml(), "utf-8")
    path = tmp_path / "optimisation.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


def test_command_writes_the_optimal_scene(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    best = file.parent / "best.toml"
    assert main(["optimise", str(file), "-o", str(best)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith(f"FZG type C: {PEAK_TO_PEAK}\nbefore ")
    found = fl.read_scene(best)
    value = found.body_1.tip_relief_um
    assert f"body_1.tip_relief_um 20 {value:.6g} 0 40 -" in " ".join(out.split())
    assert found.replace({"body_1.tip_relief_um": 20}).to_dict() == (
        fl.read_scene(file.parent / "pair.toml").to_dict()
    )


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('scene = "pair.toml"', "", "{file}: scene: expected a non-empty string, found nothing"),
        ("pair.toml", "none.toml", "{folder}/none.toml: file: expected a scene file to read"),
        ("[[variables]]", "[variables]", "{file}: variables: expected a list of tables"),
        ("lower = 0", "", "{file}: variables[0].lower: expected a number, found nothing"),
        ("most_eval", "more_eval", "{file}: more_evaluations: expected a known key (did you mean"),
        ("[objective]", "[[objective]]", "{file}: objective: expected a table"),
        ("_peak_um", "_um", "{file}: objective.quantity: expected a key figure of this scene"),
        ("upper = 40", "upper = ", "{file}: file: expected valid TOML, found line 6"),
        ("relief_um", "releif_um", "{folder}/pair.toml: body_1.tip_releif_um: expected a known"),
    ],
)
def test_command_refuses_a_wrong_file_in_one_line(
    file: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, line: str
) -> None:
    text = FILE.replace(old, new)
    if "releif" in new:
        text = text.replace("lower = 0", "lower = 0\nstart = 1")
    file.write_text(text, encoding="utf-8")
    assert main(["optimise", str(file)]) == 2
    err = capsys.readouterr().err
    assert err.startswith("flankload: " + line.format(file=file, folder=file.parent))
    assert err.count("\n") == 1


@pytest.mark.parametrize("path", sorted((ROOT / "examples" / "optimisations").glob("*_*.toml")))
def test_files_of_the_examples_are_complete(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if path.name == "misaligned_gear.toml":  # a scene
        return
    asked: dict[str, Any] = {}
    monkeypatch.setattr(
        "flankload.studies.optimisation.optimise", lambda scene, **given: asked.update(given)
    )
    assert main(["optimise", str(path)]) == 0
    assert capsys.readouterr().out == "None\n"
    assert asked["objective"]["quantity"]
    assert all(variable.step or variable.start for variable in variables_of(asked["variables"]))


def test_command_replaces_none_of_its_inputs(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, owner in (("pair.toml", "the scene"), ("optimisation.toml", "the optimisation")):
        assert main(["optimise", str(file), "-o", str(file.parent / name)]) == 2
        assert f"-o: expected a file other than {owner}, found" in capsys.readouterr().err
