"""Variables by tolerance class: their covariance, their draws, and the line for each refusal."""

from __future__ import annotations

from math import cos, pi, radians
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.scene.iso_1328 import iso_1328
from flankload.studies.design import Designs, read_study
from flankload.studies.quality import pitch_factor
from flankload.studies.variables import variables_of
from tests.support.design_scene import TEXT, design_scene
from tests.support.tolerances import ROUND_OFF

ERRORS_1, ERRORS_2 = "body_1.pitch_errors_um", "body_2.pitch_errors_um"
DISTANCE = "pair.center_distance_mm"
CLASS_7 = {"distribution": "iso_1328", "class": 7}
VARIABLES = {
    DISTANCE: {"distribution": "normal", "mean": 91.6, "standard_deviation": 0.005},
    ERRORS_1: CLASS_7,
    ERRORS_2: CLASS_7,
}


def designs_of(variables: dict[str, Any], kind: str, n: int, seed: int = 0) -> list[dict[str, Any]]:
    designs = Designs(variables_of(variables), kind, n, seed).in_scene(design_scene())
    return list(designs)


def test_pitch_and_index_deviations_have_a_third_of_their_tolerance() -> None:
    limits = iso_1328(7, teeth=24, module_mm=4.5, face_width_mm=14)
    factor = pitch_factor(limits, 24)
    index = np.sqrt((factor**2).sum(axis=1))
    single = np.sqrt(((factor - np.roll(factor, 1, axis=0)) ** 2).sum(axis=1))
    np.testing.assert_allclose(index, 42.0 / 6.0, rtol=ROUND_OFF)
    np.testing.assert_allclose(single, 14.0 / 3.0, rtol=ROUND_OFF)
    np.testing.assert_allclose(factor.sum(axis=0), 0.0, atol=1e-13)


def test_with_few_teeth_the_eccentricity_alone_reaches_the_single_pitch() -> None:
    limits = iso_1328(7, teeth=5, module_mm=4.5, face_width_mm=14)
    factor = pitch_factor(limits, 5)
    single = np.sqrt(((factor - np.roll(factor, 1, axis=0)) ** 2).sum(axis=1))
    np.testing.assert_allclose(single, limits.single_pitch_um / 3.0, rtol=ROUND_OFF)
    assert not factor[:, 2:].any()


@pytest.mark.parametrize("kind", ["random", "sobol"])
def test_draws_are_lists_of_all_teeth_along_the_base_tangent(kind: str) -> None:
    rows = designs_of(VARIABLES, kind, 1024)
    for name, teeth, f_p in ((ERRORS_1, 16, 14.0), (ERRORS_2, 24, 14.0)):
        found = np.array([row[name] for row in rows]) / cos(radians(20))
        assert found.shape == (1024, teeth)
        np.testing.assert_allclose(np.diff(found).std(), f_p / 3.0, rtol=0.02)
    turned = np.exp(-2j * pi * np.arange(16) / 16)
    phase = np.angle([np.dot(row[ERRORS_1], turned) for row in rows])
    counts, _ = np.histogram(phase, bins=4, range=(-pi, pi))
    assert abs(counts - 256).max() < 60  # four standard deviations


@pytest.mark.parametrize("kind", ["random", "sobol"])
def test_more_draws_of_lists_begin_with_the_same_bits(kind: str) -> None:
    few = designs_of(VARIABLES, kind, 5, seed=3)
    assert few == designs_of(VARIABLES, kind, 16, seed=3)[:5]
    assert few != designs_of(VARIABLES, kind, 5, seed=4)


def test_deviations_are_added_to_the_values_of_the_scene() -> None:
    errors = [float(i) for i in range(16)]
    plain = designs_of({ERRORS_1: CLASS_7}, "random", 2)
    variables = variables_of({ERRORS_1: CLASS_7})
    added = list(Designs(variables, "random", 2, 0, {ERRORS_1: errors}).in_scene(design_scene()))
    for one, other in zip(plain, added, strict=True):
        difference = np.subtract(other[ERRORS_1], one[ERRORS_1])
        np.testing.assert_allclose(difference, errors, atol=1e-12)


def test_helix_slopes_have_a_third_of_their_tolerance() -> None:
    solid = {"body_1.helix_angle_deg": 10, "body_1.hand": "left", "body_2.hand": "right"}
    scene = design_scene(**solid, **{"body_2.helix_angle_deg": 10, "body_1.helix_slope_um": 5})
    limits = iso_1328(6, teeth=16, module_mm=4.5, face_width_mm=14, helix_angle_deg=10)
    for name, mean in (("body_1.helix_slope_um", [5]), ("body_1.tooth_helix_slope_um", [0] * 16)):
        (variable,) = variables_of({name: {"distribution": "iso_1328", "class": 6}})
        found = variable.in_scene(scene).distribution
        assert found.mean.tolist() == mean
        np.testing.assert_array_equal(found.factor, np.eye(len(mean)) * limits.helix_slope_um / 3)


def test_a_study_file_may_name_a_class(tmp_path: Any) -> None:
    (tmp_path / "scene.toml").write_text(TEXT, encoding="utf-8")
    text = 'scene = "scene.toml"\ndesign = "random"\nn = 2\n[variables]\n'
    text += f'"{ERRORS_1}" = {{ distribution = "iso_1328", class = 7 }}\n'
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    rows = list(read_study(tmp_path / "study.toml").designs)
    assert rows == designs_of({ERRORS_1: CLASS_7}, "random", 2)


@pytest.mark.parametrize(
    ("path", "table", "line"),
    [
        (ERRORS_1, {"class": 12}, f"variables.{ERRORS_1}.class: expected an integer from 1 to 11"),
        (
            ERRORS_1,
            {},
            f"variables.{ERRORS_1}.class: expected an integer from 1 to 11 (ISO 1328-1), ",
        ),
        (
            ERRORS_1,
            {"grade": 7},
            f"variables.{ERRORS_1}.grade: expected a known key (class), found",
        ),
        (DISTANCE, {"class": 7}, f"variables.{DISTANCE}: expected one of the paths body_N.pitch_"),
        (
            f"{ERRORS_1},{ERRORS_2}",
            {"class": 7},
            f"variables.{ERRORS_1},{ERRORS_2}: expected one of the paths body_N.pitch_errors_um, ",
        ),
    ],
)
def test_wrong_classes_get_one_line(path: str, table: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.SceneError) as refused:
        fl.study(design_scene(), {path: {"distribution": "iso_1328", **table}}, "random", n=1)
    assert line in str(refused.value)


def test_a_bounded_distribution_beyond_its_key_is_refused_before_a_run() -> None:
    path = "body_1.profile_crowning_um"
    table = {"distribution": "uniform", "lower": -0.01, "upper": 100}
    with pytest.raises(fl.SceneError) as refused:
        fl.study(design_scene(), {path: table}, "random", n=1, seed=1)
    assert f"variables.{path}: expected a number from 0" in str(refused.value)


def test_a_normal_distribution_beyond_its_key_gives_failed_rows() -> None:
    path = "body_1.profile_crowning_um"
    table = {"distribution": "normal", "mean": 1, "standard_deviation": 3}
    found = fl.study(
        design_scene(), {path: table}, "random", n=4, seed=1, quantities=["peak_pressure_MPa"]
    )
    for row in found.rows:
        assert (row.outcome.status == "failed") == (row.values[path] < 0)
    assert found.failed
    assert f"{path}: expected a number from 0" in str(found.failed[0].outcome.error)
