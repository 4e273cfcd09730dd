"""Runs the snippets of a documentation page, in their order, in one folder."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Iterator
from doctest import ELLIPSIS, OutputChecker
from pathlib import Path
from typing import NamedTuple

from flankload.cli import main

#: A fenced block with its language, and the block without language behind it, which is its output.
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```\n(?:\n```\n(.*?)^```\n)?", re.MULTILINE | re.DOTALL)
FILE_NAME = re.compile(r"# ([\w-]+\.toml)\n")


class Output(NamedTuple):
    """Output of a snippet, and that of the page; "..." in the page is any text."""

    code: str
    printed: str
    shown: str

    @property
    def agrees(self) -> bool:
        """Whether the page shows the output."""
        return OutputChecker().check_output(self.shown, self.printed, ELLIPSIS)


def outputs_of(page: Path) -> Iterator[Output]:
    """Run a page in the current folder.

    Blocks in `python` share their names; a block in `toml` is written to the file that its first
    line names; lines of a block in `console` that begin with `$ flankload` are run.

    Parameters
    ----------
    page : Path

    Yields
    ------
    Output
        Of each block in `python` and each command.

    Raises
    ------
    ValueError
        At a block that is none of these.
    """
    names: dict[str, object] = {}
    for language, code, shown in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            yield Output(code, printed_by(lambda code=code: exec(code, names)), shown)
        elif language == "console":
            for command in re.split(r"^\$ ", code, flags=re.MULTILINE)[1:]:
                line, expected = command.split("\n", 1)
                program, *arguments = shlex.split(line)
                if program != "flankload":
                    raise ValueError(f"{page}: expected a command of flankload, found {line}")
                yield Output(line, printed_by(lambda a=arguments: main(a)), expected)
        elif language == "toml" and (file := FILE_NAME.match(code)):
            Path(file[1]).write_text(code, encoding="utf-8")
        elif language != "geo":
            raise ValueError(f"{page}: a block of {language} that no test runs: {code[:40]}")


def printed_by(run: object) -> str:
    """Standard output and standard error of a call."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        run()  # type: ignore[operator]
    return out.getvalue()
