"""Pictures: that they are made, all or none, and that they show what the result says."""

import os
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import flankload as fl
from flankload import plot
from flankload.bodies.profile.involute import Involute
from flankload.bodies.profile_deviation import ProfileDeviation, deviation_at
from flankload.plot import (
    plot_all,
    plot_load_sharing,
    plot_loaded_pair,
    plot_peak_pressure,
    plot_profile_deviation,
    plot_stiffness,
    plot_transmission_error,
)
from flankload.plot.style import new_figure, png_of
from flankload.result import Result
from flankload.scene import Load
from tests.support.made_up_result import made_up_result
from tests.support.paths import SCENES
from tests.support.tolerances import ROUND_OFF

NAMES = [
    "load_map.png",
    "load_sharing.png",
    "loaded_pair.png",
    "peak_pressure.png",
    "stiffness.png",
    "transmission_error.png",
    "transmission_error_spectrum.png",
]


@pytest.fixture(scope="module")
def result() -> Result:
    return made_up_result()


def curve(axes: Axes, label: str) -> tuple[np.ndarray, np.ndarray]:
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def words(axes: Axes) -> str:
    titles = [axes.get_title(loc=loc) for loc in ("left", "center", "right")]
    return " | ".join([*(text.get_text() for text in axes.texts), *titles])


def test_plot_all_writes_its_pictures_into_a_new_folder(result: Result, tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "out"
    paths = plot_all(result, folder)
    assert sorted(path.name for path in paths) == NAMES
    assert sorted(os.listdir(folder)) == NAMES
    for path in paths:
        assert path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_plot_all_writes_none_when_one_fails(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: Result) -> None:
        raise RuntimeError("no picture")

    monkeypatch.setitem(plot.PICTURES, "loaded_pair", refuse)
    with pytest.raises(RuntimeError, match="no picture"):
        plot_all(result, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_pictures_need_no_pyplot(result: Result) -> None:
    import sys

    plot_transmission_error(result)
    assert "matplotlib.pyplot" not in sys.modules


def test_transmission_error_is_closed_over_the_pitch(result: Result) -> None:
    axes = plot_transmission_error(result).axes[0]
    line = axes.lines[0]
    x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    assert x[-1] == pytest.approx(22.5)
    assert y[-1] == y[0]
    np.testing.assert_array_equal(y[:-1], result.transmission_error_um)
    assert axes.get_ylabel() == "transmission error in µm"
    assert "one pitch = 22.5°" in axes.get_xlabel()


def test_transmission_error_notes_mean_and_peak_to_peak(result: Result) -> None:
    axes = plot_transmission_error(result).axes[0]
    summary = result.summary
    text = words(axes)
    assert f"mean {summary['transmission_error_mean_um']:.2f} µm" in text
    assert f"peak to peak {summary['transmission_error_peak_to_peak_um']:.2f} µm" in text
    assert "made-up pair, 302 N m" in text


def test_transmission_error_marks_the_corner_positions(result: Result) -> None:
    axes = plot_transmission_error(result).axes[0]
    _, y = curve(axes, "a pair carries on a sharp corner")
    corner = result.corner_contact.any(axis=1)
    np.testing.assert_array_equal(np.isfinite(y[:-1]), corner)


def test_no_corner_no_mark() -> None:
    smooth = made_up_result(corner_contact=np.zeros((32, 3), dtype=bool))
    labels = [line.get_label() for line in plot_transmission_error(smooth).axes[0].lines]
    assert "a pair carries on a sharp corner" not in labels


def test_load_sharing_hands_over_to_the_next_pair_at_the_end_of_the_pitch(result: Result) -> None:
    axes = plot_load_sharing(result).axes[0]
    _, follower = curve(axes, "pair −1")
    _, leader = curve(axes, "pair 0")
    # pair -1 ends where pair 0 began
    assert follower[-1] == pytest.approx(leader[0])
    assert leader[0] == pytest.approx(100.0)
    assert axes.get_ylabel() == "load share in %"


def test_load_sharing_has_forces_on_the_second_axis(result: Result) -> None:
    figure = plot_load_sharing(result)
    figure.canvas.draw()
    axes = figure.axes[0]
    (second,) = axes.child_axes
    total = result.site_force_N.sum(axis=1).mean() / 1000
    assert second.get_ylabel() == f"force in kN (all pairs: {total:.2f} kN)"
    assert second.get_ylim()[1] == pytest.approx(axes.get_ylim()[1] / 100 * total)


def test_peak_pressure_is_dashed_on_corners_and_full_elsewhere(result: Result) -> None:
    axes = plot_peak_pressure(result).axes[0]
    s = int(np.flatnonzero(result.sites == -1)[0])
    _, full = curve(axes, "pair −1")
    corner = result.corner_contact[:, s]
    assert corner.any()
    assert np.isnan(full[:-1][corner]).all()
    dashed = [line for line in axes.lines if line.get_linestyle() == "--"]
    shown = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in dashed])
    for value in result.peak_pressure_MPa[corner, s]:
        assert value in shown
    assert axes.get_ylim()[1] == pytest.approx(1.25 * result.summary["peak_pressure_MPa"])
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "dashed: on a sharp corner, not meaningful" in labels


def test_pairs_have_the_same_colour_in_every_picture(result: Result) -> None:
    def colours(axes: Axes) -> dict[str, str]:
        return {
            line.get_label(): line.get_color()
            for line in axes.lines
            if line.get_label().startswith("pair")
        }

    one = colours(plot_load_sharing(result).axes[0])
    assert one == colours(plot_peak_pressure(result).axes[0])
    assert len(set(one.values())) == len(one) == 2


def test_loaded_pair_names_forces_and_pressures(result: Result) -> None:
    figure = plot_loaded_pair(result, 16)
    overview, *panels = figure.axes
    loaded = np.flatnonzero(result.site_force_N[16] > 0)
    assert len(panels) == len(loaded) == 2
    for s in loaded:
        name = f"pair {result.sites[s]}".replace("-", "−")
        force = f"{result.site_force_N[16, s] / 1000:.2f} kN"
        assert f"{name}\n{force}" in words(overview)
        pressure = f"{result.peak_pressure_MPa[16, s]:.0f} MPa"
        assert any(f"{name}: {force}, {pressure}" in words(panel) for panel in panels)


def test_loaded_pair_shows_the_contacts_inside_the_picture(result: Result) -> None:
    axes = plot_loaded_pair(result, 16).axes[0]
    table = result.pairs(16)
    low, high = axes.get_xlim()
    assert (low < table.x_mm).all()
    assert (table.x_mm < high).all()
    low, high = axes.get_ylim()
    assert (low < table.y_mm).all()
    assert (table.y_mm < high).all()
    assert axes.get_aspect() == 1.0


def test_loaded_pair_chooses_a_position_with_both_pairs_off_the_corners(result: Result) -> None:
    figure = plot_loaded_pair(result)
    assert len(figure.axes) == 3
    assert "sharp corner" not in " ".join(words(axes) for axes in figure.axes)


def test_loaded_pair_says_when_a_pressure_means_nothing(result: Result) -> None:
    p = int(np.flatnonzero(result.corner_contact.any(axis=1))[0])
    assert any("on a sharp corner" in words(axes) for axes in plot_loaded_pair(result, p).axes[1:])


@pytest.mark.filterwarnings("error")
def test_lumped_contact_is_drawn_as_the_pressure_of_hertz() -> None:
    """Regression: a contact of one row was not drawn."""
    tree = tomllib.loads((SCENES / "external_gear.toml").read_text())
    tree |= {"effects": {"contact": "lumped"}, "positions": {"count": 4}}
    found = fl.solve(fl.Scene.from_dict(tree | {"accuracy": {"estimate": False}}))
    assert isinstance(found, Result)
    p = 2
    overview, *panels = plot_loaded_pair(found, p).axes
    forces = [14.0 * np.trapezoid(*np.asarray(panel.lines[0].get_data())[::-1]) for panel in panels]
    wanted = found.site_force_N[p][found.site_force_N[p] > 0]
    np.testing.assert_allclose(np.sort(forces), np.sort(wanted), rtol=0.01)
    # on the flank the profile is as wide
    table = found.pairs(p)
    assert table.half_width_mm is not None
    widths = [
        np.hypot(*(shape.get_xy()[40] - shape.get_xy()[0])) for shape in overview.patches[-2:]
    ]
    loaded = table.half_width_mm[table.force_N > 0]
    np.testing.assert_allclose(np.sort(widths), np.sort(2 * loaded), rtol=1e-9)


def test_angles_in_any_order_make_an_ascending_open_curve() -> None:
    result = made_up_result(count=3, closed=False, position_rad=np.array([0.2, 0.0, 0.1]))
    line = plot_transmission_error(result).axes[0].lines[0]
    x = np.asarray(line.get_xdata())
    np.testing.assert_allclose(x, np.degrees([0.0, 0.1, 0.2]), rtol=1e-12)
    assert np.asarray(line.get_ydata())[0] == result.transmission_error_um[1]


def test_long_name_does_not_run_into_the_title() -> None:
    axes = plot_transmission_error(made_up_result(name="gearbox " * 20)).axes[0]
    right = axes.get_title(loc="right")
    assert "…, 302 N m" in right
    assert len(right) < 60


def test_rounding_of_an_unloaded_pair_is_not_magnified() -> None:
    result = made_up_result(torque_Nm=0.0, rotation_rad=np.linspace(0.0, 1e-16, 32))
    low, high = plot_transmission_error(result).axes[0].get_ylim()
    assert high - low >= 1e-3


def test_one_position_draws_no_line_over_the_pitch() -> None:
    line = plot_load_sharing(made_up_result(count=1)).axes[0].lines[0]
    assert len(line.get_xdata()) == 1
    assert line.get_marker() == "o"


def test_far_positions_are_not_joined_by_a_line() -> None:
    angles = np.array([0.0, 0.1, 6.4])
    result = made_up_result(count=3, closed=False, position_rad=angles)
    line = plot_transmission_error(result).axes[0].lines[0]
    x = np.asarray(line.get_xdata())
    np.testing.assert_allclose(x, np.degrees([0.0, 0.1, np.nan, 6.4]), rtol=1e-12)


@pytest.mark.filterwarnings("error")
def test_one_angle_given_twice_draws_without_a_warning() -> None:
    result = made_up_result(count=2, closed=False, position_rad=np.array([0.1, 0.1]))
    assert len(plot_transmission_error(result).axes[0].lines[0].get_xdata()) == 2


def test_pairs_of_far_positions_have_colours_of_their_own() -> None:
    far = made_up_result(sites=np.array([-17, -1, 0]))
    lines = [line for line in plot_load_sharing(far).axes[0].lines if "pair" in line.get_label()]
    assert len({line.get_color() for line in lines}) == len(lines) >= 2


@pytest.mark.parametrize(("count", "pictures"), [(1, 5), (2, 6)])
def test_few_positions_can_be_drawn(count: int, pictures: int, tmp_path: Path) -> None:
    """A map of positions needs two of them, a spectrum a period."""
    assert len(plot_all(made_up_result(count=count, closed=False), tmp_path)) == pictures


def test_unloaded_pair_can_be_drawn(tmp_path: Path) -> None:
    assert len(plot_all(made_up_result(torque_Nm=0.0), tmp_path)) == 6


def test_stiffness_is_drawn_along_the_line_of_action_and_about_the_axis(result: Result) -> None:
    figure = plot_stiffness(result)
    axes = figure.axes[0]
    mean = result.stiffness_tangent_N_per_um.mean()
    angle, tangent = curve(axes, f"tangent, mean {mean:.1f} N/µm")
    np.testing.assert_array_equal(tangent[:-1], result.stiffness_tangent_N_per_um)
    assert tangent[-1] == tangent[0]
    assert angle[-1] == pytest.approx(np.degrees(result.period_rad))
    (torsional,) = axes.child_axes
    figure.canvas.draw()
    assert torsional.get_ylim()[1] == pytest.approx(
        axes.get_ylim()[1] * result.reference_radius_mm**2 / 1e3
    )


def test_ring_is_drawn_around_its_pinion() -> None:
    """Body 2 is its rim without the space of its teeth; window and names are on their sides."""
    scene = fl.read_scene(SCENES / "internal_gear.toml")
    result = fl.solve(replace(scene, load=Load(torque_Nm=0.0)))
    assert result.drawing.is_around
    assert not made_up_result().drawing.is_around
    axes = plot_loaded_pair(result).axes[0]
    pinion, ring = (patch.get_path() for patch in axes.patches)
    center = result.drawing.center_distance_mm
    # as filled by the canvas: a loop the other way round takes away
    loops = ring.to_polygons()
    areas = [0.5 * np.sum(p[:-1, 0] * p[1:, 1] - p[1:, 0] * p[:-1, 1]) for p in loops]
    assert areas[0] > 0 > areas[1]
    assert -sum(areas) == pytest.approx(np.pi * (110.0**2 - 90.5**2), rel=0.03)
    rim = np.hypot(loops[1][:, 0] - center, loops[1][:, 1])
    np.testing.assert_allclose(rim, 110.0, rtol=1e-9)
    low, high = axes.get_xlim()
    pinion_tip = pinion.vertices[:, 0].min()
    assert low < pinion_tip < high < 0
    labels = {text.get_text(): text.get_position()[0] for text in axes.texts}
    assert labels["body 2 ↺"] < labels["body 1 ↺"]


# --- profile diagram ------------------------------------------------------------------------------
def profile(name: str = "relief") -> ProfileDeviation:
    return ProfileDeviation(
        roll_length_mm=np.array([5.0, 15.0, 20.0]),
        deviation_um=np.array([0.0, 0.0, -12.0]),
        base_radius_mm=34.0,
        marks=(("form", 4.0), (name, 15.0), ("tip", 20.0)),
    )


def with_profiles(*profiles: ProfileDeviation | None) -> Result:
    result = made_up_result()
    drawing = replace(result.drawing, profiles=profiles, active_roll_mm=((6.0, 20.0), None))
    return replace(result, drawing=drawing)


def test_profile_diagram_is_one_of_the_pictures_where_an_involute_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in set(plot.PICTURES) - {"profile_deviation"}:
        monkeypatch.setitem(plot.PICTURES, name, lambda _: new_figure((1.0, 1.0)))
    paths = plot_all(with_profiles(profile(), None), tmp_path / "one")
    assert sorted(path.name for path in paths) == sorted([*NAMES, "profile_deviation.png"])
    paths = plot_all(with_profiles(None, None), tmp_path / "none")
    assert sorted(path.name for path in paths) == NAMES


def test_profile_diagram_shows_the_deviation_and_names_its_marks() -> None:
    figure = plot_profile_deviation(with_profiles(profile(), profile("tip chamfer")))
    one, two = figure.axes
    line = max(one.lines, key=lambda line: len(np.asarray(line.get_xdata())))
    np.testing.assert_array_equal(line.get_xdata(), [5.0, 15.0, 20.0])
    np.testing.assert_array_equal(line.get_ydata(), [0.0, 0.0, -12.0])
    assert f"form ⌀ {2 * np.hypot(34, 4):.2f}" in words(one)
    assert f"relief ⌀ {2 * np.hypot(34, 15):.2f}" in words(one)
    assert f"tip chamfer ⌀ {2 * np.hypot(34, 15):.2f}" in words(two)
    assert "active profile" in words(one)
    assert "active profile" not in words(two)
    assert one.get_ylim() == two.get_ylim()
    assert one.get_ylim()[0] < -12


def test_profile_diagram_of_one_body_has_one_panel() -> None:
    (axes,) = plot_profile_deviation(with_profiles(None, profile())).axes
    assert "body 2" in words(axes)


def test_pure_involute_is_not_magnified_to_its_rounding() -> None:
    noise = replace(profile(), deviation_um=np.array([0.0, 1e-7, -1e-7]))
    low, high = plot_profile_deviation(with_profiles(noise, None)).axes[0].get_ylim()
    assert high - low > 5.0


def test_deviation_counts_along_the_normal_of_the_involute() -> None:
    """A string unwound from the base circle, cut short by 0.03 mm, in a body that is turned."""
    involute = Involute(34.0, 36.0, 31.0, 34.5, 41.0, base_half_angle_rad=0.11, turn_rad=3.0)
    roll = np.linspace(0.1, 0.6, 7)
    angle = 3.0 + 0.11 - roll
    length = 34.0 * roll - 0.03
    places = np.stack(
        [
            34.0 * np.cos(angle) - length * np.sin(angle),
            34.0 * np.sin(angle) + length * np.cos(angle),
        ],
        axis=1,
    )
    roll_length, deviation = deviation_at(involute, places)
    np.testing.assert_allclose(roll_length, 34.0 * roll, rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(deviation, -0.03, rtol=0, atol=34.0 * ROUND_OFF)


def test_uneven_positions_are_marked_on_the_curve_through_them() -> None:
    """The curve has a point on each piece, the marks are the positions and the closing one."""
    base = made_up_result(count=40)
    keep = np.delete(np.arange(40), [3, 4, 11, 30])
    result = made_up_result(
        count=40,
        position_rad=base.position_rad[keep],
        rotation_rad=base.rotation_rad[keep],
        site_force_N=base.site_force_N[keep],
        peak_pressure_MPa=base.peak_pressure_MPa[keep],
        stiffness_tangent_Nm_per_rad=base.stiffness_tangent_Nm_per_rad[keep],
        status=base.status[keep],
        corner_contact=base.corner_contact[keep],
        pair_tables=tuple(base.pairs(int(k)) for k in keep),
    )
    curve, marks, *_ = plot_transmission_error(result).axes[0].get_lines()
    assert marks.get_linestyle() == "None"
    assert marks.get_marker() == "o"
    angles = np.degrees(np.append(result.position_rad, result.period_rad))
    np.testing.assert_allclose(marks.get_xdata(), angles, rtol=ROUND_OFF, atol=0)
    drawn = np.asarray(curve.get_xdata())
    assert drawn.size > 5 * angles.size
    assert drawn[-1] == pytest.approx(angles[-1], rel=ROUND_OFF)
    even = plot_transmission_error(base).axes[0].get_lines()[0]
    assert even.get_marker() == "None"


def test_many_pairs_share_one_name() -> None:
    base = made_up_result()
    forces = np.zeros((32, 20))
    forces[np.arange(32), np.arange(32) % 20] = 1000.0
    result = made_up_result(
        sites=-np.arange(20)[::-1],
        site_force_N=forces,
        peak_pressure_MPa=forces,
        corner_contact=forces < 0,
        period_rad=19 * base.period_rad,
        pitch_rad=base.period_rad,
    )
    legend = plot_load_sharing(result).axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [
        "pairs 0 to −19, from left to right"
    ]
    assert any("pair that  carries" in line for line in result.table().splitlines())


@pytest.mark.parametrize(
    ("name", "picture"),
    [
        ("日本語の歯車", plot_transmission_error),
        ("क्ष $\\frac{1$", plot_loaded_pair),
        ("two\nlines and\ta tab\x00\x07", plot_transmission_error),
    ],
)
def test_name_in_any_script_is_drawn(
    name: str, picture: Callable[[Result], Figure], result: Result
) -> None:
    """Formulas are text, missing glyphs are boxes, and there are no warnings."""
    assert png_of(picture(replace(result, name=name))).startswith(b"\x89PNG")


def test_name_is_drawn_as_it_is_written(result: Result) -> None:
    figure = plot_transmission_error(replace(result, name="a$b$c\n d"))
    assert "a$b$c d, 302 N m" in words(figure.axes[0])
    assert not figure.axes[0].title.get_parse_math()


def test_a_notebook_shows_the_figure_of_a_plot() -> None:
    """Regression: a figure without pyplot was shown as a line of text."""
    figure: Any = made_up_result().plot.load_sharing().figure
    assert figure._repr_png_() == png_of(figure)
