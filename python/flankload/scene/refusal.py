"""The error line of an invalid key, with the expected and the found value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import date, time
from numbers import Real
from pathlib import Path
from typing import NoReturn

from flankload.errors import SceneError


def shown(value: object) -> str:
    """A value as in a scene file, shortened to one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        text = f"'{value}'"
    elif isinstance(value, Mapping):
        text = "a table"
    elif isinstance(value, Sequence):
        text = f"[{', '.join(shown(item) for item in value[:6])}{', ...' * (len(value) > 6)}]"
    elif isinstance(value, Real):
        text = f"{value}"
    else:
        text = str(value) if isinstance(value, date | time) else repr(value)
    text = " ".join(text.split())
    return text if len(text) <= 80 else text[:77] + "..."


@contextmanager
def in_file(path: str | Path | None) -> Iterator[None]:
    """Add the file to errors that name none."""
    try:
        yield
    except SceneError as error:
        if path is None or error.file is not None:
            raise
        raise error.with_file(path) from None


def refuse_absent(key: str, name: str, wanted: str, beside: str) -> NoReturn:
    """Refuse the table `key`, which lacks the key `name` that its key `beside` requires."""
    refuse(f"{key}.{name}", f"{wanted}, since there is a {key}.{beside}", None)


def refuse(key: str, expected: str, found: object, file: str | Path | None = None) -> NoReturn:
    """Refuse the key with the dotted path `key`, of a file if one is given.

    A string `found` is printed unchanged, any other value as in a scene file; None: "nothing".

    Raises
    ------
    SceneError
    """
    if not isinstance(found, str):
        found = "nothing" if found is None else shown(found)
    raise SceneError(key=key, expected=expected, found=found, file=file)
