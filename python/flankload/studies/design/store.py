"""Store of finished runs: one SQLite file, a row per run."""

from __future__ import annotations

import json
import sqlite3
from contextlib import contextmanager, suppress
from functools import cache, lru_cache
from hashlib import sha256
from importlib.metadata import version as installed_version
from typing import TYPE_CHECKING, Any, NoReturn

from flankload.base.digest import digest_of
from flankload.scene.refusal import refuse
from flankload.studies.design.run import SOLVED, Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from flankload.scene import Scene

#: Number in the head of an SQLite file ("FLNK") and version of the table.
APPLICATION, FORMAT = 0x464C4E4B, 3
#: Errors of SQLite that say nothing about the content: permission, busy, locked, memory, read-only,
#: interrupted, input and output, full, cannot open, protocol, no large files, authorization.
OF_SYSTEM = (3, 5, 6, 7, 8, 9, 10, 13, 14, 15, 22, 23)
#: Seconds for which a write waits until other processes have finished theirs.
PATIENCE_S = 60.0
TABLE = """
CREATE TABLE IF NOT EXISTS runs (
    key TEXT PRIMARY KEY,
    version TEXT NOT NULL,
    variables TEXT NOT NULL,
    status TEXT NOT NULL,
    seconds REAL NOT NULL,
    error TEXT,
    results TEXT NOT NULL,
    digest TEXT NOT NULL,
    finished TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP
)
"""


def key_of(scene: Scene) -> str:
    """Key of a run: digest of the complete scene without its name, its files, and the version."""
    named = (sorted(scene.named_effects), sorted(scene.named_discretization_keys))
    files = {
        key: _content(str(path), path.stat().st_mtime_ns, path.stat().st_size)
        for key, path in sorted(scene.files.items())
        if path.is_file()
    }
    return digest_of((version(), scene.tables, named, files)).hex()


def key_of_refused(scene: Scene, changes: Mapping[str, Any]) -> str:
    """Key of a design that is not a scene, so that it has no digest of its own."""
    text = json.dumps(dict(changes), sort_keys=True, default=repr)
    return digest_of((key_of(scene), text)).hex()


@cache
def version() -> str:
    """Return the version of the program."""
    return installed_version("flankload")


@lru_cache(maxsize=64)
def _content(path: str, _mtime_ns: int, _size: int) -> str:
    """Digest of the content of a file, read again if its time or size changes."""
    with open(path, "rb") as stream:
        return sha256(stream.read()).hexdigest()


class Store:
    """Finished runs in a file, or in memory for the duration of a study (no path).

    Several processes may use one file: it is in WAL mode, and each run is written at once. A
    process that is killed loses nothing that was written.

    Raises SceneError if the path is not a store of this format or damaged, OSError if it cannot be
    written. Each run has its digest, so that no changed byte becomes a number of a study.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        if path is not None and not path.parent.is_dir():
            refuse("store", "a file in a folder that exists", f"no folder {path.parent}")
        with self._errors():
            self._db = sqlite3.connect(path or ":memory:", timeout=PATIENCE_S)
        try:
            with self._errors():
                self._open()
        except BaseException:
            self._db.close()
            raise

    @property
    def is_file(self) -> bool:
        """Whether later studies find the runs."""
        return self._path is not None

    def _open(self) -> None:
        """Create the table in a new file; refuse a file of another kind."""
        try:
            found = [
                self._db.execute(f"PRAGMA {name}").fetchone()[0]
                for name in ("application_id", "user_version", "schema_version")
            ]
        except sqlite3.OperationalError:
            raise
        except sqlite3.DatabaseError:
            found = [None, None, None]
        if found[:2] != [APPLICATION, FORMAT]:
            if found != [0, 0, 0]:  # not an empty file
                expected = "a store of design studies of this version, or no file yet"
                refuse("store", expected, f"{self._path}, which is another file")
            # the order lets two processes create it at once: the numbers come last
            self._db.execute("PRAGMA journal_mode = WAL")
            with self._db:
                self._db.execute("BEGIN IMMEDIATE")
                self._db.execute(TABLE)
                self._db.execute(f"PRAGMA application_id = {APPLICATION}")
                self._db.execute(f"PRAGMA user_version = {FORMAT}")
        self._db.execute("PRAGMA synchronous = NORMAL")

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Name the file in errors of the database, such as a full disk or a damaged file."""
        try:
            yield
        except sqlite3.ProgrammingError:
            raise
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
            code = getattr(error, "sqlite_errorcode", 0)
            if code & 0xFF in OF_SYSTEM:
                raise OSError(code, str(error), str(self._path)) from None
            self._refuse_damaged(str(error))

    def _refuse_damaged(self, found: str) -> NoReturn:
        expected = "an undamaged file; after it is deleted, all designs are solved again"
        refuse("store", expected, f"{self._path}: {found}")

    def find(self, key: str) -> Outcome | None:
        """Outcome of a run, if it is there."""
        with self._errors():
            row = self._db.execute(
                "SELECT status, seconds, error, results, digest FROM runs WHERE key = ?", (key,)
            ).fetchone()
        if row is None:
            return None
        if row[-1] != _digest(key, *row[:-1]):
            self._refuse_damaged("a run that has changed since it was written")
        status, seconds, error, results, _ = row
        return Outcome(status, seconds, error, tuple(json.loads(results)))

    def add(self, key: str, values: Mapping[str, Any], outcome: Outcome) -> None:
        """Write a run; it replaces an earlier one with fewer quantities."""
        texts = [json.dumps(part, default=repr) for part in (dict(values), outcome.results)]
        run = (outcome.status, float(outcome.seconds), outcome.error, texts[1])
        row = (key, version(), texts[0], *run, _digest(key, *run))
        columns = "key, version, variables, status, seconds, error, results, digest"
        with self._errors(), self._db:
            self._db.execute(
                f"INSERT OR REPLACE INTO runs ({columns}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)", row
            )

    def close(self) -> None:
        """Close the file."""
        with suppress(sqlite3.DatabaseError):  # of a damaged file, which is refused elsewhere
            self._db.close()


def _digest(*run: object) -> str:
    """Digest of a run: key, status, seconds, error and results as text."""
    return digest_of(run).hex()


def names_in(outcome: Outcome) -> set[str]:
    """Names of the quantities of a run."""
    if outcome.status != SOLVED:
        return set()
    return {name for row in outcome.results for name in row["quantities"]}
