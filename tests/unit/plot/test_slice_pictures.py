"""Pictures over the face width: they show the numbers of the result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.patches import StepPatch

import flankload as fl
from flankload.plot import plot_all, plot_contact_pattern, plot_line_load, plot_line_load_map
from flankload.plot.slices import contact_pattern
from tests.support.gear_scenes import example
from tests.support.made_up_result import made_up_result

NAMES = ("line_load.png", "line_load_map.png", "contact_pattern.png")


def solved(**tables: dict[str, object]) -> fl.Result:
    tree = example("helical_gear")
    tree["positions"] = {"count": 6}
    tree["accuracy"] = {
        **{"estimate": False, "flank_element_mm": 3.0, "modes": 3},
        **{"axial_degree": 6, "load_degree_z": 2, "slices": 10},
    }
    for table, keys in tables.items():
        tree[table] = {**tree[table], **keys}
    found = fl.solve(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    return found


@pytest.fixture(scope="module")
def result() -> fl.Result:
    return solved()


def mesh_of(axes: Axes) -> QuadMesh:
    (mesh,) = (part for part in axes.collections if isinstance(part, QuadMesh))
    return mesh


def shown(axes: Axes) -> np.ndarray:
    """Values of a map, 0 where it is blank."""
    return np.nan_to_num(np.ma.filled(mesh_of(axes).get_array(), 0.0))


def steps(axes: Axes) -> dict[str, np.ndarray]:
    """Values of each stepped line by its label."""
    found = (patch for patch in axes.patches if isinstance(patch, StepPatch))
    return {patch.get_label(): np.nan_to_num(patch.get_data().values) for patch in found}


def test_they_are_made_for_three_dimensional_results_alone(
    result: fl.Result, tmp_path: Path
) -> None:
    names = {path.name for path in plot_all(result, tmp_path / "spatial")}
    assert set(NAMES) <= names
    names = {path.name for path in plot_all(made_up_result(), tmp_path / "plane")}
    assert not set(NAMES) & names


def test_line_load_of_each_pair_and_of_all(result: fl.Result) -> None:
    """At the position of the largest line load, over the whole face width."""
    assert result.slices is not None
    load = result.slice_line_load_N_per_mm
    p = int(np.unravel_index(load.argmax(), load.shape)[0])
    (axes,) = plot_line_load(result).axes
    assert f"{np.degrees(result.position_rad[p]):.2f}°" in axes.get_title(loc="left")
    lines = steps(axes)
    for s, site in enumerate(result.sites):
        name = f"pair {site}:".replace("-", "−")
        found = [values for label, values in lines.items() if label.startswith(name)]
        assert len(found) == load[p, s].any()
        for values in found:
            np.testing.assert_array_equal(values, load[p, s])
    assert (load[p].any(axis=1)).sum() > 1
    np.testing.assert_array_equal(lines["all pairs"], load[p].sum(axis=0))
    mean = result.site_force_N[p].sum() / 25.0
    (dashed,) = axes.lines
    assert np.asarray(dashed.get_ydata())[0] == pytest.approx(mean)
    assert dashed.get_label() == f"mean {mean:.0f} N/mm"
    assert axes.get_xlim() == pytest.approx((-12.5, 12.5))
    assert "axial position z" in axes.get_xlabel()
    assert "N per mm face width" in axes.get_ylabel()
    legend = axes.get_legend()
    assert f"{result.face_load_factor:.3f}" in legend.get_title().get_text()


def test_one_pair_alone_has_no_line_of_all_pairs(result: fl.Result) -> None:
    assert result.slices is not None
    force = result.slices.force_N.copy()
    force[:, result.sites != 0] = 0.0
    alone = replace(result, slices=replace(result.slices, force_N=force))
    assert "all pairs" not in steps(plot_line_load(alone).axes[0])


def test_map_of_the_line_load_has_all_pairs_in_their_order(result: fl.Result) -> None:
    """Pair j at position p is j + p/P pitches along; blank where nothing carries."""
    axes = plot_line_load_map(result).axes[0]
    wanted = result.slice_line_load_N_per_mm.transpose(1, 0, 2).reshape(-1, 10).T
    np.testing.assert_array_equal(shown(axes), wanted)
    assert np.ma.getmaskarray(mesh_of(axes).get_array())[wanted == 0].all()
    assert "pitches" in axes.get_xlabel()
    assert "axial position z" in axes.get_ylabel()


def test_contact_pattern_reaches_the_largest_pressure(result: fl.Result) -> None:
    """On both flanks, in the same slices; nothing beyond the tip."""
    largest = result.slice_peak_pressure_MPa.max(axis=(0, 1))
    for body, tip in ((1, 84.8), (2, 191.1)):
        diameter, pressure = contact_pattern(result, body)
        np.testing.assert_allclose(pressure.max(axis=0), largest, rtol=0.02)
        assert (pressure.max(axis=0) <= largest * (1.0 + 1e-4)).all()
        assert diameter.max() <= tip + 0.01


def test_contact_pattern_is_drawn_over_z_and_diameter(result: fl.Result) -> None:
    """With tip, relief and form circles of each flank on a common scale of pressures."""
    figure = plot_contact_pattern(result)
    one, two, colours = figure.axes
    assert colours.get_ylabel() == "largest pressure in MPa"
    assert mesh_of(one).get_clim() == mesh_of(two).get_clim()
    for body, axes, marks in (
        (1, one, ("tip ⌀ 84.80", "relief ⌀ 82.40")),
        (2, two, ("tip ⌀ 191.10", "relief ⌀ 189.20")),
    ):
        words = [text.get_text() for text in axes.texts]
        assert set(marks) <= set(words)
        assert any(word.startswith("form ⌀") for word in words)
        np.testing.assert_array_equal(shown(axes), contact_pattern(result, body)[1])
        assert axes.get_xlim() == pytest.approx((-12.5, 12.5))
        low, high = axes.get_ylim()
        assert low < contact_pattern(result, body)[0].min()
        assert contact_pattern(result, body)[0].max() < high
        assert "diameter" in axes.get_ylabel()


def test_more_load_where_more_metal_is() -> None:
    """A slope with metal off at larger z: both pictures are darker at smaller z."""
    sloped = solved(body_1={"helix_slope_um": 25.0})
    for body in (1, 2):
        _, pressure = contact_pattern(sloped, body)
        assert pressure[:, 1].max() > 1.1 * pressure[:, -2].max()


def test_without_load_there_is_no_contact_pattern(tmp_path: Path) -> None:
    unloaded = solved(load={"torque_Nm": 0.0})
    names = {path.name for path in plot_all(unloaded, tmp_path)}
    assert "transmission_error.png" in names
    assert not set(NAMES) & names
