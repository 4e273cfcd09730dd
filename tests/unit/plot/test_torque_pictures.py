"""Pictures of several torques, on given Axes, and as files: their data are those of the results."""

from __future__ import annotations

import sys
from dataclasses import replace
from math import degrees, pi
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from flankload import plot
from flankload.bodies.profile_deviation import ProfileDeviation
from flankload.errors import InputError
from flankload.plot.curves import spectrum
from flankload.plot.figures import CURVE_LABEL, label_curves, spread_labels
from flankload.plot.involutes import path_on_flank
from flankload.plot.style import BODIES, COLOURS, torque_colours
from flankload.result import Result
from flankload.result.geometry import PairGeometry
from flankload.result.plotting import Plots
from tests.support.made_up_result import BASE_RADII, DISTANCE, TEETH, made_up_result
from tests.support.tolerances import ROUND_OFF

TORQUES = (100.0, 200.0, 302.0)
PATH = (-0.775, 0.775)


def with_involutes(result: Result) -> Result:
    """The result with the involutes of its bodies and their path of contact."""
    flat = np.array([1.0, 30.0]), np.zeros(2)
    profiles = tuple(ProfileDeviation(*flat, base, ()) for base in BASE_RADII)
    speed = np.ones(result.position_rad.size)
    geometry = PairGeometry(DISTANCE, speed, -speed * TEETH[0] / TEETH[1], path_pitches=PATH)
    drawing = replace(result.drawing, profiles=profiles)
    return replace(result, drawing=drawing, geometry=geometry)


@pytest.fixture(scope="module")
def results() -> tuple[Result, ...]:
    return tuple(with_involutes(made_up_result(torque_Nm=torque)) for torque in TORQUES)


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


def lines(axes: Axes) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {
        str(line.get_label()): (np.asarray(line.get_xdata()), np.asarray(line.get_ydata()))
        for line in axes.lines
    }


def labels(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts if text.get_gid() == CURVE_LABEL]


# --- several torques ------------------------------------------------------------------------------
def test_transmission_error_has_a_curve_and_a_label_per_torque(
    results: tuple[Result, ...], axes: Axes
) -> None:
    plot.draw_transmission_error(axes, results)
    for line, result in zip(axes.lines, results, strict=False):
        np.testing.assert_array_equal(line.get_ydata()[:-1], result.transmission_error_um)
    spans = [result.summary["transmission_error_peak_to_peak_um"] for result in results]
    assert labels(axes) == [
        f"{torque:g} N m\np-p {span:.2f} µm" for torque, span in zip(TORQUES, spans, strict=True)
    ]
    assert len({to_hex(line.get_color()) for line in axes.lines[:3]}) == 3
    entries = [text.get_text() for text in axes.get_legend().get_texts()]
    assert entries == ["a pair carries on a sharp corner"]


def test_load_share_of_several_torques_is_that_of_a_pair_on_its_way(
    results: tuple[Result, ...], axes: Axes
) -> None:
    """Pair 0 at half a pitch is at 0.5; the pair before it, half a pitch before the pitch point."""
    plot.draw_load_sharing(axes, results)
    place, share = lines(axes)["302 N m"]
    s, p = 1, 16
    for pair, wanted in ((0, 0.5), (-1, -0.5)):
        (k,) = np.flatnonzero(np.abs(place - wanted) < 1e-12)
        assert share[k] == pytest.approx(100 * results[2].load_share[p, s + pair], rel=ROUND_OFF)
    assert "mesh pitches" in axes.get_xlabel()
    assert labels(axes) == ["100 N m", "200 N m", "302 N m"]


def test_peak_pressure_names_the_largest_one_of_each_torque(
    results: tuple[Result, ...], axes: Axes
) -> None:
    plot.draw_peak_pressure(axes, results)
    for label, result in zip(labels(axes), results, strict=True):
        peak = result.summary["peak_pressure_MPa"]
        assert label == f"{result.torque_Nm:g} N m\n{peak:.0f} MPa"
        assert np.nanmax(lines(axes)[f"{result.torque_Nm:g} N m"][1]) == pytest.approx(peak)


def test_stiffness_of_several_torques_is_the_tangent_one(
    results: tuple[Result, ...], axes: Axes
) -> None:
    plot.draw_stiffness(axes, results)
    assert len(axes.lines) == 3
    for line, result in zip(axes.lines, results, strict=True):
        np.testing.assert_array_equal(line.get_ydata()[:-1], result.stiffness_tangent_N_per_um)
    assert axes.get_ylabel().startswith("tangent stiffness")


def test_torques_are_drawn_in_ascending_order_and_named_in_the_title(
    results: tuple[Result, ...],
) -> None:
    axes = plot.plot_transmission_error(results[::-1]).axes[0]
    assert axes.get_title(loc="right") == "made-up pair, 100, 200, 302 N m"
    assert [label.split("\n")[0] for label in labels(axes)] == ["100 N m", "200 N m", "302 N m"]


def test_labels_at_one_height_are_moved_apart_in_their_order(axes: Axes) -> None:
    axes.set_ylim(0.0, 10.0)
    label_curves(axes, [5.0, 5.01, 9.0], ["one", "two", "three"], ["k", "k", "k"])
    spread_labels(axes)
    texts = [text for text in axes.texts if text.get_gid() == CURVE_LABEL]
    scale = axes.figure.dpi / 72
    at = [
        axes.transData.transform((0, text.xy[1]))[1] / scale + text.get_position()[1]
        for text in texts
    ]
    assert at[1] - at[0] == pytest.approx(1.2 * texts[0].get_fontsize())
    assert texts[2].get_position()[1] == pytest.approx(0.0, abs=1e-9)


# --- new pictures ---------------------------------------------------------------------------------
def test_spectrum_of_a_wave_has_its_amplitude_at_its_order(axes: Axes) -> None:
    angle = 2 * pi * np.arange(32) / 32
    wave = 3.0 * np.cos(2 * angle) + 0.5 * np.cos(5 * angle)
    one = made_up_result(rotation_rad=(20.0 + wave) / (1000.0 * BASE_RADII[0]))
    order, amplitude = spectrum(one)
    wanted = np.zeros(10)
    wanted[[1, 4]] = 3.0, 0.5
    np.testing.assert_array_equal(order, np.arange(1, 11))
    np.testing.assert_allclose(amplitude, wanted, rtol=0, atol=1e-12)
    plot.draw_transmission_error_spectrum(axes, (one, one))
    heights = [[bar.get_height() for bar in bars] for bars in axes.containers]
    np.testing.assert_allclose(heights, [wanted, wanted], rtol=0, atol=1e-12)
    places = [bars[0].get_x() + 0.5 * bars[0].get_width() for bars in axes.containers]
    assert places == pytest.approx([0.8, 1.2])


def test_spectrum_of_a_period_of_several_pitches_has_orders_between_the_mesh_orders() -> None:
    base = made_up_result()
    order, _ = spectrum(replace(base, pitch_rad=base.pitch_rad / 4))
    np.testing.assert_allclose(order, np.arange(1, 16) / 4, rtol=ROUND_OFF)


def test_map_shows_the_force_of_each_pair_at_each_position(
    results: tuple[Result, ...], axes: Axes
) -> None:
    plot.draw_load_map(axes, results)
    (shown,) = (part for part in axes.collections if isinstance(part, QuadMesh))
    force = np.ma.filled(shown.get_array(), 0.0)
    np.testing.assert_array_equal(force[:, :-1], results[2].site_force_N.T[:2] / 1e3)
    # the next pair follows a pitch later
    assert force[0, -1] == force[1, 0]
    edges = shown.get_coordinates()[0, :, 0]
    np.testing.assert_allclose(edges[[0, -1]], [0.0, 22.5], rtol=ROUND_OFF)
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["−1", "0"]


def test_sweep_has_a_point_per_torque(results: tuple[Result, ...]) -> None:
    figure = plot.plot_torque_sweep(results)
    keys = (
        *("transmission_error_peak_to_peak_um", "transmission_error_mean_um"),
        *("peak_pressure_MPa", "stiffness_tangent_mean_N_per_um"),
    )
    for axes, key in zip(figure.axes, keys, strict=True):
        points = np.asarray(axes.collections[0].get_offsets())
        np.testing.assert_allclose(points[:, 0], TORQUES)
        np.testing.assert_allclose(points[:, 1], [result.summary[key] for result in results])
    with pytest.raises(ValueError, match="quantity: expected one of "):
        plot.draw_torque_sweep(figure.axes[0], results, quantity="heat")


@pytest.mark.parametrize("body", [1, 2])
def test_points_of_the_path_lie_on_the_circles_of_the_geometry(
    body: int, results: tuple[Result, ...]
) -> None:
    """C is on the pitch circle; on body 1 the contact moves outwards, on body 2 inwards."""
    path = path_on_flank(results[0], body)
    assert path is not None
    points = path.points()
    assert "".join(points) == "ABCDE"
    pitch_circle = 2 * DISTANCE * TEETH[body - 1] / sum(TEETH)
    assert path.diameter_mm(points["C"]) == pytest.approx(pitch_circle, rel=ROUND_OFF)
    assert points["E"] - points["B"] == pytest.approx(1.0)
    assert points["D"] - points["A"] == pytest.approx(1.0)
    assert np.sign(path.diameter_mm(points["E"]) - path.diameter_mm(points["A"])) == 3 - 2 * body
    diameter = path.diameter_mm(0.3)
    pressure_angle = np.arccos(2 * BASE_RADII[body - 1] / diameter)
    assert path.roll_angle_deg(diameter) == pytest.approx(degrees(np.tan(pressure_angle)))
    assert path.diameter_of_roll_mm(path.roll_angle_deg(diameter)) == pytest.approx(diameter)


def test_pressure_lies_where_the_contacts_are(results: tuple[Result, ...], axes: Axes) -> None:
    """The diameters of the line of action are those of the pair tables."""
    plot.draw_pressure_over_diameter(axes, results[2:], body=1)
    diameter, pressure = lines(axes)["302 N m"]
    result, p, s = results[2], 8, 1
    table = result.pairs(p)
    own = table.site == result.sites[s]
    radius = table.radius_mm[own][table.pressure_MPa[own].argmax()]
    (k,) = np.flatnonzero(pressure == result.peak_pressure_MPa[p, s])
    assert diameter[k] == pytest.approx(2 * radius, rel=1e-9)
    letters = [text.get_text() for text in axes.texts if text.get_gid() != CURVE_LABEL]
    assert sorted(letters) == list("ABCDE")


def test_path_of_two_pitches_has_no_points_of_single_contact(results: tuple[Result, ...]) -> None:
    path = path_on_flank(results[0], 1)
    assert path is not None
    assert "".join(replace(path, ends=(-1.1, 1.1)).points()) == "ACE"


# --- on given Axes --------------------------------------------------------------------------------
def test_each_picture_draws_on_given_axes_and_returns_them(results: tuple[Result, ...]) -> None:
    for name in plot.pictures_of(results):
        axes = Figure().add_subplot()
        assert getattr(Plots(results), name)(axes) is axes
        assert axes.has_data() or axes.get_children()
        assert axes.get_title(loc="left") == ""
    assert "matplotlib.pyplot" not in sys.modules


def test_accessor_has_a_method_for_every_picture(results: tuple[Result, ...]) -> None:
    for name in plot.PICTURES:
        assert callable(getattr(Plots, name))
        assert name in plot.DRAWINGS
        for found, kind in ((plot.PICTURES[name], "plot"), (plot.DRAWINGS[name], "draw")):
            assert found is getattr(plot, found.__name__)
            assert found.__code__.co_name == f"{kind}_{name}"  # no function made from another one
    assert results[0].plot.names() == plot.pictures_of(results[0])


def test_result_of_a_list_of_torques_draws_all_of_them(
    results: tuple[Result, ...], axes: Axes
) -> None:
    series = Result.of_torques(results)
    assert series.plot.stiffness(axes) is axes
    assert labels(axes) == ["100 N m", "200 N m", "302 N m"]
    assert series.plot.names() == plot.pictures_of(results)
    assert "torque_sweep" not in series.at(200.0).plot.names()


def test_without_axes_a_figure_with_a_title_is_made(results: tuple[Result, ...]) -> None:
    axes = results[0].plot.peak_pressure()
    assert axes.get_title(loc="left") == "Peak pressure"
    axes = Plots(results).pressure_over_diameter(body=2)
    assert len(axes.figure.axes) == 1
    assert "body 2" in axes.get_xlabel()


def test_picture_of_one_torque_shows_the_largest(results: tuple[Result, ...]) -> None:
    texts = plot.plot_loaded_pair(results).texts
    assert "made-up pair, 302 N m" in {text.get_text() for text in texts}


# --- colours --------------------------------------------------------------------------------------
def test_colours_of_pairs_bodies_and_torques_differ() -> None:
    pairs, bodies = set(COLOURS), set(BODIES)
    torques = {to_hex(colour).upper() for n in range(1, 8) for colour in torque_colours(n)}
    assert not pairs & bodies
    assert not torques & {colour.upper() for colour in pairs | bodies}
    assert torque_colours(1) == torque_colours(3)[-1:]


# --- files ----------------------------------------------------------------------------------------
def test_files_are_written_once_in_each_format(
    results: tuple[Result, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plot, "pictures_of", lambda _: ("load_sharing",))
    paths = plot.plot_all(results, tmp_path, formats=("svg", "pdf", "png", "svg"))
    kinds = ("svg", "pdf", "png")
    assert [path.name for path in paths] == [f"load_sharing.{kind}" for kind in kinds]
    starts = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}
    for path in paths:
        assert path.read_bytes().startswith(starts[path.suffix[1:]])
    before = [path.read_bytes() for path in paths]
    plot.plot_all(results, tmp_path, formats=("svg", "pdf", "png"))
    assert [path.read_bytes() for path in paths] == before
    with pytest.raises(ValueError, match="formats: expected png, svg, pdf, found 'gif'"):
        plot.plot_all(results, tmp_path, formats=("gif",))


def test_size_and_resolution_are_those_asked_for(
    results: tuple[Result, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plot, "pictures_of", lambda _: ("stiffness", "torque_sweep"))
    one, four = results[0].plot.all(tmp_path, dpi=100, size_mm=(127.0, 76.2))
    for path, size in ((one, (500, 300)), (four, (500, 375))):
        with Image.open(path) as image:
            assert image.size == size


def test_texts_lie_inside_the_figure(results: tuple[Result, ...]) -> None:
    """Margins follow from the texts for any number of panels."""
    for name in ("stiffness", "pressure_over_diameter", "torque_sweep"):
        figure = plot.PICTURES[name](results)
        box = figure.get_tightbbox(figure.canvas.get_renderer())  # type: ignore[attr-defined]
        width, height = figure.get_size_inches()
        assert box.x0 > 0.0 < box.y0
        assert box.x1 < width
        assert box.y1 < height
        panels = [axes.get_tightbbox().extents for axes in figure.axes]
        for k, (_, low, _, high) in enumerate(panels):
            for x0, y0, x1, y1 in panels[:k]:
                own = panels[k]
                assert x1 <= own[0] or own[2] <= x0 or y1 <= low or high <= y0


@pytest.mark.parametrize(
    ("name", "options", "line"),
    [
        ("belt_on_pulley", {}, "plot: expected one that suits the results (transmission_error, "),
        ("loaded_pair", {"position": 32}, "position: expected an index from 0 to 31, found 32"),
        ("loaded_pair", {"position": True}, "position: expected an index from 0 to 31, found True"),
        ("profile_deviation", {"body": 3}, "body: expected 1 or 2, found 3"),
    ],
)
def test_wrong_arguments_of_a_plot_are_one_line(
    results: tuple[Result, ...], name: str, options: dict[str, int], line: str
) -> None:
    with pytest.raises(InputError) as refused:
        getattr(Plots(results), name)(**options)
    assert str(refused.value).startswith(line)
