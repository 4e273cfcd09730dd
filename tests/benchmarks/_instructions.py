"""Instructions of calls of the core, procedure by procedure (valgrind's callgrind).

A process of its own replays calls whose arguments were taken down, each twice: the first time the
linker and the libraries make themselves ready. Only what happens between entry and return of the
interface is counted, so that the numbers depend on arguments, compiler and processor type alone.
"""

from __future__ import annotations

import importlib.util
import os
import pickle
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

INTERFACE = "flankload_sweep_mesh"
#: Each call is made so often; the first makes libraries ready, of the others the least counts.
TIMES = 4
#: What finds and gives back memory does so in as many steps as what was asked for before has left
#: it to do: not counted.
ALLOCATOR = re.compile(
    r"^_?_?(int_)?(libc_)?(malloc|free|calloc|realloc|memalign|sbrk|brk|systrim|sysmalloc|"
    r"unlink_chunk|alloc_perturb|glibc_morecore|munmap|mmap|mem2chunk_check|malloc_consolidate)"
)
#: A line of costs: a place in the source, absolute or relative to the line before, and a number.
COST = re.compile(r"^[+\-*]?\d* ?(\d+)$")
NAMED = re.compile(r"^(c?)fn=\((\d+)\)(?: (.*))?$")


@dataclass(frozen=True)
class Counted:
    """Instructions of a call.

    Attributes
    ----------
    own : Counter
        By procedures, in each alone; without those that find memory.
    within : Counter
        By caller and called procedure, with all that the latter calls.
    """

    own: Counter[str]
    within: Counter[tuple[str, str]]

    @property
    def whole(self) -> int:
        """Instructions of the whole call."""
        return sum(self.own.values())


def has_valgrind() -> bool:
    """Whether the program is here."""
    return shutil.which("valgrind") is not None


def count_instructions(core: Path, calls: Sequence[dict[str, Any]]) -> list[Counted]:
    """Instructions of calls of a core.

    Parameters
    ----------
    core : Path
        The extension module.
    calls : sequence of dict
        Arguments of the interface by name; a core that does not know one is called without it.

    Returns
    -------
    list of Counted, one per call
    """
    with TemporaryDirectory() as folder:
        arguments = Path(folder) / "calls"
        arguments.write_bytes(pickle.dumps([call for call in calls for _ in range(TIMES)]))
        profile = Path(folder) / "profile"
        command = [
            *("valgrind", "--quiet", "--tool=callgrind", f"--callgrind-out-file={profile}"),
            *(f"--toggle-collect={INTERFACE}_", f"--dump-after={INTERFACE}_", "--compress-pos=no"),
            *(sys.executable, __file__, str(core), str(arguments)),
        ]
        one = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        subprocess.run(command, check=True, capture_output=True, env={**os.environ, **one})
        profiles = [
            read_profile(Path(f"{profile}.{k + 1}").read_text(encoding="utf-8"))
            for k in range(TIMES * len(calls))
        ]
    return [
        min(profiles[k * TIMES + 1 : (k + 1) * TIMES], key=lambda counted: counted.whole)
        for k in range(len(calls))
    ]


def read_profile(text: str) -> Counted:
    """Instructions by procedure from what callgrind has written."""
    names: dict[str, str] = {}
    own: Counter[str] = Counter()
    within: Counter[tuple[str, str]] = Counter()
    current, called, in_call = "", "", False
    for line in text.splitlines():
        if match := NAMED.match(line):
            callee, number, name = match.groups()
            if name is not None:
                names[number] = short_name(name)
            if callee:
                called = names[number]
            else:
                current = names[number]
        elif line.startswith("calls="):
            in_call = True
        elif match := COST.match(line):
            cost = int(match.group(1))
            if in_call:
                within[current, called] += cost
            elif not ALLOCATOR.match(current):
                own[current] += cost
            in_call = False
    return Counted(own, within)


def short_name(symbol: str) -> str:
    """Name of a Fortran procedure without its module, and without what the compiler adds."""
    return symbol.split("_MOD_")[-1].split(".")[0].split("'")[0]


def _replay(core: str, path: str) -> None:
    """Make the calls."""
    spec = importlib.util.spec_from_file_location("_core", core)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    interface = getattr(module, INTERFACE)
    names = interface.__doc__.partition("(")[2].partition(")")[0].split(",")
    for call in pickle.loads(Path(path).read_bytes()):
        known = deepcopy({name: call[name] for name in names})
        info = interface(**known)[-1]
        assert info == 0


if __name__ == "__main__":
    _replay(*sys.argv[1:])
