"""Mesh and compliance files damaged at random are read or refused, in bounded time and memory."""

from __future__ import annotations

import resource
import tempfile
import tomllib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import flankload as fl
from flankload.base.array_archive import archive_of
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.meshes.defects import find_defects
from flankload.meshes.io import read_mesh, write_mesh
from flankload.meshes.plane_mesh import boundary_edges, raise_to_quadratic
from flankload.meshes.report import hints, mesh_rows, set_rows
from tests.support.finer_solutions import TooLongError, at_most
from tests.support.paths import EXAMPLES, MESHES, TEST_MESHES
from tests.support.tally import Tally

FILES = (
    *sorted(TEST_MESHES.iterdir()),
    *sorted(MESHES.iterdir()),
    *sorted((EXAMPLES / "compliance").iterdir()),
)
#: Scenes in which a file may be body 1.
SCENES = {
    "fzg_c_pinion.msh": "external_gear_mesh.toml",
    "toothed_sector.inp": "toothed_sector.toml",
    "fzg_c_pinion.npz": "external_gear_compliance.toml",
}
#: What none of these small files may take.
MOST_CPU_S, MOST_BYTES = 20.0, 2 * 2**30
WORDS = (b"nan", b"inf", b"-1", b"0", b"999999999", b"1e300", b"99999999999999999999", b"x", b"")


def fuzz_meshes(seed: int, count: int) -> Tally:
    """Damage so many files.

    Parameters
    ----------
    seed : int
    count : int

    Returns
    -------
    Tally
        wrong: too long, too much memory, an error of several lines; silent: a coordinate that is
        no number was accepted.
    """
    tally = Tally("meshes")
    with tempfile.TemporaryDirectory() as folder:
        for k in range(count):
            rng = np.random.default_rng([seed, k])
            path, why = _damaged(rng, Path(folder))
            place = f"seed [{seed}, {k}] {path.name}"
            tally.tried += 1
            try:
                with warnings.catch_warnings(), _little_memory(), at_most(MOST_CPU_S):
                    warnings.simplefilter("error")
                    _read(path)
                if why is not None:
                    tally.fault("silent", f"{place}: {why}")
            except SceneError as error:
                if "\n" in str(error) or not error.expected or not error.found:
                    tally.fault("wrong", f"{place}: {str(error)[:200]!r}")
            except TooLongError:
                tally.fault("wrong", f"{place}: more than {MOST_CPU_S:g} s")
            except MemoryError:
                tally.fault("wrong", f"{place}: more than {MOST_BYTES / 2**30:g} GiB")
            except Exception as error:
                tally.fault("traceback", f"{place}: {type(error).__name__}: {str(error)[:120]}")
    return tally


def _read(path: Path) -> None:
    """Read a mesh as `flankload check` does, then as body 1 of a scene."""
    if path.suffix != ".npz":
        mesh = read_mesh(path)
        list(find_defects(mesh))
        mesh_rows(mesh)
        set_rows(mesh)
        hints(mesh)
    name = SCENES.get(path.name)
    if name is not None:
        tree = tomllib.loads((EXAMPLES / "scenes" / name).read_text(encoding="utf-8"))
        if "file" in tree["body_2"]:
            tree["body_2"]["file"] = str((EXAMPLES / "scenes" / tree["body_2"]["file"]).resolve())
        tree["body_1"]["file"] = str(path)
        build_bodies(fl.Scene.from_dict(tree))


@contextmanager
def _little_memory() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + MOST_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def _damaged(rng: np.random.Generator, folder: Path) -> tuple[Path, str | None]:
    """A damaged copy of a file and, where it must be refused in any case, why."""
    source = FILES[rng.integers(len(FILES))]
    path = folder / source.name
    if source.suffix == ".npz" and rng.random() < 0.7:
        path.write_bytes(archive_of(_other_arrays(source, rng)))
        return path, None
    data, why = source.read_bytes(), None
    if source.suffix == ".msh" and rng.random() < 0.15:
        path = path.with_suffix(".vtu")
        data = _as_vtu(source, path)
    text = b"\x00" not in data
    for _ in range(rng.integers(1, 4)):
        change = _change_text if text and rng.random() < 0.7 else _change_bytes
        data = change(data, rng)
    if text and path.suffix in (".msh", ".inp") and rng.random() < 0.1:
        data = _with_nan(source.read_bytes(), rng)
        why = "a coordinate that is no number"
    path.write_bytes(data)
    return path, why


def _change_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes flipped, cut out, doubled, or the rest left out."""
    if not data:
        return data
    low, high = sorted(rng.integers(0, len(data), 2).tolist())
    match rng.integers(4):
        case 0:
            changed = bytearray(data)
            for place in rng.integers(0, len(data), rng.integers(1, 30)):
                changed[place] = rng.integers(256)
            return bytes(changed)
        case 1:
            return data[:low] + data[min(high, low + 200) :]
        case 2:
            return data[:high] + data[low:]
    return data[:low]


def _change_text(data: bytes, rng: np.random.Generator) -> bytes:
    """Lines dropped, doubled, exchanged; words replaced or exchanged; sets renamed."""
    lines = data.split(b"\n")
    a, b = rng.integers(0, len(lines), 2).tolist()
    match rng.integers(7):
        case 0:
            del lines[a : a + int(rng.integers(1, 20))]
        case 1:
            lines.insert(a, lines[b])
        case 2:
            lines[a], lines[b] = lines[b], lines[a]
        case 3 | 4:
            lines[a] = _other_word(lines[a], rng)
        case 5:
            a = _head(lines, rng)
            lines[a] = _other_word(lines[a], rng)
        case 6:
            return data.replace(b"FLANK", b"" if rng.random() < 0.5 else b"BORE")
    return b"\n".join(lines)


def _head(lines: list[bytes], rng: np.random.Generator) -> int:
    """A line that counts or names what follows: where damage is felt most."""
    marks = [k for k, line in enumerate(lines) if line[:1] in (b"$", b"*")]
    near = [min(k + 1, len(lines) - 1) for k in marks]
    places = marks + near
    return places[rng.integers(len(places))] if places else 0


def _other_word(line: bytes, rng: np.random.Generator) -> bytes:
    separator = b"," if b"," in line else b" "
    words = line.split(separator)
    a, b = rng.integers(0, len(words), 2).tolist()
    if rng.random() < 0.3:
        words[a], words[b] = words[b], words[a]
    else:
        words[a] = WORDS[rng.integers(len(WORDS))]
    return separator.join(words)


def _with_nan(data: bytes, rng: np.random.Generator) -> bytes:
    """The file with a coordinate of a node that is no number."""
    lines = data.split(b"\n")
    separator = b"," if b"*NODE" in data else b" "
    nodes = [
        k
        for k, line in enumerate(lines)
        if line.count(b".") >= 2 and len(line.split(separator)) in (3, 4)
    ]
    k = nodes[rng.integers(len(nodes))]
    words = lines[k].split(separator)
    words[-2 if len(words) == 4 else -3] = b"nan"
    lines[k] = separator.join(words)
    return b"\n".join(lines)


def _as_vtu(source: Path, path: Path) -> bytes:
    mesh = read_mesh(source)
    nodes, cells = raise_to_quadratic(mesh.nodes, mesh.cells)
    write_mesh(path, nodes, cells, {"EDGE": boundary_edges(cells)})
    return path.read_bytes()


def _other_arrays(source: Path, rng: np.random.Generator) -> dict[str, Any]:
    """Arrays of a compliance file, some of them other ones."""
    with np.load(source) as archive:
        arrays = {name: archive[name] for name in archive.files}
    for _ in range(rng.integers(1, 3)):
        name = list(arrays)[rng.integers(len(arrays))]
        value = arrays[name]
        match rng.integers(6):
            case 0:
                del arrays[name]
            case 1 if value.dtype.kind in "fi" and value.size:
                flat = value.astype(float).ravel()
                factor = rng.choice([0.0, -1.0, 1 + 1e-9, 10.0, 1e9, 1e300, np.nan])
                with np.errstate(all="ignore"):
                    flat[rng.integers(flat.size)] *= factor
                arrays[name] = flat.reshape(value.shape)
            case 2 if value.dtype.kind in "fi":
                with np.errstate(all="ignore"):
                    arrays[name] = value * rng.choice([0.0, -1.0, 0.5, 2.0, 1e6, 1e300])
            case 3 if value.ndim:
                arrays[name] = value[: rng.integers(len(value) + 1)]
            case 4:
                arrays[name] = np.array(["gear", "x", "日本語"][rng.integers(3)])
            case _:
                arrays[name] = value[None] if rng.random() < 0.5 else value.astype(str)
    return arrays
