"""Results: derived numbers, checked by hand, and the files."""

import csv
import io
import json
import os
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flankload.base.number_text import error_of
from flankload.result import Result, results_to_csv, results_to_json, results_to_text
from flankload.result.corners import off_corners
from flankload.result.notes import warning_lines
from flankload.result.optional_results import ShaftLoads
from flankload.result.slices import SliceLoads
from tests.support.made_up_result import made_up_result
from tests.support.pair_scenes import EXTERNAL, solved
from tests.support.tolerances import ROUND_OFF


def small_result(**changes: Any) -> Result:
    """Two positions, two sites, round numbers: 2 N m on a base radius of 10 mm."""
    arguments: dict[str, Any] = {
        "torque_Nm": 2.0,
        "sites": [0, 1],
        "position_rad": [0.0, 0.1],
        "rotation_rad": [1e-3, 2e-3],
        "reference_radius_mm": 10.0,
        "site_force_N": [[200.0, 0.0], [50.0, 150.0]],
        "peak_pressure_MPa": [[1000.0, 0.0], [500.0, 1700.0]],
        "corner_contact": [[False, False], [False, True]],
        "stiffness_tangent_Nm_per_rad": [4000.0, 3000.0],
        "status": [0, 1],
        "pair_tables": made_up_result(count=2).pair_tables,
        "period_rad": 0.2,
        "closed": True,
    }
    return made_up_result(**{**arguments, **changes})


# --- derived numbers ------------------------------------------------------------------------------
def test_transmission_error_is_rotation_times_reference_radius() -> None:
    # 1e-3 rad * 10 mm = 0.01 mm = 10 um
    np.testing.assert_allclose(
        small_result().transmission_error_um, [10.0, 20.0], rtol=ROUND_OFF, atol=0
    )


def test_load_share_is_force_over_sum() -> None:
    np.testing.assert_allclose(
        small_result().load_share, [[1.0, 0.0], [0.25, 0.75]], rtol=ROUND_OFF, atol=0
    )


def test_load_share_is_zero_without_force() -> None:
    result = small_result(torque_Nm=0.0, site_force_N=np.zeros((2, 2)))
    assert (result.load_share == 0).all()


def test_stiffness_about_the_axis_and_along_the_line_of_action() -> None:
    result = small_result()
    np.testing.assert_allclose(
        result.stiffness_secant_Nm_per_rad, [2000.0, 1000.0], rtol=ROUND_OFF, atol=0
    )
    # 2 N m on 10 mm are 200 N over 10 um and 20 um
    np.testing.assert_allclose(
        result.stiffness_secant_N_per_um, [20.0, 10.0], rtol=ROUND_OFF, atol=0
    )
    np.testing.assert_allclose(
        result.stiffness_tangent_N_per_um, [40.0, 30.0], rtol=ROUND_OFF, atol=0
    )


def test_secant_stiffness_is_not_a_number_without_torque() -> None:
    assert np.isnan(small_result(torque_Nm=0.0).stiffness_secant_Nm_per_rad).all()


def test_summary_by_hand() -> None:
    summary = small_result().summary
    assert summary["transmission_error_mean_um"] == pytest.approx(15.0, rel=ROUND_OFF)
    assert summary["transmission_error_peak_to_peak_um"] == pytest.approx(10.0, rel=ROUND_OFF)
    assert summary["contact_ratio_under_load"] == 1.5
    assert (summary["loaded_pairs_min"], summary["loaded_pairs_max"]) == (1, 2)
    assert summary["peak_pressure_MPa"] == 1000.0
    assert summary["peak_pressure_position_rad"] == 0.0
    assert summary["peak_pressure_pair"] == 0
    assert summary["corner_pressure_MPa"] == 1700.0
    assert summary["corner_pressure_position_rad"] == 0.1
    assert summary["corner_pressure_pair"] == 1
    smooth = small_result(corner_contact=np.zeros((2, 2), dtype=bool)).summary
    assert smooth["peak_pressure_MPa"] == 1700.0
    assert smooth["corner_pressure_MPa"] is smooth["corner_pressure_pair"] is None


def test_pressures_on_corners_alone_are_no_largest_pressure() -> None:
    """Neither their numbers, which follow the cells, nor 0, which a search would prefer."""
    result = small_result(corner_contact=[[True, False], [True, True]])
    assert result.summary["peak_pressure_MPa"] is result.summary["peak_pressure_pair"] is None
    assert result.summary["corner_pressure_MPa"] == 1700.0
    assert np.isnan(off_corners(result)).all()
    lines = results_to_text([result]).splitlines()
    (line,) = [x for x in lines if x.startswith("largest pressure")]
    assert line.split(maxsplit=2)[2] == (
        "none: all contact is on sharp corners, where no finite pressure exists (*)"
    )


def test_harmonics_of_a_known_curve() -> None:
    count = 16
    angle = 2 * np.pi * np.arange(count) / count
    error_um = 30 + 4 * np.cos(angle + 0.3) + 1.5 * np.sin(3 * angle)
    base = made_up_result(count=count)
    result = made_up_result(count=count, rotation_rad=error_um / 1000 / base.reference_radius_mm)
    np.testing.assert_allclose(
        result.summary["transmission_error_harmonics_um"],
        [4.0, 0.0, 1.5, 0.0, 0.0],
        rtol=0,
        atol=30 * ROUND_OFF,
    )


def test_harmonics_beyond_the_positions_are_not_claimed() -> None:
    # 8 positions hold harmonics 1 to 3; the fourth is seen at its zero crossings or not at all
    harmonics = made_up_result(count=8).summary["transmission_error_harmonics_um"]
    assert [amplitude is None for amplitude in harmonics] == [False, False, False, True, True]


def test_open_curves_have_no_harmonics_and_no_contact_ratio() -> None:
    period = made_up_result().period_rad
    window = made_up_result(closed=False, period_rad=48 * period, pitch_rad=period)
    summary = window.summary
    assert window.period_pitches == 48
    assert summary["transmission_error_harmonics_um"] is None
    assert summary["transmission_error_mesh_harmonics_um"] is None
    assert summary["contact_ratio_under_load"] is None


def test_pairs_change_half_way_where_the_error_has_no_kink() -> None:
    """Uneven positions: parts of the period with one pair and with two, by hand."""
    summary = small_result(position_rad=[0.0, 0.05], rotation_rad=[1e-3, 1e-3]).summary
    # one pair from -0.075 to 0.025, two from there to 0.125, of a period of 0.2
    assert summary["contact_ratio_under_load"] == pytest.approx(1.5, rel=ROUND_OFF)
    three = small_result(
        position_rad=[0.0, 0.02, 0.06],
        rotation_rad=[1e-3, 1e-3, 1e-3],
        site_force_N=[[200.0, 0.0], [50.0, 150.0], [50.0, 150.0]],
        peak_pressure_MPa=[[1000.0, 0.0], [500.0, 1700.0], [500.0, 1700.0]],
        corner_contact=np.zeros((3, 2), dtype=bool),
        stiffness_tangent_Nm_per_rad=[4000.0, 3000.0, 3000.0],
        status=[0, 1, 1],
        pair_tables=made_up_result(count=3).pair_tables,
    ).summary
    # one pair from 0.13 - 0.2 to 0.01: 0.08 of 0.2
    assert three["contact_ratio_under_load"] == pytest.approx(1.6, rel=ROUND_OFF)


def test_summary_without_load() -> None:
    summary = small_result(
        torque_Nm=0.0, site_force_N=np.zeros((2, 2)), peak_pressure_MPa=np.zeros((2, 2))
    ).summary
    assert summary["peak_pressure_MPa"] == 0.0
    assert summary["peak_pressure_pair"] is None
    assert summary["loaded_pairs_max"] == 0


def test_pairs_are_those_of_the_position() -> None:
    result = made_up_result()
    for p in (0, 12):
        table = result.pairs(p)
        for s, site in enumerate(result.sites):
            force = table.force_N[table.site == site].sum()
            # 31 cells against the closed formula of the half ellipse
            assert force == pytest.approx(result.site_force_N[p, s], rel=0.02)


# --- frozen ---------------------------------------------------------------------------------------
def test_result_is_frozen() -> None:
    result = small_result()
    with pytest.raises(FrozenInstanceError):
        result.name = "other"  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        result.rotation_rad[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        result.load_share[0, 0] = 1.0


def test_result_does_not_share_memory_with_its_makers() -> None:
    rotation = np.array([1e-3, 2e-3])
    result = small_result(rotation_rad=rotation)
    rotation[0] = 7.0
    assert result.rotation_rad[0] == 1e-3


def test_wrong_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"site_force_N: expected shape \(2, 2\), found \(2, 3\)"):
        small_result(site_force_N=np.zeros((2, 3)))


# --- files ----------------------------------------------------------------------------------------
def refuse_constant(name: str) -> None:
    raise AssertionError(f"{name} is not JSON")


def test_json_is_strict_and_holds_the_named_keys() -> None:
    result = small_result(torque_Nm=0.0)  # secant stiffness is not a number
    tree = json.loads(result.to_json(), parse_constant=refuse_constant)
    assert tree["stiffness_secant_Nm_per_rad"] == [None, None]
    assert tree["transmission_error_um"] == pytest.approx([10.0, 20.0], rel=ROUND_OFF)
    assert tree["load_share"] == result.load_share.tolist()
    assert tree["corner_contact"] == [[False, False], [False, True]]
    assert tree["sites"] == [0, 1]
    assert tree["status"] == [0, 1]
    for key in (
        "name", "torque_Nm", "position_rad", "rotation_rad", "site_force_N", "peak_pressure_MPa",
        "stiffness_tangent_Nm_per_rad", "stiffness_secant_N_per_um", "stiffness_tangent_N_per_um",
        "summary", "estimate", "cost", "warnings", "pairs",
    ):  # fmt: skip
        assert key in tree
    assert len(tree["pairs"]) == 2
    assert tree["pairs"][0]["force_N"] == result.pairs(0).force_N.tolist()


def test_json_of_a_list_of_torques() -> None:
    results = (small_result(torque_Nm=1.0), small_result())
    tree = json.loads(results_to_json(results), parse_constant=refuse_constant)
    assert tree["torques_Nm"] == [1.0, 2.0]
    assert [one["torque_Nm"] for one in tree["results"]] == [1.0, 2.0]


def test_csv_has_a_row_per_position() -> None:
    result = small_result()
    rows = list(csv.DictReader(io.StringIO(result.to_csv())))
    assert len(rows) == 2
    assert float(rows[1]["transmission_error_um"]) == result.transmission_error_um[1]
    assert float(rows[1]["site_force_N_pair_1"]) == 150.0
    assert float(rows[1]["load_share_pair_0"]) == 0.25
    assert rows[1]["corner_contact_pair_1"] == "1"
    assert rows[1]["status"] == "1"
    assert rows[0]["torque_Nm"] == "2.0"


def test_csv_leaves_a_cell_empty_where_there_is_no_number() -> None:
    rows = list(csv.DictReader(io.StringIO(small_result(torque_Nm=0.0).to_csv())))
    assert rows[0]["stiffness_secant_Nm_per_rad"] == ""


def test_csv_of_a_list_of_torques_joins_the_pairs_of_all() -> None:
    results = (small_result(torque_Nm=1.0), small_result(sites=[-1, 0]))
    rows = list(csv.DictReader(io.StringIO(results_to_csv(results))))
    assert [row["torque_Nm"] for row in rows] == ["1.0", "1.0", "2.0", "2.0"]
    assert float(rows[0]["site_force_N_pair_-1"]) == 0.0
    assert float(rows[2]["site_force_N_pair_-1"]) == 200.0
    assert float(rows[2]["site_force_N_pair_1"]) == 0.0


def test_files_hold_what_the_functions_return(tmp_path: Path) -> None:
    result = small_result()
    text = result.to_json(tmp_path / "result.json")
    assert (tmp_path / "result.json").read_text(encoding="utf-8") == text
    text = result.to_csv(tmp_path / "result.csv")
    assert (tmp_path / "result.csv").read_text(encoding="utf-8") == text
    assert sorted(os.listdir(tmp_path)) == ["result.csv", "result.json"]


def test_xarray_is_labelled_and_has_units() -> None:
    pytest.importorskip("xarray")
    result = small_result()
    data = result.to_xarray()
    assert data["site_force_N"].sel(site=1).values.tolist() == [0.0, 150.0]
    assert data["site_force_N"].attrs["units"] == "N"
    assert data["stiffness_secant_N_per_um"].attrs["units"] == "N/um"
    assert data["position"].attrs["units"] == "rad"
    assert data.attrs["torque_Nm"] == 2.0


def test_xarray_holds_stress_with_its_unit() -> None:
    pytest.importorskip("xarray")
    result = solved(EXTERNAL, 302.0, count=1, effects={"root_stress": True})
    data = result.to_xarray()
    assert data["root_tension_2_MPa"].attrs["units"] == "MPa"
    assert data["root_tension_2_MPa"].dims == ("position", "site")


# --- the table ------------------------------------------------------------------------------------
def test_table_has_a_line_per_position_and_marks_corners() -> None:
    text = small_result().table()
    rows = [line for line in text.splitlines() if line.lstrip().startswith(("0.000", "5.730"))]
    assert len(rows) == 2
    assert rows[0].split() == ["0.000", "10.000", "40.00", "20.00", "100.00", "1000", "-", "-"]
    assert rows[1].split() == [
        "5.730",
        "20.000",
        "30.00",
        "10.00",
        "25.00",
        "500",
        "75.00",
        "1700*",
    ]
    assert "sharp corner" in text
    assert "1000 MPa +- 0.8 % on pair 0 at 0.000 deg" in text
    assert "at sharp corners (*) no finite pressure exists" in text


def test_table_quotes_summary_estimate_cost_and_warnings() -> None:
    text = small_result().table()
    assert "mean 15.000 um, peak to peak 10.000 um" in text
    assert "contact ratio under load 1.500" in text
    assert "transmission error 0.1 %" in text
    assert "2 FE factorisations, 10 unit loads" in text
    assert "backlash" in text
    assert text.endswith("their shares are not: positions 1")


# --- warnings -------------------------------------------------------------------------------------
def test_warnings_precede_the_table() -> None:
    lines = small_result().table().splitlines()
    (warning,) = (k for k, line in enumerate(lines) if line.startswith("warning  "))
    assert warning == 2
    assert lines[warning + 2].startswith("position")


def test_warnings_of_several_torques_precede_all_tables_once() -> None:
    """Warnings that differ only in numbers are merged into that of the largest torque."""
    of_torque = {
        100.0: ("always", "at 3 of 8 positions body_1 works", "only here"),
        900.0: ("always", "at 7 of 8 positions body_1 works", "pairs 2 carry"),
        302.0: ("always", "at 5 of 8 positions body_1 works", "at 1.5e-3 body_2"),
    }
    results = [
        replace(small_result(), torque_Nm=torque, warnings=said)
        for torque, said in of_torque.items()
    ]
    assert warning_lines(results) == [
        "always",
        "at 7 of 8 positions body_1 works [under 900 N m; similar under 100, 302 N m]",
        "only here [under 100 N m]",
        "pairs 2 carry [under 900 N m]",
        "at 1.5e-3 body_2 [under 302 N m]",
    ]
    text = results_to_text(results)
    first, *tables = text.split("\n\nmade-up pair: ")
    assert len(tables) == len(results)
    assert first.count("warning  ") == text.count("warning  ") == 5


def test_one_result_says_its_warnings_as_they_are() -> None:
    assert warning_lines([small_result()]) == list(small_result().warnings)


def test_one_position_has_neither_mean_nor_peak_to_peak() -> None:
    estimate = {
        "transmission_error": 2e-3,
        "transmission_error_mean": 1e-3,
        "transmission_error_peak_to_peak": 0.0,
    }
    text = made_up_result(count=1, closed=False, estimate=estimate).table()
    assert " um at one position\n" in text
    assert "transmission error 0.2 %" in text
    assert "peak to peak" not in text
    assert "mean 0.1" not in text


def test_an_error_above_its_value_is_in_its_unit() -> None:
    result = small_result(estimate={"transmission_error_peak_to_peak": 1.5})
    swing = result.summary["transmission_error_peak_to_peak_um"]
    assert f"peak to peak {swing:.3f} um +- {error_of(swing, 1.5, 'um')}" in result.table()
    assert [error_of(0.02, part, "µm") for part in (1.0, 1.5)] == ["100 %", "0.03 µm"]


def test_rounding_is_no_error_and_has_no_source() -> None:
    """Regression: the estimate of a cam was 2e-14 % of its mean, with a source for zero."""
    positions = {"transmission_error_mean": 2e-16, "transmission_error_peak_to_peak": 0.018}
    estimate = {
        "load_share": 0.0,
        "transmission_error_peak_to_peak": 0.017,
        "dominant_source": {"load_share": "strips", "transmission_error_peak_to_peak": "positions"},
        "by_source": {"positions": positions},
    }
    text = small_result(estimate=estimate).table()
    assert "load share 0 %, transmission error peak to peak 1.7 % (positions)\n" in text
    assert "by positions alone  mean 0 %, peak to peak 1.8 %\n" in text


def test_table_without_load_and_estimate() -> None:
    zero = np.zeros((2, 2))
    result = small_result(torque_Nm=0.0, site_force_N=zero, peak_pressure_MPa=zero, estimate=None)
    text = result.table()
    assert "nan" not in text
    assert "estimated error" not in text
    assert "largest pressure" not in text


def test_arrays_of_parts_are_read_only() -> None:
    none = np.zeros((2, 0, 3))
    shafts = ShaftLoads(np.zeros(2), none, none.copy())
    loads = np.ones((2, 1, 3))
    slices = SliceLoads(
        np.arange(3.0), np.ones(3), loads, loads.copy(), 0.0, 1.0, 1.0, np.ones(2) / 2
    )
    arrays = [x for part in (shafts, slices) for x in vars(part).values() if np.ndim(x)]
    assert len(arrays) == 8
    assert not any(array.flags.writeable for array in arrays)
