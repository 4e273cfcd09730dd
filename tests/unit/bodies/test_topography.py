"""Files of a measured topography: their contents, and faults refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.flank_surface import Topography
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.gear_scenes import changed, example
from tests.support.paths import SCENES

#: Grid of the pinion of the tests, whose active flank ends at 67.66 and 82.46 mm, 14 mm wide.
GRID = """\
# ground flank
diameter_mm, 0, 7, 14

67.6, 1, 2, 3
75.0, 4, 5, 6
82.5, 7, 8, -9
"""
WANTED = (
    "body_1.topography_file: expected a .csv file: first row distances from the end of smaller z "
    "in mm, then rows of a diameter in mm and the metal removed in um, found "
)


def built(folder: Path, text: str | bytes | None, name: str = "flank.csv"):
    if isinstance(text, str):
        text = text.encode()
    if text is not None:
        (folder / name).write_bytes(text)
    tables = changed(body_1__topography_file=name)
    return build_bodies(fl.Scene.from_dict(tables, file=folder / "scene.toml")).body_1


def test_a_grid_is_read(tmp_path: Path) -> None:
    body = built(tmp_path, "\ufeff" + GRID)
    surface = body.axial.surface
    assert surface is not None
    grid = surface.topography
    assert grid is not None
    np.testing.assert_allclose(grid.z_mm, [0.0, 7.0, 14.0])
    np.testing.assert_allclose(1000.0 * grid.removed_mm, [[1, 2, 3], [4, 5, 6], [7, 8, -9]])
    diameters = 2.0 * np.hypot(*body.curve.point(grid.s_mm[1:2]).T)
    np.testing.assert_allclose(diameters, 75.0, rtol=0.0, atol=1e-6)
    # rows beyond the active flank keep their distance from it
    low, high = body.mode_range_mm
    assert grid.s_mm[0] < low < high < grid.s_mm[2]
    assert surface.most_added_mm == pytest.approx(0.009)


def test_between_columns_the_grid_is_linear() -> None:
    grid = Topography(
        np.array([0.0, 1.0]), np.array([0.0, 4.0]), np.array([[0.0, 4.0], [8.0, 4.0]])
    )
    found = grid.at(np.array([-1e-4, 1.0, 4.0, 4.0001]))
    np.testing.assert_allclose(found, [[0.0, 8.0], [1.0, 7.0], [4.0, 4.0], [4.0, 4.0]])


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (None, f"scene.toml: {WANTED}no file flank.csv"),
        (b"\xff\xfe\x00", f"scene.toml: {WANTED}other bytes than UTF-8"),
        ("", f"scene.toml: {WANTED}0 rows in flank.csv"),
        ("mm,0,14\n67,1,1\n", f"scene.toml: {WANTED}2 rows in flank.csv"),
        (
            GRID.replace("4, 5, 6", "4, 5"),
            (
                "flank.csv: line 5: expected a diameter and 3 values, separated by commas, found "
                "'75.0, 4, 5'"
            ),
        ),
        (
            GRID.replace("4, 5, 6", "4, nan, 6"),
            (
                "flank.csv: line 5: expected a diameter and 3 values, separated by commas, found "
                "'75.0, 4, nan, 6'"
            ),
        ),
        (
            GRID.replace("4, 5, 6", "4, 5_0, 6"),  # read as 50
            (
                "flank.csv: line 5: expected a diameter and 3 values, separated by commas, found "
                "'75.0, 4, 5_0, 6'"
            ),
        ),
        (
            GRID + "82.6, 7, 8, 9\n" * 9999,  # a million took more than two minutes
            "body_1.topography_file: expected at most 10000 lines, found 10005 in flank.csv",
        ),
        (
            GRID.replace(",", ";"),
            (
                "flank.csv: line 2: expected a name, then numbers (z), separated by commas, found "
                "'diameter_mm; 0; 7; 14'"
            ),
        ),
        (
            GRID.replace("diameter_mm, 0", "diameter_mm, 9"),
            (
                "body_1.topography_file: expected ascending distances z in the first row, "
                "found 7 behind 9 in flank.csv"
            ),
        ),
        (
            GRID.replace("75.0", "67.6"),
            (
                "body_1.topography_file: expected ascending diameters, found 67.6 behind "
                "67.6 in flank.csv"
            ),
        ),
        (
            GRID.replace("82.5", "80"),
            (
                "body_1.topography_file: expected diameters from {low} or less to {high} "
                "or more, those of the active flank, found 67.6 to 80 in flank.csv"
            ),
        ),
        (
            GRID.replace("67.6", "70"),
            (
                "body_1.topography_file: expected diameters from {low} or less to {high} "
                "or more, those of the active flank, found 70 to 82.5 in flank.csv"
            ),
        ),
        (
            GRID.replace("7, 14", "7, 13"),
            (
                "body_1.topography_file: expected distances z from 0 or less to 14 or "
                "more, the face width of the body, found 0 to 13 in flank.csv"
            ),
        ),
    ],
)
def test_a_faulty_topography_gets_one_line(
    tmp_path: Path, text: str | bytes | None, line: str
) -> None:
    plain = build_bodies(fl.Scene.from_dict(changed())).body_1
    low, high = (
        f"{2.0 * np.hypot(*point):.3f}" for point in plain.curve.point(plain.mode_range_mm)
    )
    with pytest.raises(SceneError) as caught:
        built(tmp_path, text)
    assert str(caught.value).endswith(line.format(low=low, high=high))
    assert "\n" not in str(caught.value)


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"found flank\.xlsx$"):
        built(tmp_path, GRID, "flank.xlsx")


def test_the_ends_of_a_grid_may_be_rounded(tmp_path: Path) -> None:
    plain = build_bodies(fl.Scene.from_dict(changed())).body_1
    low, high = (2.0 * np.hypot(*point) for point in plain.curve.point(plain.mode_range_mm))
    text = GRID.replace("67.6", f"{low + 5e-4:.6f}").replace("82.5", f"{high - 5e-4:.6f}")
    assert not built(tmp_path, text).axial.plane


def test_a_scene_names_its_topographies(tmp_path: Path) -> None:
    scene = fl.Scene.from_dict(
        changed(body_2__topography_file="a.csv"), file=tmp_path / "scene.toml"
    )
    assert scene.files == {"body_2.topography_file": tmp_path / "a.csv"}


def test_the_example_fits_the_example() -> None:
    """The file of the guide is for the pinion of the helical pair."""
    tables = example("helical_gear")
    tables["body_1"]["topography_file"] = "../topographies/pinion.csv"
    scene = fl.Scene.from_dict(tables, file=SCENES / "helical_gear.toml")
    body = build_bodies(scene).body_1
    assert body.axial.surface is not None
