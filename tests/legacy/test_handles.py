"""The C interface by handles: errors that name what was expected, null pointers, deletion twice."""

from __future__ import annotations

import ctypes
import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest

from flankload import _core
from tests.support.packed_meshes import CYLINDER, body_record, mesh_record
from tests.support.paths import FORTRAN

HEADER = (FORTRAN / "handles" / "flankload_handles.h").read_text(encoding="utf-8")
MAKERS = re.findall(r"^flankload_\w+ (flankload_\w+)\(", HEADER, re.MULTILINE)
#: Angles of both bodies in two positions.
ANGLES = np.array([0.0, np.pi, 0.001, np.pi - 0.001])


def roller() -> np.ndarray:
    """One of two cylinders; the second is the first one turned over."""
    return body_record(1, 1e-6 * np.eye(3)[:, :, None] * np.array([1.0, 0.0]))


class Library:
    """The installed library, an error handle, and calls that return its message."""

    def __init__(self, prefix: Path) -> None:
        self.core = ctypes.CDLL(str(prefix / "lib" / "libflankload.so"))
        for name in MAKERS:
            getattr(self.core, name).restype = ctypes.c_void_p
        self.error = ctypes.c_void_p(self.core.flankload_new_error())

    def call(self, name: str, *arguments: Any) -> Any:
        found = getattr(self.core, f"flankload_{name}")(self.error, *map(passed, arguments))
        return ctypes.c_void_p(found) if f"flankload_{name}" in MAKERS else found

    def message(self) -> str:
        """The message, which is then removed."""
        text = ctypes.create_string_buffer(200)
        self.core.flankload_get_error(self.error, text, 200)
        self.core.flankload_clear_error(self.error)
        return text.value.decode()


def passed(argument: Any) -> Any:
    """An argument by value, or the address of an array."""
    if isinstance(argument, np.ndarray):
        return ctypes.c_void_p(argument.ctypes.data)
    return ctypes.c_double(argument) if isinstance(argument, float) else argument


@pytest.fixture
def library(prefix: Path) -> Library:
    return Library(prefix)


@pytest.fixture
def files(tmp_path: Path) -> Callable[[str, np.ndarray], bytes]:
    def file(name: str, record: np.ndarray) -> bytes:
        (tmp_path / name).write_bytes(record[: int(record[1])].tobytes())
        return bytes(tmp_path / name)

    return file


def two_rollers(library: Library, files: Callable[[str, np.ndarray], bytes]) -> ctypes.c_void_p:
    """A problem of two equal rollers, whose bodies are deleted at once."""
    problem = library.call("new_problem")
    body = library.call("read_body", files("roller", roller()))
    mesh = library.call("read_mesh", files("mesh", mesh_record(0.0)))
    assert [library.call("add_body", problem, body) for _ in range(2)] == [1, 2]
    assert library.call("add_mesh", problem, mesh) == 1
    library.core.flankload_delete_body(ctypes.byref(body))
    library.core.flankload_delete_mesh(ctypes.byref(mesh))
    library.call("set_positions", problem, 2, ANGLES)
    library.call("set_loads", problem, 1, np.array([3.6e4]))
    return problem


def built_rollers(library: Library) -> ctypes.c_void_p:
    """The same problem without files."""
    problem, corners = library.call("new_problem"), np.zeros(CYLINDER.breaks.size, np.intc)
    coefficients = np.asfortranarray(CYLINDER.coefficients.transpose(2, 1, 0))
    sizes = CYLINDER.breaks.size, coefficients.shape[0] - 1
    body = library.call("new_body", *sizes, CYLINDER.breaks, coefficients, corners)
    library.call("set_body_sites", body, 1, np.zeros(1), np.zeros(1))
    smooth = np.asfortranarray(1e-6 * np.eye(3)[:, :, None] * np.array([1.0, 0.0]))
    ends, block = np.array([0.0, CYLINDER.length_mm]), np.ones(1, np.intc)
    library.call("set_body_compliance", body, 3, 2, ends, 2.8e-7, smooth, block)
    mesh = library.call("new_mesh", 1, 1.0)
    library.call("set_mesh_axes", mesh, np.zeros(2), np.array([72.0, 0.0]))
    library.call("set_mesh_twist", mesh, 0.0)
    library.call("set_mesh_cells", mesh, 10.0, 30.0, 2.5)
    library.call("set_mesh_model", mesh, 0)
    library.call("set_mesh_finite_steps", mesh, 0)
    for _ in range(2):
        library.call("add_body", problem, body)
    library.call("add_mesh", problem, mesh)
    library.call("add_motion", problem, 1, 1, 3, 1)
    library.call("set_positions", problem, 2, ANGLES)
    library.call("set_speeds", problem, np.zeros(4))
    library.call("set_displacements", problem, np.zeros(12))
    library.call("set_loads", problem, 1, np.array([3.6e4]))
    return problem


def rotations(library: Library, problem: ctypes.c_void_p) -> np.ndarray:
    found = library.call("solve", problem)
    assert library.message() == ""
    assert library.call("count_failures", found) == 0
    motion = np.empty(2)
    library.call("get_motion", found, motion)
    library.core.flankload_delete_result(ctypes.byref(found))
    return motion


def test_every_prototype_is_exported(library: Library) -> None:
    names = re.findall(r"^(?:void|int|flankload_\w+) (flankload_\w+)\(", HEADER, re.MULTILINE)
    assert len(names) == HEADER.count(");\n") == len(set(names)) > 40
    for name in names:
        assert getattr(library.core, name)
    version, *parts = library.core.flankload_api_version(), *_core.flankload_version()[:3]
    assert version == 10000 * parts[0] + 100 * parts[1] + parts[2]


def test_a_problem_of_handles_is_that_of_the_sweep(
    library: Library, files: Callable[[str, np.ndarray], bytes]
) -> None:
    problem = two_rollers(library, files)
    motion = np.asfortranarray(np.vstack([ANGLES.reshape(2, 2).T, np.zeros((2, 2))]))
    swept = _core.flankload_sweep_mesh(
        *(int(mesh_record(0.0)[4]), motion, np.array([3.6e4]), mesh_record(0.0)),
        *(roller(), roller(), 11, np.zeros(2, np.intc), np.empty(0, np.intc), np.empty(0)),
        *(np.empty(0, np.intc), np.zeros((2, 1), np.intc, "F"), np.zeros((2, 1), np.intc, "F")),
    )
    assert swept[-1] == 0
    for one in (problem, built_rollers(library)):
        np.testing.assert_array_equal(rotations(library, one), swept[1][:, 0])
    # the pairs of all states, with room for more than at first
    library.call("keep_pairs", problem, 1)
    found = library.call("solve", problem)
    n_pairs, n_columns = ctypes.c_int(), ctypes.c_int()
    library.call("get_pair_sizes", found, ctypes.byref(n_pairs), ctypes.byref(n_columns))
    counts, first = np.zeros((2, 2), np.intc)
    table = np.zeros((n_pairs.value, n_columns.value))
    library.call("get_n_pairs", found, counts)
    library.call("get_first_pair", found, first)
    library.call("get_pair_table", found, table)
    np.testing.assert_array_equal(counts, swept[4][7, :, 0])
    assert table.shape == (counts.sum(), 11)
    # threads store the pairs of states in the order in which they end
    for k in range(2):
        forces = table[first[k] - 1 :][: counts[k], 7]
        np.testing.assert_allclose(forces.sum(), swept[5][:, k, 0].sum(), rtol=1e-12)


def test_an_error_names_procedure_argument_expected_and_found(
    library: Library, files: Callable[[str, np.ndarray], bytes]
) -> None:
    """After an error, procedures do nothing and return null pointers."""
    problem = two_rollers(library, files)
    body = library.call("read_body", files("roller", roller()))
    cases: list[tuple[str, tuple[Any, ...], str]] = [
        ("new_mesh", (0, 90.0), "n_sites: expected 1 or more, found 0"),
        ("read_body", (b"nowhere",), "name: expected a file, found 'nowhere'"),
        ("set_body_sites", (body, 1, np.zeros(1), np.zeros(1)), "body: expected no sites yet"),
        ("set_body_sites", (None, 1, None, None), "body: expected a handle, found a null pointer"),
        ("set_body_part", (body, 2, 1, np.ones(1)), "n_values: expected 2, found 1"),
        ("add_body", (problem, None), "body: expected a handle, found a null pointer"),
        ("set_mesh_cells", (None, 1.0, 1.0, 1.0), "mesh: expected a handle, found a null"),
        ("set_loads", (problem, 0, np.ones(1)), "n_cases: expected 1 or more, found 0"),
        ("get_motion", (None, None), "result: expected a handle, found a null pointer"),
    ]
    for name, arguments, words in cases:
        found = library.call(name, *arguments)
        if f"flankload_{name}" in MAKERS:
            assert found.value is None
        assert library.core.flankload_check_error(library.error) < 0
        assert library.call("add_body", problem, body) == 0
        assert library.message().startswith(f"flankload_{name}: {words}")
        assert library.core.flankload_check_error(library.error) == 0
    library.call("add_motion", problem, 1, 3, 3, 1)
    assert not library.call("solve", problem).value
    expected = "flankload_solve: motions: expected bodies from 1 to 2"
    assert library.message().startswith(expected)


def test_handles_are_deleted_twice(library: Library) -> None:
    core = library.core
    for kind, handle in (
        ("mesh", library.call("new_mesh", 1, 90.0)),
        ("problem", library.call("new_problem")),
        ("error", ctypes.c_void_p(core.flankload_new_error())),
    ):
        assert handle.value
        for _ in range(2):
            getattr(core, f"flankload_delete_{kind}")(ctypes.byref(handle))
            assert not handle.value
    core.flankload_delete_body(ctypes.byref(ctypes.c_void_p()))
    core.flankload_delete_result(ctypes.byref(ctypes.c_void_p()))


def test_threads_have_handles_of_their_own(prefix: Path) -> None:
    """Each with its own error: half of them have a problem that is invalid."""
    alone = rotations(Library(prefix), built_rollers(Library(prefix)))
    found: dict[int, Any] = {}

    def work(k: int) -> None:
        library = Library(prefix)
        problem = built_rollers(library)
        for _ in range(20):
            if k % 2:
                library.call("new_mesh", -k, 90.0)
                found[k] = library.message()
            else:
                found[k] = rotations(library, problem)

    threads = [Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in (1, 3):
        assert found[k] == f"flankload_new_mesh: n_sites: expected 1 or more, found -{k}"
        np.testing.assert_array_equal(found[k - 1], alone)


def test_the_headers_suit_c_plus_plus(prefix: Path, tmp_path: Path) -> None:
    text = "#include <flankload.h>\n#include <flankload_handles.h>\n"
    text += (
        "int main() { flankload_error e = flankload_new_error(); flankload_delete_error(&e); }\n"
    )
    (tmp_path / "own.cpp").write_text(text, encoding="ascii")
    include = f"-I{prefix / 'include' / 'flankload'}"
    options = ["-fsyntax-only", "-Wall", "-Wextra", "-pedantic", "-Werror", include]
    subprocess.run(["g++", *options, tmp_path / "own.cpp"], check=True)
