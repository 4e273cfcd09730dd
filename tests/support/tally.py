"""Findings of a fuzz run, as one line."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Tally:
    """Counts of one kind of trial.

    Attributes
    ----------
    name : str
        Name of the kind.
    tried, wrong, silent, traceback : int
        Trials; wrong results or errors; invalid input accepted silently; exceptions that are not
        the package's own.
    examples : list of str
        How to reproduce the first faults: seed and finding.
    """

    name: str
    tried: int = 0
    wrong: int = 0
    silent: int = 0
    traceback: int = 0
    examples: list[str] = field(default_factory=list)

    def fault(self, kind: str, example: str) -> None:
        """Count a fault of a kind and keep the first ten examples."""
        setattr(self, kind, getattr(self, kind) + 1)
        if len(self.examples) < 10:
            self.examples.append(f"{kind}: {example}")

    def __str__(self) -> str:
        """One line, then a line for each example."""
        counts = f"{self.tried} tried, {self.wrong} wrong, {self.silent} silent"
        return "\n  ".join([f"{self.name}: {counts}, {self.traceback} tracebacks", *self.examples])
