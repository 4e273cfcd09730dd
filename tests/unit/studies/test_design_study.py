"""Design studies: designs, workers of all kinds, the store, tables."""

from __future__ import annotations

import csv
import io
import json
import os
import pickle
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.base.blas_threads import one_blas_thread
from flankload.studies.design import Designs, run_study
from flankload.studies.design import run as run_module
from flankload.studies.design import run_designs as runs_module
from flankload.studies.design.run import Outcome
from flankload.studies.design.store import Store, key_of
from flankload.studies.variables import variables_of
from tests.support.design_scene import TEXT, design_scene
from tests.support.made_up_result import made_up_result
from tests.support.paths import EXAMPLES, SCENES

TORQUE, SHIFT = "load.torque_Nm", "body_1.profile_shift"
RANGE = {"distribution": "uniform", "lower": 100, "upper": 300}
PEAK = "peak_pressure_MPa"


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[fl.Scene]:
    """Scenes that are solved in this process."""
    scenes: list[fl.Scene] = []
    solve = run_module.solve_scene

    def counted(scene: fl.Scene, *arguments: Any) -> Any:
        scenes.append(scene)
        return solve(scene, *arguments)

    monkeypatch.setattr(run_module, "solve_scene", counted)
    return scenes


@pytest.fixture
def one_thread() -> Iterator[Executor]:
    with ThreadPoolExecutor(1) as executor:
        yield executor


def values_of(design: str, variables: dict[str, Any], **options: Any) -> list[dict[str, Any]]:
    designs = Designs(variables_of(variables), design, **options)
    designs.check()
    found = list(designs)
    assert len(found) == len(designs)
    return found


# --- designs --------------------------------------------------------------------------------------
def test_designs_of_values() -> None:
    variables = {"a": [1, 2], "b": ["x", "y"]}
    rows = [{"a": 1, "b": "x"}, {"a": 1, "b": "y"}, {"a": 2, "b": "x"}, {"a": 2, "b": "y"}]
    assert values_of("factorial", variables) == rows
    assert values_of("list", variables) == [rows[0], rows[3]]
    alone = [{}, {"a": 1}, {"a": 2}, {"b": "x"}, {"b": "y"}]
    assert values_of("one-at-a-time", variables) == alone


@pytest.mark.parametrize("design", ["sobol", "random"])
def test_more_draws_begin_with_the_same_ones(design: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[Designs.__module__], "BLOCK", 8)
    variables = {"a": RANGE, "b": RANGE}
    few = values_of(design, variables, n=5, seed=3)
    assert few == values_of(design, variables, n=16, seed=3)[:5]
    assert few != values_of(design, variables, n=5, seed=4)
    assert all(100 < row[name] < 300 for row in few for name in row)


def test_a_sobol_sequence_fills_each_interval_once() -> None:
    found = [row["a"] for row in values_of("sobol", {"a": RANGE, "b": RANGE}, n=16)]
    intervals = sorted(int((value - 100) / 200 * 16) for value in found)
    assert intervals == list(range(16))


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            {"design": "grid"},
            "design: expected 'factorial' or 'list' or 'one-at-a-time' or 'sobol' or 'random', f",
        ),
        (
            {"design": "random", "n": 2},
            f"variables.{TORQUE}: expected a distribution, since the design is 'random', found [1",
        ),
        (
            {"variables": {TORQUE: RANGE}},
            f"variables.{TORQUE}: expected a list of values, since the design is 'factorial', fou",
        ),
        ({"n": 3}, "n: expected no such key, since the design is 'factorial', found 3"),
        (
            {"variables": {TORQUE: RANGE}, "design": "sobol"},
            "n: expected an integer from 1 to 1073741824: the number of designs, found nothing",
        ),
        ({"seed": -1}, "seed: expected an integer from 0 to 2^63, found -1"),
        (
            {"variables": {TORQUE: [1, 2], SHIFT: [0.1]}, "design": "list"},
            f"variables.{SHIFT}: expected 2 values, as many as {TORQUE}, found 1",
        ),
        ({"quantities": "abc"}, "quantities: expected a non-empty list of names, found 'abc'"),
        ({"store": "none/a.sqlite"}, "store: expected a file in a folder that exists, found no"),
        (
            {"variables": {"load.torqe_Nm": [1]}},
            "variables.load.torqe_Nm: expected a known key (did you mean torque_Nm?), found the u",
        ),
        (
            {"variables": {TORQUE: [100], "load": [3]}, "design": "one-at-a-time"},
            "variables.load: expected a table, found 3",
        ),
    ],
)
def test_a_wrong_study_gets_one_line_before_anything_is_solved(
    arguments: dict[str, Any], line: str, solved: list[fl.Scene]
) -> None:
    with pytest.raises(fl.SceneError) as refused:
        fl.study(design_scene(), **({"variables": {TORQUE: [100, 200]}} | arguments))
    assert str(refused.value).startswith(line)
    assert not solved


@pytest.mark.parametrize(
    ("name", "said"),
    [("peak_presure_MPa", "did you mean peak_pressure_MPa?"), ("zzz", "contact_ratio_geometric, ")],
)
def test_an_unknown_quantity_ends_the_study_after_one_run(
    name: str, said: str, solved: list[fl.Scene], tmp_path: Path
) -> None:
    for _ in range(2):  # nothing is stored that would hide it
        with pytest.raises(fl.SceneError, match="quantities: expected names in") as refused:
            fl.study(
                design_scene(), {TORQUE: [100, 200, 300]}, quantities=[PEAK, name],
                store=tmp_path / "a.sqlite",
            )  # fmt: skip
        assert said in str(refused.value)
        assert str(refused.value).endswith(f"found '{name}'")
    assert len(solved) == 2


# --- workers --------------------------------------------------------------------------------------
#: The second changes a body and its elements.
VARIABLES = {TORQUE: [100, 150, 200], SHIFT: [0.18, 0.182]}
NAMES = [PEAK, "transmission_error_um"]


@cache
def serial() -> bytes:
    """Bits of the study, by single runs."""
    found = []
    with one_blas_thread():
        for torque in VARIABLES[TORQUE]:
            for shift in VARIABLES[SHIFT]:
                result = fl.solve(design_scene(**{TORQUE: torque, SHIFT: shift}))
                found.append([result.summary[PEAK], *result.transmission_error_um])
    return np.array(found).tobytes()


def bits(study: fl.DesignStudy) -> bytes:
    return np.column_stack([study.values(name) for name in NAMES]).tobytes()


def test_each_table_of_a_scene_is_in_the_key_of_its_run() -> None:
    """Regression: tables of stage and planets were missing, so all designs had the same result."""
    scene = fl.read_scene(SCENES / "planetary_stage.toml")
    changes = ("planet.tip_diameter_mm", 56.5), ("stage.floating", "none"), ("load.torque_Nm", 5)
    keys = {key_of(scene), *(key_of(scene.replace({key: value})) for key, value in changes)}
    assert len(keys) == 1 + len(changes)


def test_threads_give_the_bits_of_single_runs() -> None:
    for _ in range(2):
        with ThreadPoolExecutor(4) as executor:
            assert (
                bits(fl.study(design_scene(), VARIABLES, quantities=NAMES, executor=executor))
                == serial()
            )


def test_prepared_scenes_may_be_solved_by_several_threads() -> None:
    prepared = fl.prepare(design_scene())
    changes = [{TORQUE: 100 + k, SHIFT: 0.18 + 0.001 * (k % 2)} for k in range(8)]
    with ThreadPoolExecutor(4) as executor:
        found = list(executor.map(prepared.solve, changes))
    for result, change in zip(found, changes, strict=True):
        single = fl.solve(design_scene(**change))
        assert result.rotation_rad.tobytes() == single.rotation_rad.tobytes()
        assert result.site_force_N.tobytes() == single.site_force_N.tobytes()


def test_runs_share_elements(one_thread: Executor, monkeypatch: pytest.MonkeyPatch) -> None:
    costs = []
    solve = run_module.solve_scene

    def watched(*arguments: Any) -> Any:
        result = solve(*arguments)
        costs.append(result.cost["fe_factorisations"])
        return result

    monkeypatch.setattr(run_module, "solve_scene", watched)
    fl.study(design_scene(), VARIABLES, executor=one_thread)
    assert costs == [2, 1, 0, 0, 0, 0]
    assert not run_module._held  # and this process holds them no longer
    costs.clear()
    with ThreadPoolExecutor(4) as executor:  # the others wait for the elements of the first one
        fl.study(design_scene(), {TORQUE: [100, 150, 200, 250]}, executor=executor)
    assert sorted(costs) == [0, 0, 0, 2]


def test_processes_give_the_bits_of_single_runs_and_a_lost_one_costs_nothing(
    tmp_path: Path, solved: list[fl.Scene]
) -> None:
    store = tmp_path / "a.sqlite"
    designs = Designs(variables_of(VARIABLES))
    with ProcessPoolExecutor(2, get_context("spawn")) as executor:

        def kill(_: str, done: int, total: int) -> None:
            if done == 3:
                os.kill(next(iter(executor._processes)), signal.SIGKILL)

        said = (
            r"\d of 6 designs are finished \(the store has them\), then a worker was lost: it was"
        )
        with pytest.raises(fl.FlankloadError, match=said):
            run_study(design_scene(), designs, NAMES, store, executor, kill)
    finished = stored(store)
    assert 3 <= len(finished) < 6
    assert not solved  # not in this process
    study = run_study(design_scene(), designs, NAMES, store)
    assert bits(study) == serial()
    assert len(solved) == 6 - len(finished)
    assert finished.items() <= stored(store).items()


def test_a_worker_that_is_lost_before_a_task_is_submitted_costs_nothing(tmp_path: Path) -> None:
    """Regression: the traceback of a broken pool in `submit` was shown."""
    store = tmp_path / "a.sqlite"
    designs = Designs(variables_of({TORQUE: [100, 200, 300]}))

    class Breaking(ThreadPoolExecutor):
        def submit(self, *call: Any, **options: Any) -> Future[Any]:
            if number_in(store):
                raise BrokenProcessPool("A child process terminated abruptly")
            return super().submit(*call, **options)

    with Breaking(1) as executor, pytest.raises(fl.FlankloadError) as lost:
        run_study(design_scene(), designs, NAMES, store, executor)
    assert str(lost.value) == (
        "1 of 3 designs are finished (the store has them), then a worker was lost: it was killed "
        "or had not enough memory; fewer workers need less"
    )
    assert len(stored(store)) == 1


def test_dask_workers_give_the_bits_of_single_runs() -> None:
    from distributed import Client, LocalCluster

    with (
        # no process of its own: several are tried above
        LocalCluster(
            n_workers=1, threads_per_worker=1, dashboard_address=":0", processes=False
        ) as cluster,
        Client(cluster) as client,
        client.get_executor() as executor,
    ):
        assert (
            bits(fl.study(design_scene(), VARIABLES, quantities=NAMES, executor=executor))
            == serial()
        )


class Watched(ThreadPoolExecutor):
    """A thread that counts the runs that it has not finished, and the bytes of its tasks."""

    def __init__(self) -> None:
        super().__init__(1)
        self.open: list[Future[Any]] = []
        self.most = self.bytes = 0

    def submit(self, call: Any, /, *_: Any, **__: Any) -> Future[Any]:
        task = call.args[0]
        self.bytes = max(self.bytes, len(pickle.dumps(task)))
        future = super().submit(call)
        self.open = [*(held for held in self.open if not held.done()), future]
        self.most = max(self.most, len(self.open))
        return future


def test_tasks_are_small_and_few_are_in_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs_module, "MOST_IN_FLIGHT", 3)
    with Watched() as executor:
        study = fl.study(design_scene(), {TORQUE: list(range(100, 112))}, executor=executor)
    assert not study.failed
    assert 1 < executor.most <= 3
    assert executor.bytes < 4000


# --- the store ------------------------------------------------------------------------------------
def stored(path: Path) -> dict[str, tuple[Any, ...]]:
    """Rows of a store by key."""
    with sqlite3.connect(path) as db:
        rows = db.execute("SELECT key, status, seconds, finished FROM runs").fetchall()
    db.close()
    return {row[0]: row[1:] for row in rows}


def test_a_damaged_store_is_one_line_and_gives_no_other_number(tmp_path: Path) -> None:
    """Regression: flipped bytes gave tracebacks of DatabaseError, JSONDecodeError and TypeError."""
    whole, damaged = tmp_path / "a.sqlite", tmp_path / "b.sqlite"
    row = {"torque_Nm": 1.0, "quantities": {PEAK: 1500.0, "curve": [0.5] * 50}, "estimate": {}}
    outcomes = {f"{k:040x}": Outcome("solved", 0.1 * k, None, (row,)) for k in range(20)}
    with closing(Store(whole)) as store:
        for key, outcome in outcomes.items():
            store.add(key, {TORQUE: 1.0}, outcome)
    content, random = whole.read_bytes(), np.random.default_rng(7)
    lines: set[str] = set()
    for n in range(150):
        for old in tmp_path.glob("b.sqlite*"):
            old.unlink()
        spoiled = np.frombuffer(content, np.uint8).copy()
        places = random.integers(0, spoiled.size, 1 + n % 5)
        spoiled[places] ^= np.uint8(1) << random.integers(0, 8, places.size).astype(np.uint8)
        damaged.write_bytes(spoiled[: random.integers(1, spoiled.size) if n % 5 == 0 else None])
        try:
            with closing(Store(damaged)) as store:
                found = {key: store.find(key) for key in outcomes}
                store.add("new", {}, outcomes[f"{0:040x}"])
        except fl.SceneError as error:
            lines.add(str(error))
        else:  # a run that is not found is solved again
            assert all(one in (None, outcomes[key]) for key, one in found.items())
    remedy = "store: expected an undamaged file; after it is deleted, all designs are solved again"
    assert f"{remedy}, found {damaged}: a run that has changed since it was written" in lines
    assert f"{remedy}, found {damaged}: database disk image is malformed" in lines


def test_a_store_is_extended_by_other_values_and_quantities(
    tmp_path: Path, solved: list[fl.Scene]
) -> None:
    store = tmp_path / "a.sqlite"

    def solves(variables: dict[str, Any], quantities: list[str], **changes: Any) -> int:
        before = len(solved)
        study = fl.study(design_scene(**changes), variables, quantities=quantities, store=store)
        assert np.isfinite(study.values(quantities[0])).all()
        return len(solved) - before

    assert solves({TORQUE: [100, 200]}, [PEAK]) == 2
    assert solves({TORQUE: [100, 200]}, [PEAK]) == 0
    assert solves({TORQUE: [200, 300, 100]}, [PEAK]) == 1
    assert solves({TORQUE: [100]}, ["loaded_pairs_max"]) == 0  # the whole summary is stored
    assert solves({TORQUE: [100]}, ["transmission_error_um"]) == 1
    assert solves({TORQUE: [100]}, [PEAK]) == 0
    assert solves({TORQUE: [100]}, ["loaded_pairs"]) == 1
    assert solves({TORQUE: [100]}, ["transmission_error_um", "loaded_pairs"]) == 0
    assert solves({SHIFT: [0.182]}, [PEAK], **{TORQUE: 200}) == 0  # the scene counts, not the way
    assert solves({TORQUE: [100]}, [PEAK], **{"accuracy.modes": 5}) == 1
    assert solves({"name": ["other"], TORQUE: [100]}, [PEAK]) == 0
    assert len(stored(store)) == 4


def test_a_design_that_occurs_twice_is_solved_once(solved: list[fl.Scene]) -> None:
    study = fl.study(design_scene(), {TORQUE: [302, 100], SHIFT: [0.182]}, "one-at-a-time")
    assert len(solved) == 2
    assert study.columns()[TORQUE] == [302.0, 302, 100, 302.0]
    assert len({study.values(PEAK)[k] for k in (0, 1, 3)}) == 1
    solved.clear()
    study = fl.study(design_scene(), {TORQUE: [302, 100, 100]})  # while it is in flight
    assert len(solved) == 2
    assert study.values(PEAK)[1] == study.values(PEAK)[2]


def test_a_changed_file_is_another_run(tmp_path: Path, solved: list[fl.Scene]) -> None:

    for name in ("pinion", "wheel"):
        text = (EXAMPLES / "meshes" / f"fzg_c_{name}.msh").read_bytes()
        (tmp_path / f"fzg_c_{name}.msh").write_bytes(text)
    scene = fl.read_scene(SCENES / "external_gear_mesh.toml").replace(
        {
            "body_1.file": str(tmp_path / "fzg_c_pinion.msh"),
            "body_2.file": str(tmp_path / "fzg_c_wheel.msh"),
            "accuracy.estimate": False,
            "accuracy.tangents": False,
            "positions": {"count": 1},
        }
    )
    for comment in ("", "", "a"):
        with (tmp_path / "fzg_c_wheel.msh").open("a", encoding="utf-8") as stream:
            stream.write(comment and "$Comments\nother\n$EndComments\n")
        study = fl.study(scene, {TORQUE: [100]}, store=tmp_path / "a.sqlite")
        assert not study.failed
    assert len(solved) == 2


def test_a_failed_design_is_a_row_with_its_reason(tmp_path: Path, solved: list[fl.Scene]) -> None:
    store, bore = tmp_path / "a.sqlite", "body_1.bore_diameter_mm"
    # no scene; a scene without a body
    for _ in range(2):
        study = fl.study(design_scene(), {bore: [30, -1, 70, 31]}, store=store)
        assert [row.number for row in study.failed] == [1, 2]
        words = [row.outcome.error for row in study.failed]
        assert words[0] is not None
        assert words[0].startswith(f"{bore}: expected a number from")
        assert words[1] is not None
        assert words[1].startswith(f"{bore}: expected")
        assert np.isfinite(study.values(PEAK)).tolist() == [True, False, False, True]
    assert len(solved) == 3  # a failure is final
    assert "4 designs, 2 of them failed; first: body_1.bore_diameter_mm: expected" in str(study)


def test_an_error_that_is_not_of_the_design_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise MemoryError("no room")

    variables, store = {TORQUE: [100]}, tmp_path / "a.sqlite"
    with monkeypatch.context() as patch:
        patch.setattr(run_module, "solve_scene", full)
        study = fl.study(design_scene(), variables, store=store)
    assert study.failed[0].outcome.error == "MemoryError: no room"
    assert not fl.study(design_scene(), variables, store=store).failed


@pytest.mark.parametrize("content", [b"not a database\n" * 100, None])
def test_another_file_is_no_store(content: bytes | None, tmp_path: Path) -> None:
    store = tmp_path / "a.sqlite"
    if content is None:
        with sqlite3.connect(store) as db:
            db.execute("CREATE TABLE runs (a TEXT)")
        db.close()
    else:
        store.write_bytes(content)
    before = store.read_bytes()
    with pytest.raises(fl.SceneError) as refused:
        fl.study(design_scene(), {TORQUE: [100]}, store=store)
    expected = "a store of design studies of this version, or no file yet"
    line = f"store: expected {expected}, found {store}, which is another file"
    assert str(refused.value) == line
    assert store.read_bytes() == before


PROGRAM = """
import tomllib, flankload as fl
scene = fl.Scene.from_dict(tomllib.loads('''{text}'''))
fl.study(scene, {{"load.torque_Nm": list(range(100, 100 + {count}))}}, store={store!r})
"""


def test_a_killed_study_resumes_and_repeats_only_runs_in_flight(
    tmp_path: Path, solved: list[fl.Scene]
) -> None:
    count, store = 200, tmp_path / "a.sqlite"
    program = PROGRAM.format(text=TEXT, store=str(store), count=count)
    with subprocess.Popen([sys.executable, "-c", program]) as process:
        wait_for(store, 3)
        # meanwhile another process writes into the same store
        last = fl.study(design_scene(), {TORQUE: [100 + count - 1]}, store=store)
        assert not last.failed
        wait_for(store, len(stored(store)) + 1)
        process.send_signal(signal.SIGKILL)
    finished = stored(store)
    assert 5 <= len(finished) < count
    torques = [*range(100, 130), 100 + count - 1]
    solved.clear()
    study = fl.study(design_scene(), {TORQUE: torques}, store=store)
    assert not study.failed
    assert finished.items() <= stored(store).items()  # not written again
    assert len(solved) == len(stored(store)) - len(finished)
    again = fl.study(design_scene(), {TORQUE: torques[-3:]})
    assert study.values(PEAK)[-3:].tobytes() == again.values(PEAK).tobytes()


def wait_for(store: Path, count: int) -> None:
    """Wait until a store has some rows."""
    limit = time.monotonic() + 60
    while time.monotonic() < limit and not (store.exists() and number_in(store) >= count):
        time.sleep(0.01)


def number_in(store: Path) -> int:
    try:
        return len(stored(store))
    except sqlite3.OperationalError:  # the table is about to be made
        return 0


def test_an_interrupt_stores_what_is_finished(tmp_path: Path, one_thread: Executor) -> None:
    store = tmp_path / "a.sqlite"

    def interrupt(_: str, done: int, __: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    designs = Designs(variables_of({TORQUE: list(range(100, 150))}))
    with pytest.raises(KeyboardInterrupt) as stop:
        run_study(design_scene(), designs, [PEAK], store, one_thread, interrupt)
    assert 2 <= len(stored(store)) < 50
    assert str(stop.value) == f"interrupted: {len(stored(store))} of 50 designs are finished"


# --- tables ---------------------------------------------------------------------------------------
@cache
def study_of_torques() -> fl.DesignStudy:
    """Two torques, curves and harmonics, a failed design, an error estimate."""
    scene = design_scene(**{TORQUE: [100, 200], "accuracy.estimate": True})
    quantities = [PEAK, "transmission_error_um", "transmission_error_harmonics_um"]
    bores = {"body_1.bore_diameter_mm": [30, 70]}
    return fl.study(scene, {SHIFT: [0.18, 0.182], **bores}, quantities=quantities)


def test_a_factorial_study_as_labelled_arrays() -> None:
    data = study_of_torques().to_xarray()
    bore = "body_1.bore_diameter_mm"
    sizes = {SHIFT: 2, bore: 2, "torque": 2, "position": 2}
    assert dict(data.sizes) == sizes | {"harmonic": data.sizes["harmonic"]}
    assert data[bore].values.tolist() == [30, 70]
    single = fl.solve(design_scene(**{TORQUE: 200, SHIFT: 0.182}))
    place = {SHIFT: 0.182, bore: 30}
    found = data.sel(place)
    assert found[PEAK].dims == ("torque",)
    assert found["torque_Nm"].values.tolist() == [100.0, 200.0]
    np.testing.assert_allclose(found[PEAK].values[1], single.summary[PEAK], rtol=1e-9, atol=0)
    np.testing.assert_allclose(
        found["transmission_error_um"].values[1], single.transmission_error_um, rtol=1e-9, atol=0
    )
    assert data["transmission_error_um"].attrs["units"] == "um"
    assert (found["estimate_transmission_error"] > 0).all()
    assert data["status"].sel({bore: 70}).values.tolist() == ["failed"] * 2
    assert np.isnan(data[PEAK].sel({bore: 70}).values).all()


def test_other_studies_have_a_dimension_for_their_designs() -> None:
    study = fl.study(design_scene(), {TORQUE: [100, 200], SHIFT: [0.18, 0.182]}, "list")
    data = study.to_xarray()
    assert data[PEAK].dims == ("design",)
    assert data[SHIFT].values.tolist() == [0.18, 0.182]
    assert data[PEAK].values.tobytes() == study.values(PEAK).tobytes()


def test_csv_has_a_row_for_each_design_and_torque(tmp_path: Path) -> None:
    study = study_of_torques()
    rows = list(csv.DictReader(io.StringIO(study.to_csv(tmp_path / "a.csv"))))
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == study.to_csv()
    assert [row["design"] for row in rows] == list("001223")
    assert [row["torque_Nm"] for row in rows[:4]] == ["100.0", "200.0", "", "100.0"]
    assert rows[2]["status"] == "failed"
    assert rows[2][PEAK] == rows[2]["transmission_error_um[1]"] == ""
    assert "expected" in rows[2]["error"]
    found = [float(row["transmission_error_um[1]"]) for row in (rows[0], rows[1])]
    assert found == study.values("transmission_error_um")[0, :, 1].tolist()
    assert float(rows[0]["estimate_transmission_error"]) > 0


def test_parquet_has_the_same_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pyarrow import parquet

    study = study_of_torques()
    study.to_parquet(tmp_path / "a.parquet")
    assert parquet.read_table(tmp_path / "a.parquet").to_pydict() == study.columns()
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ImportError, match=r"pip install 'flankload\[parquet\]'"):
        study.to_parquet(tmp_path / "b.parquet")


def test_values_may_be_words_lists_and_tables() -> None:
    positions = [{"count": 1}, {"angles_deg": [0.0, 5.0, 7.0]}]
    study = fl.study(
        design_scene(),
        {"positions": positions, "body_1.rigid": [True, False], TORQUE: [[100], [100, 200]]},
        "factorial",
        quantities=["transmission_error_um"],
    )
    data = study.to_xarray()
    assert data["positions"].values.tolist() == [json.dumps(part) for part in positions]
    assert data["transmission_error_um"].shape == (2, 2, 2, 2, 3)
    found = np.isfinite(data["transmission_error_um"].values).sum(axis=(3, 4))
    assert found.tolist() == [[[1, 2], [1, 2]], [[3, 6], [3, 6]]]
    assert np.isfinite(data["position_rad"].values[1, 0, 1]).all()


def test_a_curve_is_computed_only_if_it_is_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    def computed(_: fl.Result) -> None:
        pytest.fail("nobody wants this curve")

    monkeypatch.setattr(fl.Result, "coast_flank_gap_um", property(computed))
    result = made_up_result(count=4)
    names = ("transmission_error_um", "peak_pressure_MPa")
    found = run_module.row_of(result, names, whole=False)["quantities"]
    assert found["transmission_error_um"] == result.transmission_error_um.tolist()
    assert found["position_rad"] == result.position_rad.tolist()
