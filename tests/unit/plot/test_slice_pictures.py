"""Pictures over the face width: they show the numbers of the result."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch
from matplotlib.transforms import Bbox

import flankload as fl
from flankload import plot
from flankload.base.rotation import turned
from flankload.plot import (
    loaded_pair_3d,
    plot_all,
    plot_contact_pattern,
    plot_line_load,
    plot_line_load_map,
    plot_loaded_pair,
    plot_root_stress_over_width,
)
from flankload.plot.design_study import TINTS
from flankload.plot.figures import empty_figure, fit
from flankload.plot.load_maps import FORCE_MAP, LOAD_MAP, PATTERN_MAP, contact_pattern
from flankload.plot.loaded_teeth import AXIAL_FACETS, CONTOUR_FACETS, VIEW, teeth_in_mesh
from flankload.plot.style import new_figure
from flankload.report.pictures import OF_BODIES, SIZE, plots_of
from tests.support.gear_scenes import example
from tests.support.made_up_result import made_up_result
from tests.support.solving import solve
from tests.support.stages_with_width import stage
from tests.support.tolerances import SOLVER

NAMES = ("line_load.png", "line_load_map.png", "contact_pattern.png")


def solved(name: str = "helical_gear", **tables: dict[str, object]) -> fl.Result:
    tree = example(name)
    tree["positions"] = {"count": 6}
    tree["accuracy"] = {
        **{"estimate": False, "tangents": False, "flank_element_mm": 3.0, "modes": 3},
        **{"axial_degree": 5, "load_degree_z": 1, "slices": 10},
    }
    for table, keys in tables.items():
        tree[table] = {**tree.get(table, {}), **keys}
    found = solve(fl.Scene.from_dict(tree))
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


@pytest.fixture
def others_are_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures that plane results have, too, are not drawn."""
    for name in set(plot.PICTURES) - {name.removesuffix(".png") for name in NAMES}:
        monkeypatch.setitem(plot.PICTURES, name, lambda _: new_figure((1.0, 1.0)))


@pytest.mark.usefixtures("others_are_empty")
def test_they_are_made_for_three_dimensional_results_alone(
    result: fl.Result, tmp_path: Path
) -> None:
    names = {path.name for path in plot_all(result, tmp_path / "spatial")}
    assert set(NAMES) <= names
    names = {path.name for path in plot_all(made_up_result(), tmp_path / "plane")}
    assert not set(NAMES) & names


def test_line_load_of_each_pair_and_of_all(result: fl.Result) -> None:
    """The plot shows the position of the largest line load, over the whole face width."""
    assert result.slices is not None
    load = result.mean_line_load_N_per_mm
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
    assert axes.get_ylabel() == "line load in N/mm"
    # each factor is that of a line in the picture
    assert result.slices is not None
    averaged = lines["all pairs, averaged over the mesh"]
    np.testing.assert_allclose(averaged, load.sum(axis=1).mean(axis=0), rtol=1e-9)
    title = axes.get_legend().get_title().get_text()
    mean = result.site_force_N.sum(axis=1) / 25.0
    lines_of = ((lines["all pairs"], mean[p]), (averaged, mean.mean()))
    factors = [f"{load.max() / mean:.3f}" for load, mean in lines_of]
    assert f"at this position {factors[0]}, averaged over the mesh {factors[1]} (K_Hβ)" in title
    assert title.endswith("means over 0.893 mm")


def test_estimated_errors_are_beside_line_loads_and_their_factor(result: fl.Result) -> None:
    known = replace(result, estimate={"face_load_factor": 0.0231, "peak_line_load": 0.12})
    title = plot_line_load(known).axes[0].get_legend().get_title().get_text()
    assert f"{result.face_load_factor:.3f} ± 2.3 % (K_Hβ)" in title
    scale = plot_line_load_map(known).axes[1].get_ylabel()
    assert scale.endswith(f"up to {result.mean_line_load_N_per_mm.max():.0f} ± 12 %")


def test_line_load_of_a_given_position(result: fl.Result) -> None:
    p = int(result.mean_line_load_N_per_mm.max(axis=(1, 2)).argmin())
    axes = result.plot.line_load(position=p)
    assert f"{np.degrees(result.position_rad[p]):.2f}°" in axes.get_title(loc="left")
    summed = result.mean_line_load_N_per_mm[p].sum(axis=0)
    np.testing.assert_array_equal(steps(axes)["all pairs"], summed)


def test_one_pair_alone_has_no_line_of_all_pairs(result: fl.Result) -> None:
    assert result.slices is not None
    force = result.slices.force_N.copy()
    force[:, result.sites != 0] = 0.0
    alone = replace(result, slices=replace(result.slices, force_N=force))
    assert "all pairs" not in steps(plot_line_load(alone).axes[0])


def test_map_of_the_line_load_has_all_pairs_in_their_order(result: fl.Result) -> None:
    """Pair j at position p is j + p/P pitches along; blank where nothing carries."""
    axes = plot_line_load_map(result).axes[0]
    wanted = result.mean_line_load_N_per_mm.transpose(1, 0, 2).reshape(-1, 10).T
    np.testing.assert_array_equal(shown(axes), wanted)
    assert np.ma.getmaskarray(mesh_of(axes).get_array())[wanted == 0].all()
    assert "pitches" in axes.get_xlabel()
    assert "axial position z" in axes.get_ylabel()


def test_contact_pattern_reaches_the_largest_pressure(result: fl.Result) -> None:
    """It does so on both flanks, in the same slices, and nothing lies beyond the tip."""
    largest = result.slice_peak_pressure_MPa.max(axis=(0, 1))
    for body, tip in ((1, 84.8), (2, 191.1)):
        diameter, pressure = contact_pattern(result, body)
        np.testing.assert_allclose(pressure.max(axis=0), largest, rtol=0.02)
        assert (pressure.max(axis=0) <= largest * (1.0 + 1e-4)).all()
        assert diameter.max() <= tip + 0.01


def test_contact_pattern_is_drawn_over_z_and_diameter(result: fl.Result) -> None:
    """Each flank has its tip, relief and form circles; both share one scale of pressures."""
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


@pytest.mark.usefixtures("others_are_empty")
def test_without_load_there_is_no_contact_pattern(tmp_path: Path) -> None:
    unloaded = solved(load={"torque_Nm": 0.0})
    names = {path.name for path in plot_all(unloaded, tmp_path)}
    assert "transmission_error.png" in names
    assert not set(NAMES) & names


def bands_of(axes: Axes) -> PolyCollection:
    """The coloured bands of the loaded pair."""
    (bands,) = (part for part in axes.collections if part.get_array() is not None)
    assert isinstance(bands, PolyCollection)
    return bands


def words(axes: Axes) -> set[str]:
    return {axes.get_title(loc="center"), *(text.get_text() for text in axes.texts)}


def bodies_of(found: fl.Result, position: int | None = None) -> list[Axes]:
    """Panels of both bodies in the loaded pair."""
    return list(plot_loaded_pair(found, position).axes[0].child_axes)


def test_loaded_pair_shows_the_line_loads_where_they_are(result: fl.Result) -> None:
    """Both bodies are drawn at the position of the largest line load."""
    load = result.slice_line_load_N_per_mm
    p, _, j = np.unravel_index(load.argmax(), load.shape)
    table = result.pairs(int(p))
    carries = table.force_N > 0
    whole, colours = plot_loaded_pair(result).axes
    one, two = whole.child_axes
    largest = f"; ○ largest: {load.max():.0f} at z = {result.slice_z_mm[j]:.1f} mm"
    said = "line load in N per mm face width" + largest.replace("-", "−")
    assert colours.get_xlabel() == said
    for body, axes in ((1, one), (2, two)):
        bands = bands_of(axes)
        assert bands.get_clim() == (0.0, load.max())
        np.testing.assert_allclose(
            np.sort(np.asarray(bands.get_array())), np.sort(load[p][load[p] > 0]), rtol=SOLVER
        )
        x, y, z = table.x_mm[carries], table.y_mm[carries], table.z_mm[carries]
        place = np.column_stack([x, y, z] if body == 1 else [132.0 - x, -y, z])
        middles = [path.vertices[:4].mean(axis=0) for path in bands.get_paths()]
        np.testing.assert_allclose(middles, place @ VIEW[:2].T, atol=1e-9)
        (ring,) = axes.lines
        np.testing.assert_allclose(
            np.ravel(ring.get_data()), middles[np.asarray(bands.get_array()).argmax()], atol=1e-9
        )
        assert {"z = −12.5 mm", "z = 12.5 mm"} <= words(axes)
    assert "Body 1, 25 teeth, right hand" in words(one)
    assert "Body 2, 60 teeth, left hand" in words(two)


def test_loads_of_the_loaded_pair_are_on_its_teeth(result: fl.Result) -> None:
    """Each contact is between two points of the contour of both bodies; bands form lines."""
    table = result.pairs(2)
    assert table.z_mm is not None
    carries = table.force_N > 0
    number = np.searchsorted(result.slice_z_mm, table.z_mm)
    for body, (x, y) in ((1, (table.x_mm, table.y_mm)), (2, (132.0 - table.x_mm, -table.y_mm))):
        teeth = teeth_in_mesh(result, 2, body)
        sections = teeth.sections(teeth.contour(), 21)[1::2]
        for k in np.flatnonzero(carries):
            apart = sections[number[k]] - [x[k], y[k], table.z_mm[k]]
            assert np.linalg.norm(apart, axis=1).min() < 0.4
        bands = bands_of(bodies_of(result, 2)[body - 1])
        corners = np.array([path.vertices[:4] for path in bands.get_paths()])
        site, j = table.site[carries], number[carries]
        (one,), (two,) = (np.nonzero((site == 0) & (j == at)) for at in (4, 5))
        end, start = corners[one, 1:3].mean(axis=1), corners[two][:, [0, 3]].mean(axis=1)
        np.testing.assert_allclose(end, start, atol=0.02)


def test_loaded_pair_of_a_ring_shows_the_line_loads_on_the_teeth_of_both_bodies() -> None:
    """Both meet at negative x: the pinion is drawn turned by 180°, the ring as it is."""
    found = solved("internal_helical", positions={"count": 1})
    assert found.drawing.is_around
    assert "loaded_pair" in plot.pictures_of(found)
    table = found.pairs(0)
    assert table.z_mm is not None
    carries = table.force_N > 0
    apart = found.drawing.center_distance_mm
    panels = bodies_of(found)
    for body, (x, y) in ((1, (-table.x_mm, -table.y_mm)), (2, (table.x_mm - apart, table.y_mm))):
        place = np.column_stack([x, y, table.z_mm])[carries]
        teeth = teeth_in_mesh(found, 0, body)
        for at in place:
            contour = turned(teeth.contour(), teeth.shape.twist_rad_per_mm * at[2])
            assert np.linalg.norm(contour - at[:2], axis=1).min() < 0.4
        # the rim is on the other side of the contour: within the pinion, around the ring
        radii = np.hypot(*teeth.contour().T)
        assert (teeth.rim_mm < radii.min()) if body == 1 else (teeth.rim_mm > radii.max())
        assert 3 <= len(teeth.contours) <= 8
        bands = bands_of(panels[body - 1])
        middles = [path.vertices[:4].mean(axis=0) for path in bands.get_paths()]
        np.testing.assert_allclose(middles, place @ VIEW[:2].T, atol=1e-9)


def test_loaded_pair_has_few_facets(result: fl.Result) -> None:
    for body, axes in enumerate(bodies_of(result), start=1):
        p = int(result.slice_line_load_N_per_mm.max(axis=(1, 2)).argmax())
        most = (1 + len(teeth_in_mesh(result, p, body).contours)) * CONTOUR_FACETS * AXIAL_FACETS
        facets = sum(len(part.get_paths()) for part in axes.collections)
        assert 100 < facets < most + np.asarray(bands_of(axes).get_array()).size + 3


def test_a_left_hand_mirrors_a_right_hand(result: fl.Result) -> None:
    """Teeth and loads are those of the other hand at -z."""
    left = solved(body_1={"hand": "left"}, body_2={"hand": "right"})
    for body in (1, 2):
        right_teeth, left_teeth = (teeth_in_mesh(found, 1, body) for found in (result, left))
        mirrored = left_teeth.sections(left_teeth.contour(), 5)[::-1] * [1.0, 1.0, -1.0]
        np.testing.assert_allclose(
            mirrored, right_teeth.sections(right_teeth.contour(), 5), atol=1e-9
        )
        assert np.ptp(mirrored[:, 0, 1]) > 1.0  # twisted
    for axes, hand in zip(bodies_of(left), ("left", "right"), strict=True):
        assert any(f"teeth, {hand} hand" in word for word in words(axes))
    np.testing.assert_allclose(
        left.slice_line_load_N_per_mm[..., ::-1], result.slice_line_load_N_per_mm, atol=0.1
    )


def test_loaded_pair_of_crowned_spur_gears_beside_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bands lie where both bodies are; without load there are none."""
    wide = {"axial_offset_mm": 3.0, "face_width_mm": 12.0}
    spur = solved("external_gear", body_1={"lead_crowning_um": 10.0}, body_2=wide)
    one, two = bodies_of(spur)
    assert {"z = −7 mm", "z = 7 mm", "Body 1, 16 teeth, spur"} <= words(one)
    assert {"z = −3 mm", "z = 9 mm", "Body 2, 24 teeth, spur"} <= words(two)
    load = spur.slice_line_load_N_per_mm
    p = int(load.max(axis=(1, 2)).argmax())
    assert bands_of(one).get_array().size == (load[p] > 0).sum()
    assert spur.slice_z_mm.min() > -3.0
    assert spur.slice_z_mm.max() < 7.0
    # the crest of the crown is at 0, the middle of the common width at 2 mm
    assert spur.slice_z_mm[load[p].sum(axis=0).argmax()] < 0.0
    unloaded = solved("external_gear", body_1={"lead_crowning_um": 10.0}, load={"torque_Nm": 0.0})
    for name in set(plot.PICTURES) - {"loaded_pair"}:
        monkeypatch.setitem(plot.PICTURES, name, lambda _: new_figure((1.0, 1.0)))
    assert (tmp_path / "loaded_pair.png") in plot_all(unloaded, tmp_path)
    assert len(bands_of(bodies_of(unloaded)[0]).get_paths()) == 0


@pytest.fixture(scope="module")
def stressed() -> fl.Result:
    return solved(effects={"root_stress": True}, positions={"count": 2})


def test_root_stress_over_the_width_is_that_of_the_most_stressed_teeth(stressed: fl.Result) -> None:
    result = stressed
    assert plot.pictures_of(result)[-2:] == ("root_stress", "root_stress_over_width")
    (axes,) = plot_root_stress_over_width(result).axes
    lines = [line for line in axes.lines if len(np.asarray(line.get_xdata())) == 10]
    wanted = []
    for stress in result.root_stress:
        assert stress is not None
        for values in (stress.slice_tension_MPa, stress.slice_compression_MPa):
            p, s, _ = np.unravel_index(np.abs(values).argmax(), values.shape)
            wanted.append(values[p, s])
    for line, values in zip(lines, wanted, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), result.slice_z_mm)
        np.testing.assert_array_equal(line.get_ydata(), values)
        said = f"{values[np.abs(values).argmax()]:.0f} MPa".replace("-", "−")
        assert said in str(line.get_label())


def boxes_of(figure: Figure) -> dict[str, Bbox]:
    """Places of the texts of a figure, in pixels, with the number of their panel."""
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    axes = [part for whole in figure.axes for part in (whole, *whole.child_axes)]
    return {
        f"{text.get_text()} in {k}": text.get_window_extent(renderer)
        for k, part in enumerate(axes)
        for text in (*part.texts, part.title)
        if text.get_text()
    }


@pytest.mark.parametrize("name", ["loaded_pair", "contact_pattern"])
def test_texts_of_wide_helical_teeth_neither_overlap_nor_leave_the_picture(name: str) -> None:
    """Regression: for teeth 24 modules wide, names of ends lay outside or in the other panel."""
    tips = {f"body_{z}": {"tip_radius_mm": 0.3, "tip_relief_um": 0.0} for z in (1, 2)}
    wide = solved(positions={"count": 1}, pair={"face_width_mm": 75.0}, **tips)
    figure = plot.PICTURES[name](wide)
    boxes = boxes_of(figure)
    assert sum("z = −37.5 mm" in text for text in boxes) == (2 if name == "loaded_pair" else 0)
    whole = figure.bbox
    for text, box in boxes.items():
        assert whole.x0 <= box.x0, text
        assert box.x1 <= whole.x1, text
    for (one, first), (two, second) in combinations(boxes.items(), 2):
        assert not first.overlaps(second), f"{one} and {two}"


def test_the_loaded_pair_of_a_report_shows_both_bodies(
    result: fl.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Regression: it showed body 1 only."""
    monkeypatch.setattr(plot, "pictures_of", lambda _: ("loaded_pair",))
    plots = plots_of([result])["Loaded bodies"]
    assert [plot.name for plot in plots] == ["loaded_pair_1", "loaded_pair_2"]
    for one, said in zip(plots, ("25 teeth, right", "60 teeth, left"), strict=True):
        assert said in one.panel.svg
        assert "line load in N per mm" in one.panel.svg


def test_larger_values_are_darker_in_all_maps() -> None:
    names = (FORCE_MAP, LOAD_MAP, PATTERN_MAP, loaded_pair_3d.LOAD_MAP, TINTS)
    for colours in map(colormaps.get_cmap, names):
        lightness = colours(np.linspace(0.0, 1.0, 33))[:, :3] @ [0.299, 0.587, 0.114]
        assert np.all(np.diff(lightness) < 0.0), colours.name


def test_slices_that_enter_are_named_at_curves_with_steps(result: fl.Result) -> None:
    """Steps of pressure and tangent stiffness are explained in the picture."""
    assert result.slices is not None
    said = f"steps come from slices of {result.slices.width_mm.max():.2g} mm that enter and leave"
    for name in ("peak_pressure", "stiffness"):
        helical, spur = (
            " ".join(words(plot.PICTURES[name](one).axes[0])) for one in (result, made_up_result())
        )
        assert said in helical
        assert "steps" not in spur


def test_labels_of_axes_are_no_longer_than_their_axes(stressed: fl.Result) -> None:
    """Regression: labels of root stress and stiffness were longer in the size of a report."""
    several = [made_up_result(torque_Nm=torque) for torque in (150.0, 302.0)]
    for results in ([stressed], several):
        for name in set(plot.pictures_of(results)) - set(OF_BODIES):
            figure = empty_figure(SIZE)
            plot.DRAWINGS[name](figure.add_subplot(), results)
            fit(figure)
            for axes in figure.axes:
                for one in (axes, *axes.child_axes):
                    label = one.yaxis.label.get_window_extent(figure.canvas.get_renderer())
                    assert label.height <= one.bbox.height, f"{name}: {one.get_ylabel()}"


def test_patterns_of_all_meshes_of_a_stage() -> None:
    """A column per planet, with one scale; the report has a panel for each mesh."""
    found = stage(stage={"pin_tilt_stiffness_Nm_per_mrad": 50})
    assert "stage_patterns" in plot.pictures_of(found)
    panels = plot.plot_stage_patterns(found).axes[:6]
    scales = set()
    for k, axes in enumerate(panels):
        kind, j = ("sun", "ring")[k // 3], k % 3 + 1
        body = 2 if kind == "sun" else 1
        (shown,) = (part for part in axes.collections if isinstance(part, QuadMesh))
        _, pattern = contact_pattern(found.mesh(j, kind), body)
        np.testing.assert_array_equal(np.ma.filled(shown.get_array(), 0.0), pattern)
        assert f"planet {j}, {kind}" in axes.get_title(loc="left")
        scales.add(shown.get_clim())
    assert len(scales) == 1
    (section,) = (plots for title, plots in plots_of([found]).items() if "width" in title)
    assert len(section) == 6
