"""Faults put into a copy of the sources: ``python -m tests.mutations [WORD …] [--list]``.

Each runs the tests that own its file. Words choose faults whose name has one of them; without a
word all are run. One line a fault; then the survivors. 1 is returned where there are any.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.support.paths import ROOT

from .faults import CORE, FAULTS, Fault

#: Folders that are not copied.
LEFT_OUT = ("build*", ".venv", ".git", "__pycache__", ".*_cache", "dist", "out", "*.so")
#: Beyond this a loop does not end: the fault is seen, s.
LONGEST = 600
#: Nor does one that asks for more memory, bytes.
MOST_MEMORY = 4 * 2**30
CORE_PROGRAMS = ("test_core", "test_slices", "test_cells", "test_meshes", "test_many")


def _limit_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))


class Tree:
    """A copy of the sources, with a build of its own where Fortran files will change."""

    def __init__(self, folder: Path, *, builds: bool) -> None:
        self.top, self.said = folder / "tree", ""
        shutil.copytree(ROOT, self.top, ignore=shutil.ignore_patterns(*LEFT_OUT), symlinks=True)
        self.environment = {
            **os.environ,
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "PYTHONPATH": str(self.top / "python"),
            "PYTHONDONTWRITEBYTECODE": "1",
            # the copy in place of the editable install
            "MESONPY_EDITABLE_SKIP": str(ROOT / "build"),
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
        }
        self.builds = builds
        if builds:
            self._call("meson", "setup", "-Dpython=enabled", "-Dbuildtype=release", "build")
        if not self.build():
            raise SystemExit(f"does not build:\n{self.said}")
        built = self.top if builds else ROOT
        (library,) = (built / "build" / "fortran").glob("_core.*.so")
        (self.top / "python" / "flankload" / library.name).symlink_to(library)

    def _call(self, *command: str) -> bool:
        try:
            done = subprocess.run(
                command,
                cwd=self.top,
                env=self.environment,
                capture_output=True,
                timeout=LONGEST,
                preexec_fn=_limit_memory,
                check=False,
            )
        except subprocess.TimeoutExpired:
            self.said = f"{' '.join(command)}: no end within {LONGEST} s"
            return False
        self.said = done.stdout.decode()[-2000:]
        return done.returncode == 0

    def build(self) -> bool:
        """The Fortran core and its programs, as far as something changed."""
        if not self.builds:
            return True
        programs = [f"tests/fortran/{program}" for program in CORE_PROGRAMS]
        return self._call("ninja", "-C", "build") and self._call("ninja", "-C", "build", *programs)

    def passes(self, owners: tuple[str, ...]) -> bool:
        """Whether all these tests pass."""
        if CORE in owners and not all(
            self._call(f"build/tests/fortran/{program}") for program in CORE_PROGRAMS
        ):
            return False
        files = [owner for owner in owners if owner != CORE]
        pytest = (sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider")
        return not files or self._call(*pytest, *files)

    def is_caught(self, fault: Fault) -> bool:
        """Whether its tests fail with it."""
        path = self.top / fault.file
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace(fault.before, fault.after), encoding="utf-8")
        try:
            # objects of the fault before are built anew, too
            if not self.build():
                raise SystemExit(f"does not build: {fault.name}")
            return not self.passes(fault.owners)
        finally:
            path.write_text(text, encoding="utf-8")


def main(arguments: list[str]) -> int:
    """Run the selected faults."""
    words = [argument for argument in arguments if argument != "--list"]
    faults = [f for f in FAULTS if not words or any(word in f.name for word in words)]
    if "--list" in arguments or not faults:
        print(*(repr(fault.name) for fault in faults), sep="\n")
        return int(not faults)
    survivors = []
    with tempfile.TemporaryDirectory(prefix="flankload_mutate_") as folder:
        tree = Tree(Path(folder), builds=any(fault.file.endswith(".f90") for fault in faults))
        if not tree.passes(tuple(dict.fromkeys(o for fault in faults for o in fault.owners))):
            print(f"tests fail without a fault:\n{tree.said}", file=sys.stderr)
            return 2
        for k, fault in enumerate(faults, start=1):
            start = time.perf_counter()
            caught = tree.is_caught(fault)
            said = "caught  " if caught else "harmless" if fault.harmless else "SURVIVED"
            took = time.perf_counter() - start
            print(f"{k:3}/{len(faults)} {said} {took:5.1f} s  {fault.name!r}", flush=True)
            survivors += [] if caught else [fault]
    print(f"{len(faults) - len(survivors)} of {len(faults)} caught")
    for fault in survivors:
        print(f"survived: {fault.name!r}{fault.harmless and ': harmless, ' + fault.harmless}")
    return int(any(not fault.harmless for fault in survivors))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
