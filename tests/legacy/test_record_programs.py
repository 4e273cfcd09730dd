"""Programs that solve a pair from the files of `flankload record`."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload import _core
from flankload.cli import main
from flankload.contact.record_files import bytes_of
from flankload.studies.coarse import coarse
from tests.support.paths import ROOT
from tests.support.programs import EXAMPLES, built, expect_printed, run
from tests.support.solving import solve

PAIRS = ["external_gear_friction", "helical_gear"]


def read(path: Path) -> np.ndarray:
    needed = _core.flankload_read_record(str(path), np.empty(0))
    record = np.full(needed + 1, np.nan)
    assert _core.flankload_read_record(str(path), record) == 0
    assert np.isnan(record[-1])
    return record[:-1]


@pytest.fixture(scope="module", params=PAIRS)
def pair(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[fl.Result, Path]:
    """Result of a coarse scene, and the folder of its records."""
    scene = fl.read_scene(ROOT / "examples" / "scenes" / f"{request.param}.toml")
    changes = {"positions.count": 2, "accuracy.estimate": False, "accuracy.tangents": False}
    scene = coarse(scene.replace(changes))
    folder = tmp_path_factory.mktemp(request.param)
    (folder / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    assert main(["record", str(folder / "scene.toml"), "-o", str(folder / "records")]) == 0
    result = solve(scene)
    assert isinstance(result, fl.Result)
    return result, folder / "records"


def loads(result: fl.Result, k: int) -> tuple[float, float]:
    """Largest force of a flank, or of a slice of it, in position k, and their sum."""
    forces = (result.site_force_N if result.slices is None else result.slices.force_N)[k]
    return float(forces.max()), float(forces.sum())


def test_fixed_form_fortran_solves_a_pair_from_its_files(
    pair: tuple[fl.Result, Path], workshop: Path, environment: dict[str, str], tmp_path: Path
) -> None:
    result, records = pair
    folder = built(
        EXAMPLES / "legacy_fortran",
        workshop / "legacy_fortran",
        environment,
        static=False,
        program="records",
    )
    name = tmp_path / "folder"
    name.write_text(f"{records}\n", encoding="ascii")
    first, *rows = run(folder / "records", name, environment).splitlines()
    expect_printed(first.split()[-1], float(result.torque_Nm) * 1e3)
    assert len(rows) == len(result.rotation_rad)
    for k, row in enumerate(rows):
        _, status, rotation, largest, total = row.split()
        assert int(status) == 0
        expect_printed(rotation, result.rotation_rad[k])
        for word, force in zip((largest, total), loads(result, k), strict=True):
            expect_printed(word, force)


def test_c_solves_a_pair_from_its_files(
    pair: tuple[fl.Result, Path], prefix: Path, workshop: Path, environment: dict[str, str]
) -> None:
    """The programs use handles, in C and through ctypes."""
    result, records = pair
    folder = built(EXAMPLES / "c", workshop / "c", environment, static=False, program="records")
    script = [EXAMPLES / "c" / "records_ctypes.py", prefix / "lib" / "libflankload.so", records]
    for printed in (
        run(folder / "records", None, environment, str(records)),
        run(Path(sys.executable), None, environment, *map(str, script)),
    ):
        _, *rows = printed.splitlines()
        assert len(rows) == len(result.rotation_rad)
        for k, row in enumerate(rows):
            _, status, rotation, *forces = row.split()
            assert int(status) == 0
            expect_printed(rotation, result.rotation_rad[k])
            for word, force in zip(forces, loads(result, k), strict=False):
                expect_printed(word, force)


def test_text_and_bytes_have_the_same_numbers(pair: tuple[fl.Result, Path], tmp_path: Path) -> None:
    files = sorted(pair[1].iterdir())
    assert [path.stem for path in files] == ["body_1", "body_2", "mesh", "motion"]
    for path in files:
        record = read(path)
        assert record[1] == record.size
        (tmp_path / path.stem).write_bytes(bytes_of(record))
        np.testing.assert_array_equal(read(tmp_path / path.stem), record)


def test_files_that_are_no_record_are_refused(pair: tuple[fl.Result, Path], tmp_path: Path) -> None:
    """Missing, foreign and truncated files and folders: one line, and the array is unchanged."""
    text = (pair[1] / "mesh.dat").read_text(encoding="utf-8")
    whole = bytes_of(read(pair[1] / "mesh.dat"))
    spoiled = {
        "empty": b"",
        "words": b"body_1 of a scene\n",
        "cut": text[: len(text) // 2].encode(),
        "cut_bytes": whole[:-8],
        "mark_alone": text.split(" ")[0].encode(),
        "long": text.replace(f" {int(read(pair[1] / 'mesh.dat')[1])} ", " 1e300 ", 1).encode(),
    }
    for name, content in spoiled.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "folder").mkdir()
    record = np.full(2000, 7.0)
    for name in (*spoiled, "folder", "missing"):
        assert _core.flankload_read_record(str(tmp_path / name), record) == -101, name
        said = _core.flankload_status_text(-101).decode()
        assert said.startswith("flankload_read_record: name: expected a file"), said
        assert (record == 7.0).all()
