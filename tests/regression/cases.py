"""A case: its input, and the function that computes its quantities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .quantities import Quantity


@dataclass(frozen=True)
class Case:
    """One reference.

    Attributes
    ----------
    inputs : dict
        The solved problem, as data that a reader can use elsewhere.
    provenance : str
        Source of the problem, and other evidence for its answer.
    solve : callable
        Quantities by name: numbers, lists of numbers, or a word.
    known : dict
        The quantities that may come out.
    """

    inputs: dict[str, Any]
    provenance: str
    solve: Callable[[], dict[str, Any]]
    known: dict[str, Quantity] = field(repr=False)
