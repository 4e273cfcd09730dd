"""Pictures of design studies: which are drawn, and that they show the numbers of the study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import flankload.plot as pictures
from flankload.plot.study_table import StudyTable, label, pareto_front
from flankload.studies.design import Designs, DesignStudy
from flankload.studies.design.run import Outcome
from flankload.studies.design.run_designs import Row
from flankload.studies.variables import variables_of

TORQUE = "load.torque_Nm"
RELIEF = "body_1.tip_relief_um, body_2.tip_relief_um"
START = "body_1.tip_relief_start_diameter_mm"
ERROR, PRESSURE = "transmission_error_peak_to_peak_um", "peak_pressure_MPa"
CURVE = "transmission_error_um"
RANGE = {"distribution": "uniform", "lower": 0, "upper": 60}
POSITIONS_RAD = [0.0, 0.1, 0.2, 0.3]


def error_um(torque: float, relief: float, start: float) -> float:
    """Least at a relief of 0.1 um per N m and a start diameter of 76 mm."""
    return 1 + abs(relief - 0.1 * torque) / 10 + abs(start - 76)


def pressure_mpa(torque: float, relief: float, start: float) -> float:
    """Rises with the relief."""
    return torque + 10 * relief + start


def made_up_study(
    variables: dict[str, Any],
    kind: str = "factorial",
    *,
    torques: Sequence[float] = (),
    failed: Sequence[int] = (),
    n: int | None = None,
) -> DesignStudy:
    """A study with these formulas in place of runs."""
    designs = Designs(variables_of(variables), kind, n)
    scene = {TORQUE: 300, RELIEF: 20, START: 75, "text": None}
    rows = []
    for number, values in enumerate(designs):
        given = scene | values
        results = []
        for torque in torques or (given[TORQUE],):
            error, pressure = (
                formula(torque, given[RELIEF], given[START]) for formula in (error_um, pressure_mpa)
            )
            curve = [error * k for k in range(len(POSITIONS_RAD))]
            quantities = {ERROR: error, PRESSURE: pressure, CURVE: curve}
            found = {"position_rad": POSITIONS_RAD, **quantities}
            results.append({"torque_Nm": torque, "quantities": found, "estimate": {}})
        outcome = Outcome("solved", results=tuple(results))
        rows.append(Row(number, values, Outcome("failed") if number in failed else outcome))
    of_scene = {variable.name: scene[variable.name] for variable in designs.variables}
    return DesignStudy(
        "pair", designs, (ERROR, PRESSURE, CURVE), tuple(rows), of_scene, bool(torques)
    )


def new_axes() -> Axes:
    return Figure().add_subplot()


def words(axes: Axes) -> list[str]:
    """Texts above the axes."""
    legend = axes.get_legend()
    assert legend is not None
    found = [legend.get_title().get_text(), *(text.get_text() for text in legend.get_texts())]
    return [text for text in found if text]


# --- choice ---------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("study", "names"),
    [
        (made_up_study({RELIEF: [0, 30], START: [75, 76]}), "map map pareto"),
        (
            made_up_study({TORQUE: [100, 300], RELIEF: [0, 30]}),
            "curve torques curve torques pareto",
        ),
        (made_up_study({TORQUE: [100, 300]}), "curve curve pareto"),
        (
            made_up_study({RELIEF: [0, 30], START: [75, 76]}, "one-at-a-time", torques=[1, 2]),
            "curve torques curve torques pareto",
        ),
        (made_up_study({RELIEF: [0, 30]}, "list"), "curve curve pareto"),
        (made_up_study({RELIEF: [0, 30], START: [75, 76]}, "list"), "pareto"),
        (made_up_study({RELIEF: RANGE}, "random", n=4), "histogram histogram bands pareto"),
        (made_up_study({RELIEF: RANGE}, "sobol", n=4), "histogram histogram bands pareto"),
        (made_up_study({RELIEF: [0, 30]}, failed=[0, 1]), ""),
    ],
)
def test_pictures_suit_the_study(study: DesignStudy, names: str) -> None:
    found = pictures.study_figures(study)
    assert [name.partition("_")[0] for name in found] == names.split()


def test_each_torque_of_a_list_has_a_panel_and_many_of_them_are_chosen(tmp_path: Path) -> None:
    study = made_up_study({RELIEF: [0, 30, 60], START: [75, 76]}, torques=range(100, 900, 50))
    figure = pictures.study_figures(study)[f"map_{ERROR}"]()
    maps = [axes for axes in figure.axes if axes.get_xlabel()]
    expected = ["100 N m", "250 N m", "400 N m", "550 N m", "700 N m", "850 N m"]
    assert [words(axes)[0] for axes in maps] == expected
    few = made_up_study({RELIEF: [0, 30, 60], START: [75, 76]})
    paths = pictures.write_study(few, tmp_path / "new")
    assert sorted(path.name for path in paths) == sorted(
        p.name for p in (tmp_path / "new").iterdir()
    )
    assert all(path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" for path in paths)


# --- map and curve --------------------------------------------------------------------------------
def test_a_map_has_the_values_a_gap_and_the_least_value() -> None:
    reliefs, starts = [60, 0, 30], [74.0, 75.0, 76.0, 77.0]
    study = made_up_study({RELIEF: reliefs, START: starts}, failed=[0])
    axes = new_axes()
    pictures.draw_map(axes, study, ERROR, (RELIEF, START))
    cells = axes.collections[0].get_array()
    expected = [[error_um(300, relief, start) for relief in (0, 30, 60)] for start in starts]
    np.testing.assert_array_equal(np.ma.getmaskarray(cells).nonzero(), [[0], [2]])
    np.testing.assert_array_equal(cells.compressed(), np.delete(np.ravel(expected), 2))
    (star,) = axes.lines
    np.testing.assert_array_equal(star.get_xydata(), [[30, 76]])
    assert words(axes) == ["300 N m", "least 1 µm at (30, 76)"]
    assert axes.get_xlabel() == "tip relief of both bodies in µm"
    assert axes.get_ylabel() == "tip relief start diameter of body 1 in mm"
    bar = axes.get_figure().axes[1]
    assert bar.get_ylabel() == "transmission error peak to peak in µm"
    assert len(axes.collections) == 2  # contour lines
    assert axes.texts  # with their levels


def test_a_map_is_the_least_over_further_variables() -> None:
    study = made_up_study(
        {TORQUE: [300, 100], RELIEF: [0, 10], START: [76, 75], "text": ["b", "a"]}
    )
    axes = new_axes()
    pictures.draw_map(axes, study, ERROR, (RELIEF, "text"), torque=0)
    np.testing.assert_allclose(axes.collections[0].get_array(), [[2, 1], [2, 1]])
    assert words(axes)[0] == "100 N m, least over the other variables"
    assert [text.get_text() for text in axes.get_yticklabels()] == ["b", "a"]


def test_curves_have_a_line_per_torque_a_gap_and_the_least_values() -> None:
    reliefs = [0, 15, 30, 45]
    study = made_up_study({TORQUE: [300, 100], RELIEF: reliefs}, failed=[1])
    axes = new_axes()
    pictures.draw_curve(axes, study, ERROR, RELIEF)
    lines, stars = axes.lines[::2], axes.lines[1::2]
    for line, torque in zip(lines, (100, 300), strict=True):
        expected = [error_um(torque, relief, 75) for relief in reliefs]
        expected[1] = np.nan if torque == 300 else expected[1]
        np.testing.assert_allclose(line.get_xydata(), np.column_stack([reliefs, expected]))
    assert [star.get_xydata().tolist() for star in stars] == [[[15, 2.5]], [[30, 2.0]]]
    assert words(axes) == ["100 N m: least 2.5 µm at 15 µm", "300 N m: least 2 µm at 30 µm"]


def test_a_variable_alone_has_the_value_of_the_scene_too() -> None:
    study = made_up_study({RELIEF: [0, 30], START: [74, 76]}, "one-at-a-time")
    axes = new_axes()
    pictures.draw_curve(axes, study, ERROR, START)
    expected = [[start, error_um(300, 20, start)] for start in (74, 75, 76)]
    np.testing.assert_allclose(axes.lines[0].get_xydata(), expected)


def test_one_value_and_that_of_the_scene_are_a_curve() -> None:
    study = made_up_study({RELIEF: [30], START: [76]}, "one-at-a-time")
    figure = pictures.study_figures(study)[f"curve_{ERROR}"]()
    found = [axes.lines[0].get_xdata().tolist() for axes in figure.axes]
    assert found == [[20, 30], [75, 76]]


def test_lists_of_torques_as_values_are_no_numbers() -> None:
    study = made_up_study({RELIEF: [0, 30], START: [75, 76]})
    variables = variables_of({TORQUE: [[100], [300]], RELIEF: [0, 30]})
    rows = tuple(
        Row(row.number, values, row.outcome)
        for row, values in zip(study.rows, Designs(variables), strict=True)
    )
    table = StudyTable(replace(study, designs=Designs(variables), rows=rows))
    axes, _ = table.gathered(ERROR, (TORQUE, RELIEF))
    assert axes == [["[100]", "[300]"], [0, 30]]


@pytest.mark.parametrize(
    ("variables", "kind"),
    [({RELIEF: [0, 30, 60], START: [74, 75, 76]}, "factorial"), ({RELIEF: RANGE}, "random")],
)
def test_a_torque_without_values_is_an_empty_panel(variables: dict[str, Any], kind: str) -> None:
    study = made_up_study(variables, kind, torques=[0, 300], n=4 if kind == "random" else None)
    for row in study.rows:
        quantities = row.outcome.results[0]["quantities"]
        quantities.update({ERROR: None, PRESSURE: None, CURVE: None})
    for figure in pictures.study_figures(study).values():
        drawn = figure()
        drawn.draw_without_rendering()
        if not drawn.axes[0].get_xlabel().startswith("torque"):
            assert words(drawn.axes[0])[0].startswith("0 N m")
        else:
            assert words(drawn.axes[0])[1].startswith("least mean: ")


def test_a_quantity_that_the_study_lacks_is_refused() -> None:
    study = made_up_study({RELIEF: [0, 30]})
    line = f"quantity: expected {ERROR}, {PRESSURE}, {CURVE}, found 'a'"
    with pytest.raises(ValueError, match=line):
        pictures.draw_histogram(new_axes(), study, "a")


def test_a_curve_over_another_name_is_refused() -> None:
    study = made_up_study({RELIEF: [0, 30]})
    with pytest.raises(ValueError, match=f"variable: expected {RELIEF}, found 'a'"):
        pictures.draw_curve(new_axes(), study, ERROR, "a")


# --- torque, percentiles, front -------------------------------------------------------------------
@pytest.mark.parametrize("as_variable", [True, False])
def test_the_design_of_the_least_mean_is_emphasised(as_variable: bool) -> None:
    torques, reliefs = [400, 100, 200], [0, 20, 50]
    variables = {TORQUE: torques, RELIEF: reliefs} if as_variable else {RELIEF: reliefs}
    study = made_up_study(variables, torques=() if as_variable else torques)
    axes = new_axes()
    pictures.draw_over_torque(axes, study, ERROR)
    lines = {
        relief: [[torque, error_um(torque, relief, 75)] for torque in sorted(torques)]
        for relief in reliefs
    }
    np.testing.assert_allclose(axes.lines[0].get_xydata(), lines[20])
    np.testing.assert_allclose(axes.collections[0].get_segments(), [lines[0], lines[50]])
    assert words(axes) == ["2 other designs", "least mean: tip relief of both bodies = 20 µm"]


def test_a_torque_without_a_solution_is_a_gap() -> None:
    study = made_up_study({TORQUE: [100, 200, 400], RELIEF: [0, 20]}, failed=[3])
    axes = new_axes()
    pictures.draw_over_torque(axes, study, ERROR)
    (other,) = axes.collections[0].get_paths()
    assert np.isnan(other.vertices[:, 1]).tolist() == [False, True, False]
    assert words(axes)[1] == "least mean: tip relief of both bodies = 0 µm"
    assert np.isfinite(axes.get_ylim()).all()


def test_bands_are_percentiles_of_the_curves() -> None:
    study = made_up_study({RELIEF: RANGE}, "random", n=50, failed=[7])
    axes = new_axes()
    pictures.draw_bands(axes, study, CURVE)
    curves = study.values(CURVE)
    # the failed design is below all others, then above
    below, above = np.nan_to_num(curves, nan=-1e9), np.nan_to_num(curves, nan=1e9)
    for band, percents in zip(axes.collections, ((5, 95), (25, 75)), strict=True):
        low, high = (
            np.percentile(c, p, axis=0) for c, p in zip((below, above), percents, strict=True)
        )
        corners = band.get_paths()[0].vertices
        np.testing.assert_allclose([corners[:, 1].min(), corners[:, 1].max()], [0, high[-1]])
        for angle, ends in zip(
            np.degrees(POSITIONS_RAD), np.column_stack([low, high]), strict=True
        ):
            there = corners[np.isclose(corners[:, 0], angle), 1]
            np.testing.assert_allclose([there.min(), there.max()], ends)
    median = np.column_stack([np.degrees(POSITIONS_RAD), np.median(above, axis=0)])
    np.testing.assert_allclose(axes.lines[0].get_xydata(), median)
    assert words(axes)[0] == "300 N m, 49 designs, 1 without a value"
    assert axes.get_xlabel() == "angle of body 1 in degrees"


def test_percentiles_among_failed_designs_are_not_drawn() -> None:
    study = made_up_study({RELIEF: RANGE}, "random", n=100, failed=range(11))
    bands, histogram = new_axes(), new_axes()
    pictures.draw_bands(bands, study, CURVE)
    pictures.draw_histogram(histogram, study, PRESSURE)
    assert words(bands)[1:] == ["25 to 75 %", "median"]
    assert words(histogram)[-1] == "5 % and 95 %: failed, failed"
    assert np.isfinite(histogram.get_xlim()).all()


def test_curves_of_other_positions_are_interpolated() -> None:
    study = made_up_study({RELIEF: RANGE}, "random", n=2)
    for result in study.rows[1].outcome.results:
        result["quantities"]["position_rad"] = [0.0, 0.15, 0.3]
        result["quantities"][CURVE] = [1.0, 4.0, 7.0]
    axes = new_axes()
    pictures.draw_bands(axes, study, CURVE)
    first = study.values(CURVE)[0]
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 0.5 * (first + np.array([1, 3, 5, 7])))


def test_a_histogram_counts_all_designs_and_has_percentiles() -> None:
    study = made_up_study({RELIEF: RANGE}, "sobol", n=64, torques=[100, 300], failed=[3])
    axes = new_axes()
    pictures.draw_histogram(axes, study, PRESSURE, torque=0)
    values = study.values(PRESSURE)[:, 0]
    # the failed design is below all others, then above
    below, above = np.nan_to_num(values, nan=-1e9), np.nan_to_num(values, nan=1e9)
    values = values[np.isfinite(values)]
    (stairs,) = axes.patches
    counts, edges, _ = stairs.get_data()
    assert counts.sum() == 63
    np.testing.assert_allclose(edges[[0, -1]], [values.min(), values.max()])
    places = [line.get_xdata()[0] for line in axes.lines if len(line.get_xdata())]
    expected = [np.percentile(above if p >= 50 else below, p) for p in (50, 25, 75, 5, 95)]
    np.testing.assert_allclose(places, expected)
    assert words(axes)[:2] == ["100 N m, 63 designs, 1 without a value", f"median: {places[0]:.4g}"]


def test_equal_values_are_a_histogram() -> None:
    study = made_up_study({"text": RANGE}, "random", n=3)
    axes = new_axes()
    pictures.draw_histogram(axes, study, ERROR)
    assert axes.patches[0].get_data()[0].sum() == 3


def test_the_front_has_the_designs_that_none_surpasses() -> None:
    reliefs = [0, 10, 20, 30, 40]
    study = made_up_study({RELIEF: reliefs}, failed=[1])
    axes = new_axes()
    pictures.draw_pareto(axes, study, (ERROR, PRESSURE))
    points = [[error_um(300, relief, 75), pressure_mpa(300, relief, 75)] for relief in reliefs]
    dots, front = axes.lines
    np.testing.assert_allclose(dots.get_xydata(), [points[k] for k in (0, 2, 3, 4)])
    np.testing.assert_allclose(front.get_xydata(), [points[k] for k in (3, 2, 0)])
    assert words(axes) == ["300 N m", "4 designs", "Pareto front, 3 designs"]
    assert axes.get_xlabel().endswith("in µm\n(less is better)")
    assert axes.get_ylabel() == "peak pressure in MPa\n(less is better)"


def test_a_front_by_comparing_all_pairs() -> None:
    points = np.random.default_rng(1).integers(0, 12, (60, 2)).astype(float)
    surpassed = [
        any((other <= point).all() and (other < point).any() for other in points)
        for point in points
    ]
    expected = np.unique(points[~np.array(surpassed)], axis=0)
    np.testing.assert_array_equal(points[pareto_front(points)], expected)


# --- words ----------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "words"),
    [
        (TORQUE, "torque in N m"),
        ("pair.center_distance_mm", "center distance in mm"),
        ("body_1.profile_shift", "profile shift of body 1"),
        ("body_2.profile.tip_relief_um", "profile, tip relief of body 2 in µm"),
        ("body_1.pitch_errors_um[3]", "pitch errors[3] of body 1 in µm"),
        ("stiffness_tangent_mean_N_per_um", "stiffness tangent mean in N/µm"),
        ("body_1.thermal_expansion_per_K", "thermal expansion of body 1 in 1/K"),
        ("root_stress_1.tension.stress_MPa", "root stress 1, tension, stress in MPa"),
        (
            "body_1.bore_diameter_mm, body_2.rim_diameter_mm",
            "bore diameter of body 1, rim diameter of\nbody 2 in mm",
        ),
    ],
)
def test_labels_have_words_and_units(name: str, words: str) -> None:
    assert label(name) == words


def test_pictures_fit_the_page_and_are_vectors(tmp_path: Path) -> None:
    study = made_up_study({RELIEF: [0, 30, 60], START: [74, 75, 76]}, torques=[100, 300])
    figures = pictures.study_figures(study)
    for name, images in ((f"map_{ERROR}", 2), (f"torques_{ERROR}", 0), ("pareto", 0)):
        drawn = figures[name]()
        drawn.savefig(tmp_path / f"{name}.svg")
        text = (tmp_path / f"{name}.svg").read_text(encoding="utf-8")
        assert text.count("<image") == images  # one in each colour bar, by matplotlib
        width, height = drawn.get_size_inches()
        for axes in drawn.axes:
            box = axes.get_tightbbox().transformed(drawn.dpi_scale_trans.inverted())
            assert -0.02 < box.x0 < box.x1 < width + 0.02
            assert -0.02 < box.y0 < box.y1 < height + 0.02


def test_a_table_without_other_variables_has_no_torque_columns() -> None:
    assert StudyTable(made_up_study({TORQUE: [1, 2]})).torques_Nm.shape == (2, 1)
    assert StudyTable(made_up_study({TORQUE: [1, 2], RELIEF: [3, 4]})).torques_Nm.shape == (2, 2)
