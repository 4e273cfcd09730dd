"""The sections of a .msh file and their numbers, as text or binary."""

from __future__ import annotations

from typing import Any

import numpy as np

from flankload.meshes.io.parts import BadFile

#: Types of numbers in a file.
INT, SIZE, REAL = "i4", "u8", "f8"


class Stream:
    """A file of sections, as text or binary, read number by number."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._at = 0
        self.text = True
        self.section = ""
        self._words: list[bytes] = []
        self._next = 0

    def next_section(self) -> str:
        """Go to the next section and return its name; "" at the end of the file."""
        start = self._content.find(b"$", self._at)
        if start < 0:
            return ""
        self.section = self._line_from(start + 1).decode("ascii", "replace").strip()
        return self.section

    def _line_from(self, start: int) -> bytes:
        end = self._content.find(b"\n", start)
        end = len(self._content) if end < 0 else end
        self._at = min(end + 1, len(self._content))
        return self._content[start:end]

    def lines(self) -> list[str]:
        """Lines of a section that is always text; the stream is then after the section."""
        body = self._content[self._at : self._end()]
        self._skip()
        return body.decode("utf-8", "replace").strip().splitlines()

    def open_numbers(self) -> None:
        """Start reading numbers of the section."""
        if self.text:
            self._words = self._content[self._at : self._end()].split()
            self._next = 0

    def take(self, kind: str, count: int) -> Any:
        """Read the next numbers of the section, (count,)."""
        if self.text:
            words = self._words[self._next : self._next + count]
            self._next += count
            if len(words) < count:
                raise self._cut_off()
            try:
                return np.array(words, dtype=REAL if kind == REAL else np.int64)
            except ValueError:
                raise BadFile(
                    f"numbers in section ${self.section}",
                    " ".join(word.decode("ascii", "replace") for word in words[:8]),
                ) from None
        size = np.dtype(kind).itemsize * count
        part = self._content[self._at : self._at + size]
        if len(part) < size:
            raise self._cut_off()
        self._at += size
        return np.frombuffer(part, dtype=kind)

    def count_line(self) -> int:
        """Read a number on a line of its own in a binary section."""
        line = self._line_from(self._at)
        if not line.strip().isdigit():
            raise self._cut_off()
        return int(line)

    def one(self, kind: str) -> int:
        """Read the next number of the section."""
        return int(self.take(kind, 1)[0])

    def close_numbers(self) -> None:
        """Go past the end of the section."""
        self._skip()

    def _skip(self) -> None:
        self._at = self._end()
        self._line_from(self._at)

    def _end(self) -> int:
        end = self._content.find(b"$End" + self.section.encode(), self._at)
        if end < 0:
            raise self._cut_off()
        return end

    def _cut_off(self) -> BadFile:
        return BadFile("a readable mesh file", f"section ${self.section}, which is cut off")
