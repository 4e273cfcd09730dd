"""The benchmark set: its files, the values of this program, answers of another one."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from flankload.cli import main
from flankload.errors import SceneError
from flankload.studies.benchmark import (
    Answers,
    answers_of,
    compare,
    read_answers,
    read_cases,
)
from tests.support.paths import ROOT

FOLDER = ROOT / "benchmarks"
CASES = {case.name: case for case in read_cases(FOLDER)}
TABLE = (ROOT / "docs" / "reference" / "benchmarks.md").read_text(encoding="utf-8")
#: Cases whose answers take less than 0.1 s together; others are compared in tests/physics.
QUICK = [name for name in CASES if "form" in CASES[name].inputs] + ["chain_08B"]
#: Rotation and half-width of this program, in uncertainties of the reference: measured.
LARGEST_RATIO = {"fzg_pitch_point": 1.3}


@pytest.mark.parametrize("name", [*QUICK, "hertz_cylinders", "fzg_pitch_point"])
def test_values_are_those_of_the_reference(name: str) -> None:
    values, seconds = answers_of(CASES[name], FOLDER)
    found = compare([CASES[name]], Answers("this program", {name: values}, {name: seconds}))
    assert [row.identifier for row in found.rows[name]] == list(CASES[name].quantities)
    largest = LARGEST_RATIO.get(name, 1.0)
    assert all(row.ratio is not None and row.ratio < largest for row in found.rows[name])


def test_the_documents_name_every_case_with_its_quantities() -> None:
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    for name, case in CASES.items():
        assert f"| [{name}]({name}/case.json) | {case.title} |" in readme
        number = len(case.quantities)
        assert re.search(rf"^{name} +{number}/{number} ", TABLE, re.MULTILINE), name


def test_a_wrong_value_and_a_missing_one_are_seen() -> None:
    case = CASES["springs"]
    values = {name: quantity.value for name, quantity in case.quantities.items()}
    values["pair_force[0, 1]"] += 3 * case.quantities["pair_force[0, 1]"].uncertainty
    del values["rotation[0]"]
    found = compare([case], Answers("another", {case.name: values}))
    ratios = {row.identifier: row.ratio for row in found.rows[case.name]}
    assert ratios["pair_force[0, 1]"] == pytest.approx(3.0, rel=1e-3)
    assert ratios["rotation[0]"] is None
    assert ratios["pair_force[0, 0]"] == 0.0
    row = found.to_text().splitlines()[-1].split()
    assert row[:5] == ["springs", "5/6", "4", "pair_force[0,", "1]"]
    assert "another" in found.case_text("springs")


def test_answers_are_written_and_read_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = tmp_path / "answers.json"
    own = ["benchmark", "--folder", str(FOLDER), "springs", "belt_row"]
    assert main([*own, "-o", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["values"].keys() == {"springs", "belt_row"}
    assert main([*own, "-o", str(answers)]) == 0
    printed = capsys.readouterr().out
    assert read_answers(answers).values.keys() == {"springs", "belt_row"}
    assert main([*own, "--answers", str(answers)]) == 0
    assert capsys.readouterr().out == printed
    assert main([*own, "--answers", str(answers), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["cases"]["springs"]["rotation[0]"]["ratio"] < 1.0


WRONG = {
    "no JSON": ("{", "expected a case, found"),
    "unknown entry": ('{"nam": 1}', "expected a case, found Object contains unknown field `nam`"),
    "no text": ("\udcff", "expected a case, found "),
    "too many levels": ("[" * 10**5, "expected a case, found "),
    "other name": (None, "name: expected other, as its folder, found springs"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_case_that_does_not_follow_the_format_is_one_line(wrong: str, tmp_path: Path) -> None:
    text, message = WRONG[wrong]
    path = tmp_path / "other" / "case.json"
    path.parent.mkdir()
    text = text or (FOLDER / "springs" / "case.json").read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    with pytest.raises(SceneError) as error:
        read_cases(tmp_path)
    assert message in str(error.value)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no_case"], f"{FOLDER}: case: expected belt_T10, "),
        (["--answers", "ANSWERS"], "answers: expected answers, found"),
        (["--answers", "no.json"], "no.json: file: expected a JSON file with answers to read, "),
        (["--answers", "TEXT"], "text.json: values.springs.rotation[0]: expected a number, found"),
        (
            ["--answers", "OTHER", "belt_row"],
            "values.springs: expected names of the set, such as rotation[0], found rotatin[0]",
        ),
        (["-o", "-", "--json"], "-o: expected a file, since --json uses stdout, found -"),
        (["-o", "no/folder/a.json"], "-o: expected a file in a folder that exists"),
        (["--answers", "TEXT", "-o", "TEXT"], "-o: expected a file other than the answers, found"),
        (["--folder", "EMPTY"], "expected a folder for each case, with case.json, found none"),
    ],
)
def test_wrong_arguments_are_one_line(
    arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "answers.json").write_text('{"program": 3}')
    for name, answer in (("text", '{"rotation[0]": "x"}'), ("other", '{"rotatin[0]": 1}')):
        text = f'{{"program": "a", "values": {{"springs": {answer}}}}}'
        (tmp_path / f"{name}.json").write_text(text)
    places = {name.upper(): str(tmp_path / f"{name}.json") for name in ("text", "other")}
    places |= {"ANSWERS": str(tmp_path / "answers.json"), "EMPTY": str(tmp_path)}
    given = [places.get(argument, argument) for argument in arguments]
    assert main(["benchmark", "--folder", str(FOLDER), *given]) == 2
    assert message in capsys.readouterr().err
