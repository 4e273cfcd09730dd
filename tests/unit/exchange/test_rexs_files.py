"""REXS files that are damaged, hostile or incomplete: one line each, nothing read outside."""

import zipfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from flankload.errors import SceneError
from flankload.exchange.rexs import Choices, read_model, reading, scene_of_stage, stage_rows
from tests.support.rexs_files import EXAMPLE, HEAD, TEXT, in_json, model_text, written, zipped

STAGE = '<component id="9" type="cylindrical_stage"/>'
GEAR = '<component id="1" type="cylindrical_gear"/>'
PART = '<component id="1" type="a"/>'


def refused(path: Path) -> str:
    with pytest.raises(SceneError) as caught:
        read_model(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: ")
    assert "\n" not in line
    assert ": expected " in line
    return line.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "file: expected well-formed XML, found no element found"),
        ("<model", "file: expected well-formed XML, found unclosed token"),
        ("<gear/>", "root: expected element 'model', found 'gear'"),
        ("<model/>", "model: expected a version, found nothing"),
        ('<model version="2.0"/>', "model: version: expected version 1 of REXS"),
        ('<model version="one"/>', "model: version: expected version 1 of REXS"),
        (model_text([], [GEAR, GEAR]), "component 1: expected an id that is unique, found two"),
        (model_text([], ['<component id="x" type="shaft"/>']), "component: expected an integer as"),
        (model_text([], ['<component type="shaft"/>']), "component: expected an integer as id"),
        (model_text([], ['<component id="1"/>']), "component 1: expected a type, found nothing"),
        (
            model_text([], [PART.replace("/>", '><attribute unit="mm">1</attribute></component>')]),
            "a 1: attribute: expected an id, found nothing",
        ),
        (
            model_text([], [PART.replace("/>", ">" + 2 * '<attribute id="b"/>' + "</component>")]),
            "a 1: b: expected one attribute with this id, found two",
        ),
        (
            model_text([("stage", ("stage", 9))], []),
            "relation 1: expected a component of the model as stage, found 9",
        ),
        (
            model_text([], [GEAR]).replace(
                "</model>",
                '<load_spectrum id="1"><load_case id="3"><component id="8" type="a"/></load_case>'
                "</load_spectrum></model>",
            ),
            "load_case 3: expected components of the model, found 8",
        ),
    ],
)  # fmt: skip
def test_each_fault_of_an_xml_file_has_its_line(tmp_path: Path, text: str, line: str) -> None:
    assert refused(written(tmp_path, text)).startswith(line)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "file: expected valid JSON, found line 1, column 1: expecting value"),
        ("[]", "root: expected an object with the object 'model', found a list"),
        ('{"model": 1}', "root: expected an object with the object 'model', found an object"),
        (
            '{"model": {"version": "1.5", "components": {}}}',
            "components: expected a list of objects",
        ),
        (
            '{"model": {"version": "1.5", "relations": [1]}}',
            "relations: expected a list of objects",
        ),
        ('{"model": {"version": 1.5}}', "model: expected a version, found 1.5"),
        ('{"model": {"version": "1.5", "load_spectrum": 3}}', "load_cases: expected a list"),
        ("[" * 100_000, "file: expected JSON of a few levels, found too many levels"),
    ],
)
def test_each_fault_of_a_json_file_has_its_line(tmp_path: Path, text: str, line: str) -> None:
    assert refused(written(tmp_path, text, "box.rexsj")).startswith(line)


def test_duplicated_relations_and_cases_are_refused(tmp_path: Path) -> None:
    twice = TEXT.replace('<relation id="2"', '<relation id="1"', 1)
    assert refused(written(tmp_path, twice)).startswith("relation 1: expected an id that is unique")
    cases = '<load_spectrum id="1"><load_case id="1"/><load_case id="1"/></load_spectrum></model>'
    both = TEXT.replace("</model>", cases)
    assert refused(written(tmp_path, both)).startswith("load_case 1: expected an id that is unique")


@pytest.mark.parametrize("name", ["box.rexs", "box.rexsj", "box.rexsz", "box.txt"])
def test_a_file_that_cannot_be_read_is_named(tmp_path: Path, name: str) -> None:
    assert refused(tmp_path / name).startswith("file: expected a REXS file")
    (tmp_path / name).mkdir()
    assert refused(tmp_path / name).startswith("file: expected a REXS file")


@pytest.mark.parametrize(
    ("content", "name", "line"),
    [
        (TEXT.encode("utf-16"), "box.rexsj", "file: expected text in UTF-8, found byte 0xff"),
        (TEXT.replace("UTF-8", "UTF-99").encode(), "box.rexs", "file: expected "),
        (b'<?xml version="1.0"?><model version="\xe9"/>', "box.rexs", "file: expected "),
    ],
)  # fmt: skip
def test_wrong_encodings_are_named(tmp_path: Path, content: bytes, name: str, line: str) -> None:
    assert refused(written(tmp_path, content, name)).startswith(line)


def test_text_in_utf_16_with_its_mark_is_xml(tmp_path: Path) -> None:
    text = TEXT.replace("UTF-8", "UTF-16").encode("utf-16")
    assert len(read_model(written(tmp_path, text)).components) == 36


# --- hostile files --------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE model [<!ENTITY secret SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE model SYSTEM "http://127.0.0.1:9/x.dtd">',
        "<!DOCTYPE model [<!ENTITY a 'aaaaaaaaaa'>"
        + "".join(f"<!ENTITY {b} '{f'&{a};' * 10}'>" for a, b in pairwise("abcdefghi"))
        + "]>",
    ],
)  # fmt: skip
def test_no_entity_is_read_or_expanded(tmp_path: Path, doctype: str) -> None:
    text = f"{doctype}{HEAD.replace('1.4', '&secret;&i;')}</model>"
    line = "file: expected XML without a document type, found <!DOCTYPE model>"
    assert refused(written(tmp_path, text)) == line


def test_an_undefined_entity_is_refused(tmp_path: Path) -> None:
    assert refused(written(tmp_path, "<model>&secret;</model>")).startswith(
        "file: expected well-formed"
    )


def test_a_bomb_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "LARGEST", 10**6)
    bomb = zipped(box_rexs=HEAD + " " * 2**24 + "</model>")
    assert len(bomb) < 2**16
    sizes, read = [], zipfile.ZipExtFile.read

    def counted(member: zipfile.ZipExtFile, size: int = -1) -> bytes:
        sizes.append(size)
        return read(member, size)

    monkeypatch.setattr(zipfile.ZipExtFile, "read", counted)
    line = refused(written(tmp_path, bomb, "box.rexsz"))
    assert sizes == [10**6 + 1]
    expected = "a model of at most 1 million bytes"
    assert line == f"file: expected {expected}, found a larger one in the archive"
    line = refused(written(tmp_path, HEAD + " " * 2**21 + "</model>"))
    assert line == "file: expected a REXS file to read, found a file larger than 1 million bytes"


def test_a_member_that_understates_its_size_is_refused(tmp_path: Path) -> None:
    data = bytearray(zipped(box_rexs=TEXT))
    entry = data.rindex(b"PK\x01\x02")
    data[entry + 24 : entry + 28] = (100).to_bytes(4, "little")
    assert refused(written(tmp_path, bytes(data), "box.rexsz")).startswith("file: expected ")


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"no archive", "file: expected a ZIP archive, found file is not a zip file"),
        (zipped(mesh_inp="*NODE"), "file: expected one file .rexs or .rexsj in the archive, "),
        (zipped(a_rexs=TEXT, b_rexsj="{}"), "file: expected one file .rexs or .rexsj in the "),
        (zipped(a_rexs=TEXT)[:900], "file: expected a ZIP archive, found "),
    ],
)  # fmt: skip
def test_each_fault_of_an_archive_has_its_line(tmp_path: Path, content: bytes, line: str) -> None:
    assert refused(written(tmp_path, content, "box.rexsz")).startswith(line)


def test_an_archive_damaged_in_its_lzma_is_refused(tmp_path: Path) -> None:
    """Regression: LZMAError was a traceback."""
    path = tmp_path / "box.rexsz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("box.rexs", TEXT)
    assert len(read_model(path).components) == 36
    data = bytearray(path.read_bytes())
    data[60:200] = bytes(140)
    path.write_bytes(data)
    assert refused(path).startswith("file: expected a ZIP archive, found ")


def test_an_encrypted_archive_is_refused(tmp_path: Path) -> None:
    data = bytearray(zipped(box_rexs=TEXT))
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        data[data.index(mark) + place] |= 1  # the flag of encryption
    line = refused(written(tmp_path, bytes(data), "box.rexsz"))
    assert line.startswith("file: expected a ZIP archive without encryption")


def test_names_in_an_archive_lead_nowhere(tmp_path: Path) -> None:
    path = tmp_path / "box.rexsz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("../../outside.rexs", TEXT)
    assert len(read_model(path).components) == 36
    assert [found.name for found in tmp_path.iterdir()] == ["box.rexsz"]


# --- stages ---------------------------------------------------------------------------------------
def test_the_stages_of_a_model() -> None:
    assert stage_rows(read_model(EXAMPLE))[1:] == [
        ("21", "11, 12", "25, 60", "external", "helical stage"),
        ("22", "13, 14", "24, 60", "internal", "planet and ring"),
    ]


@pytest.mark.parametrize(
    ("relations", "parts", "stage", "line"),
    [
        ([], [GEAR], None, "cylindrical_stage: expected at least one in the model, found none"),
        ([], [STAGE, STAGE.replace("9", "8")], None,
         "--stage: expected the id of a cylindrical_stage: 9, 8, found nothing"),
        ([], [STAGE], 7, "--stage: expected the id of a cylindrical_stage: 9, found 7"),
        ([], [STAGE], None, "cylindrical_stage 9: expected one cylindrical_gear or ring_gear as"),
        ([("stage", ("stage", 9), ("gear_1", 1), ("gear_2", 1))], [STAGE, GEAR], None,
         "cylindrical_stage 9: expected a gear and another gear or a ring gear"),
        ([("stage", ("stage", 9), ("gear_1", 1), ("gear_2", 9))], [STAGE, GEAR], None,
         "cylindrical_stage 9: expected one cylindrical_gear or ring_gear as gear_2"),
    ],
)  # fmt: skip
def test_each_fault_of_a_stage_has_its_line(
    tmp_path: Path, relations: list[object], parts: list[str], stage: int | None, line: str
) -> None:
    path = written(tmp_path, model_text(relations, parts))
    with pytest.raises(SceneError) as caught:
        scene_of_stage(read_model(path), Choices(stage=stage))
    assert str(caught.value).startswith(f"{path}: {line}")


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("25.5", "number_of_teeth: expected a positive integer, found 25.5"),
        ("-25", "number_of_teeth: expected a positive integer, found -25"),
        ("0", "teeth: expected a number > 0, found 0"),
        ("many", "number_of_teeth: expected a finite number, found 'many'"),
        ("nan", "number_of_teeth: expected a finite number, found 'nan'"),
        ("2_5", "number_of_teeth: expected a finite number, found '2_5'"),
        ("", "number_of_teeth: expected a finite number, found ''"),
        ("<matrix><r><c>1</c></r></matrix>", "number_of_teeth: expected a finite number, found a "),
    ],
)  # fmt: skip
def test_values_are_numbers(tmp_path: Path, value: str, line: str) -> None:
    path = written(tmp_path, TEXT.replace(">25</attribute>", f">{value}</attribute>", 1))
    with pytest.raises(SceneError) as caught:
        scene_of_stage(read_model(path), Choices(stage=21))
    assert str(caught.value).startswith(f"{path}: cylindrical_gear 11: {line}")


def test_a_unit_of_another_quantity_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, TEXT.replace('unit="mm">84.8', 'unit="N m">84.8'))
    with pytest.raises(SceneError, match="11: tip_diameter: expected one of the units mm, m,"):
        scene_of_stage(read_model(path), Choices(stage=21))


def test_an_unknown_value_of_a_word_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, TEXT.replace(">negative<", ">down<", 1))
    with pytest.raises(SceneError, match="expected 'positive' or 'negative', found 'down'"):
        scene_of_stage(read_model(path), Choices(stage=21))


# --- fuzz -----------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", ["box.rexs", "box.rexsj", "box.rexsz"])
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path: Path, name: str) -> None:
    """Bytes are changed, cut out or doubled; words and numbers of the model are exchanged."""
    rng = np.random.default_rng(20261123)
    forms = {"box.rexs": TEXT, "box.rexsj": in_json(TEXT)}
    whole = forms[name].encode() if name in forms else zipped(box_rexs=TEXT)
    words = [
        b"11",
        b"21",
        b"-1",
        b"0",
        b"1e308",
        b"null",
        b"true",
        b"gear_1",
        b"flank",
        b"mm",
        b"[]",
    ]
    lines = []
    for _ in range(60):
        path = written(tmp_path, damaged(whole, words, rng), name)
        lines.append(outcome(path, int(rng.choice([21, 22]))))
        assert lines[-1].startswith(f"{path}: ") or not lines[-1]
        assert "\n" not in lines[-1]
    refusals = sum(map(bool, lines))
    assert refusals > 10
    assert refusals < 60 or name == "box.rexsz"


def damaged(whole: bytes, words: list[bytes], rng: np.random.Generator) -> bytes:
    """Bytes with one to three faults."""
    data = bytearray(whole)
    for _ in range(rng.integers(1, 4)):
        at = int(rng.integers(len(data)))
        match rng.integers(4):
            case 0:
                data[at] = rng.integers(256)
            case 1:
                del data[at : at + int(rng.integers(1, 40))]
            case 2:
                data[at:at] = data[at : at + int(rng.integers(1, 200))]
            case 3:
                old, new = (words[k] for k in rng.choice(len(words), 2))
                place = max(0, data.find(old, at))
                data[place : place + len(old)] = new
    return bytes(data)


def outcome(path: Path, stage: int) -> str:
    """The error line of a stage, or nothing."""
    settings = {"body_2.outer_diameter_mm": 220.0} if stage == 22 else {}
    try:
        model = read_model(path)
        stage_rows(model)
        scene_of_stage(model, Choices(stage=stage, settings=settings))
    except SceneError as error:
        return str(error)
    return ""
