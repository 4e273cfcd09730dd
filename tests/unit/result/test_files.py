"""Files for other programs: forms of CSV, workbooks, Modelica tables, FMUs."""

from __future__ import annotations

import csv
import io
import re
import sys
from dataclasses import replace
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import openpyxl
import pytest

from flankload.errors import InputError, SceneError
from flankload.result import CsvForm, Result, StiffnessTable, results_to_csv, stiffness_table
from flankload.result.fmu import _compiler, _identifier
from flankload.result.workbook import _sheet_name, results_to_xlsx
from tests.support.made_up_result import made_up_result

TORQUES = (302.0, 100.0)
#: Relative difference of a number that a program interpolates at a sample.
AT_SAMPLES = 1e-12


def results() -> tuple[Result, ...]:
    return tuple(made_up_result(torque_Nm=torque, count=8) for torque in TORQUES)


def table() -> StiffnessTable:
    return stiffness_table(results())


# --- CSV ------------------------------------------------------------------------------------------
def test_decimal_commas_and_degrees_change_the_form_alone() -> None:
    (result, _) = results()
    plain = list(csv.reader(io.StringIO(result.to_csv())))
    text = result.to_csv(decimal_comma=True, degrees=True)
    rows = list(csv.reader(io.StringIO(text), delimiter=";"))
    names = {"position_rad": "position_deg", "rotation_rad": "rotation_deg"}
    assert rows[0] == [names.get(name, name) for name in plain[0]]
    for one, two in zip(plain[1:], rows[1:], strict=True):
        for name, before, after in zip(plain[0], one, two, strict=True):
            if name in names:
                assert float(after.replace(",", ".")) == np.degrees(float(before))
            else:
                assert after == before.replace(".", ",")


def test_a_separator_is_that_of_all_columns() -> None:
    (result, _) = results()
    assert result.to_csv(separator="\t") == result.to_csv().replace(",", "\t")
    lines = table().to_csv(form=CsvForm(decimal_comma=True)).splitlines()
    plain = table().to_csv().splitlines()
    assert lines[:3] == plain[:3]
    swapped = {",": ";", ".": ","}
    assert lines[4:] == [re.sub("[,.]", lambda m: swapped[m[0]], line) for line in plain[4:]]


@pytest.mark.parametrize(("separator", "comma"), [("|", False), (",", True)])
def test_a_form_that_cannot_be_read_is_refused(separator: str, comma: bool) -> None:
    with pytest.raises(InputError, match="separator: expected"):
        CsvForm(separator, comma)


# --- workbooks ------------------------------------------------------------------------------------
def test_a_workbook_has_the_numbers_of_all_torques(tmp_path: Path) -> None:
    several = results()
    path = tmp_path / "result.xlsx"
    results_to_xlsx(several, path)
    book = openpyxl.load_workbook(path)
    assert book.sheetnames[0] == "summary"
    summary = {row[0]: row[1:] for row in book["summary"].iter_rows(values_only=True)}
    assert summary["made-up pair"] == ("302 N m", "100 N m")
    assert summary["transmission_error_mean_um"] == pytest.approx(
        [one.summary["transmission_error_mean_um"] for one in several], rel=1e-15
    )
    assert summary["violated premises of the model"] == ("none", "none")
    assert summary[several[0].warnings[0]] == ("yes", "yes")
    head, *rows = book["site_force_N"].iter_rows(values_only=True)
    assert head[:4] == (
        "position [rad]",
        "position [deg]",
        "pair -1, 302 N m [N]",
        "pair 0, 302 N m [N]",
    )
    forces = np.hstack([one.site_force_N for one in several])
    np.testing.assert_allclose([row[2:] for row in rows], forces, rtol=1e-15)
    head, *rows = book["rotation_rad"].iter_rows(values_only=True)
    assert head[2:] == ("302 N m [rad]", "100 N m [rad]")
    rotations = np.stack([one.rotation_rad for one in several], axis=1)
    np.testing.assert_allclose([row[2:] for row in rows], rotations, rtol=1e-15)
    columns = {re.sub(r"_pair_-?\d+$", "", name) for name in csv_heads(several)}
    sheets = {name for name in columns if name not in ("torque_Nm", "position_rad")}
    assert set(book.sheetnames[1:]) == sheets


def csv_heads(several: tuple[Result, ...]) -> list[str]:
    return next(csv.reader(io.StringIO(results_to_csv(several))))


def test_a_text_like_a_formula_stays_a_text(tmp_path: Path) -> None:
    made_up_result(name="=1+1\x01", count=8).to_xlsx(tmp_path / "result.xlsx")
    cell = openpyxl.load_workbook(tmp_path / "result.xlsx")["summary"]["A1"]
    assert (cell.value, cell.data_type) == ("=1+1", "s")


def test_names_are_shortened_without_a_wrong_unit() -> None:
    assert _sheet_name("root_tension_1_arc_length_mm") == "root_tension_1_arc_length_mm"
    assert _sheet_name("root_compression_1_arc_length_mm") == "root_compression_1_arc_length"
    assert len(_identifier("long name " * 40)) < 200


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(ImportError, match=r"pip install 'flankload\[xlsx\]'"):
        made_up_result(count=8).to_xlsx(tmp_path / "result.xlsx")


# --- Modelica -------------------------------------------------------------------------------------
def modelica_tables(text: str) -> dict[str, np.ndarray]:
    """Tables of a text file by the rules of Modelica.Blocks.Tables: `#1`, then name and size."""
    first, *lines = text.splitlines()
    assert first == "#1"
    words = " ".join(line.split("#")[0] for line in lines)
    found = {}
    for name, n, m, body in re.findall(
        r"double (\w+)\((\d+),(\d+)\)([^a-z]*(?:e-?\d+[^a-z]*)*)", words
    ):
        found[name] = np.array(body.split(), dtype=float).reshape(int(n), int(m))
    return found


def test_modelica_tables_have_angles_and_ascending_torques() -> None:
    big, small = results()
    tables = modelica_tables(table().to_modelica())
    names = ("rotation_rad", "transmission_error_um", "stiffness_Nm_per_rad")
    assert set(tables) == {*names, *(f"{name}_1d" for name in names)}
    rotation = tables["rotation_rad"]
    assert rotation.shape == (10, 3)
    np.testing.assert_array_equal(rotation[0], [0.0, 100.0, 302.0])
    np.testing.assert_allclose(rotation[1:-1, 0], big.position_rad, rtol=1e-15)
    assert rotation[-1, 0] == big.period_rad
    np.testing.assert_array_equal(rotation[-1, 1:], rotation[1, 1:])
    np.testing.assert_allclose(rotation[1:-1, 1], small.rotation_rad, rtol=1e-14)
    np.testing.assert_allclose(rotation[1:-1, 2], big.rotation_rad, rtol=1e-14)
    np.testing.assert_array_equal(
        tables["stiffness_Nm_per_rad_1d"], tables["stiffness_Nm_per_rad"][1:]
    )


@pytest.mark.parametrize(
    ("several", "line"),
    [
        (
            (made_up_result(closed=False, count=8, position_rad=np.linspace(0.0, 0.1, 8)),),
            "positions: expected angles over a whole period, since the table repeats after it",
        ),
        (
            (made_up_result(count=8), made_up_result(count=8)),
            "load.torque_Nm: expected different torques, found [302.0, 302.0]",
        ),
        (
            (made_up_result(count=8, stiffness_tangent_Nm_per_rad=np.full(8, np.nan)),),
            "load.torque_Nm: expected torques with a tangent stiffness at every position, found",
        ),
    ],
)
def test_a_table_that_is_no_function_is_refused(several: tuple[Result, ...], line: str) -> None:
    with pytest.raises(SceneError) as caught:
        stiffness_table(several).to_modelica()
    assert str(caught.value).startswith(line)


# --- FMU ------------------------------------------------------------------------------------------
def simulated(path: Path, angle: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Outputs of an FMU for inputs that each hold for a step."""
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed: pip install fmpy")
    rows = [*zip(range(angle.size), angle, torque, strict=True)]
    signals = np.array(rows, dtype=[("time", float), ("angle_rad", float), ("torque_Nm", float)])
    names = ["rotation_rad", "transmission_error_um", "stiffness_Nm_per_rad"]
    found = fmpy.simulate_fmu(
        str(path),
        start_time=0,
        stop_time=angle.size,
        output_interval=1,
        input=signals,
        output=names,
    )
    # FMPy records before it sets the inputs of a time
    return np.stack([found[name][1:] for name in names], axis=1)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if _compiler() is None:
        pytest.skip("no C compiler on x86-64 Linux, so the FMU has no library")
    path = tmp_path_factory.mktemp("fmu") / "pair.fmu"
    assert table().to_fmu(path)
    return path


def test_an_fmu_is_valid(fmu: Path) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="FMPy is not installed")
    assert validation.validate_fmu(str(fmu)) == []


@pytest.mark.parametrize("periods", [0, 1, -3])
def test_an_fmu_gives_the_numbers_of_the_table_in_every_period(fmu: Path, periods: int) -> None:
    for result in results():
        angle = result.position_rad + periods * result.period_rad
        found = simulated(fmu, angle, np.full(angle.size, result.torque_Nm))
        wanted = np.stack(
            [
                result.rotation_rad,
                result.transmission_error_um,
                result.stiffness_tangent_Nm_per_rad,
            ],
            axis=1,
        )
        np.testing.assert_allclose(found, wanted, rtol=AT_SAMPLES)


def test_an_fmu_is_bilinear_between_samples_and_goes_on_with_the_tangent(fmu: Path) -> None:
    big, small = results()
    one = table()
    angle = 0.3 * one.angle_rad[:-1] + 0.7 * one.angle_rad[1:]
    torque = 0.25 * 100.0 + 0.75 * 302.0

    def between(values: np.ndarray) -> np.ndarray:
        return 0.3 * values + 0.7 * np.roll(values, -1)

    found = simulated(fmu, angle, np.full(angle.size, torque))
    for column, name in ((0, "rotation_rad"), (2, "stiffness_tangent_Nm_per_rad")):
        wanted = 0.25 * between(getattr(small, name)) + 0.75 * between(getattr(big, name))
        np.testing.assert_allclose(found[:, column], wanted, rtol=AT_SAMPLES)
    for result, beyond in ((small, -50.0), (big, 400.0)):
        found = simulated(fmu, result.position_rad, np.full(8, beyond))
        stiffness = result.stiffness_tangent_Nm_per_rad
        wanted = result.rotation_rad + (beyond - result.torque_Nm) / stiffness
        np.testing.assert_allclose(found[:, 0], wanted, rtol=AT_SAMPLES)
        np.testing.assert_allclose(found[:, 2], stiffness, rtol=AT_SAMPLES)


def test_an_fmu_has_the_same_bytes_each_time(fmu: Path, tmp_path: Path) -> None:
    table().to_fmu(tmp_path / "pair.fmu")
    assert (tmp_path / "pair.fmu").read_bytes() == fmu.read_bytes()
    with ZipFile(fmu) as archive:
        assert "sources/table.c" in archive.namelist()
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_an_fmu_without_library_has_its_sources(tmp_path: Path) -> None:
    assert not table().to_fmu(tmp_path / "pair.fmu", binary=False)
    with ZipFile(tmp_path / "pair.fmu") as archive:
        names = set(archive.namelist())
    sources = {f"sources/{name}" for name in ("flankload_fmu.c", "table.c", "table.h")}
    assert names == {"modelDescription.xml", *sources}


def test_a_compiler_that_fails_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if _compiler() is None:
        pytest.skip("no C compiler on x86-64 Linux")
    monkeypatch.setenv("CC", "false")
    with pytest.raises(InputError, match="fmu: expected a C compiler, found false: no message"):
        table().to_fmu(tmp_path / "pair.fmu")
    assert not (tmp_path / "pair.fmu").exists()


@pytest.mark.parametrize(
    "cell", ["=1+1", "-x", "+cmd|' /C calc'!A0", "@sum", "\t=1", "\n=1", "＝1"]
)
def test_no_text_of_a_csv_file_is_a_formula(cell: str) -> None:
    for form in (CsvForm(), CsvForm(decimal_comma=True)):
        text = form.lines([[cell, "-1.5", "-1,5e3", -2.5, "plain = text"]])
        (row,) = csv.reader(
            io.StringIO(text, newline=""), delimiter=";" if form.decimal_comma else ","
        )
        assert row == [f"'{cell}", "-1.5", "-1,5e3", "-2.5", "plain = text"]
    named = replace(table(), name="a,=1+1;=2+2")
    assert named.to_csv().splitlines()[0] == "# a =1+1 =2+2"
