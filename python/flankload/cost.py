"""Cost of a run: seconds, bytes and counted work, by stage.

The code that does the work counts it, in the account of the stage that requested it. The cost of a
result shows predictions beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, is_dataclass
from time import perf_counter, process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import InputError

if TYPE_CHECKING:
    from types import TracebackType

#: All counters, each with the unit that it counts.
COUNTERS = {
    "fe_factorisations": "factorisation of the stiffness of a body",
    "fe_solutions": "column of loads or readings, for any purpose",
    "fe_unknowns": "unknown of the elements of a body",
    "unit_loads_normal": "load case of pressure on a flank",
    "unit_loads_tangential": "load case along a flank",
    "unit_loads_nodal": "load case of a flank that is a force at a node",
    "fe_load_cases_growth": "load case of the expansion of a body",
    "coast_readings": "solution for a load on a coast flank",
    "corner_readings": "load case along a flank for forces that turn over sharp tips alone",
    "bore_reactions": "solution for a reaction on a bore whose mean motion is held",
    "stress_recoveries": "solution for a place of stress in a root fillet",
    "states": "position under a torque",
    "slices": "slice of the face width of a position under a torque",
    "lumped_solutions": "contact problem with one unknown for each place of contact",
    "contact_passes": "contact problem with pairs",
    "finite_solutions": "contact problem with influence coefficients of the previous forces",
    "influence_columns": "column of influence coefficients of normal forces",
    "influence_columns_tangential": "column of influence coefficients of tangential forces",
    "pivots": "pair that joins or leaves the contact",
    "refactorisations": "new factorisation of the pairs in contact",
}


@dataclass
class Account:
    """Cost of a stage; counters with the value zero are omitted.

    Attributes
    ----------
    wall_s, cpu_s : float
    bytes : int
        Arrays held or returned at the end of the stage.
    workspace_bytes : int
        Largest temporary arrays, if known.
    counters : dict of str to int
        By the names of `COUNTERS`, without zeros.
    on_part : callable or None
        Called with the part of the work that is done, from 0 to 1, where it is known.
    """

    wall_s: float = 0.0
    cpu_s: float = 0.0
    bytes: int = 0
    workspace_bytes: int = 0
    counters: dict[str, int] = field(default_factory=dict)
    on_part: Callable[[float], None] | None = field(default=None, repr=False, compare=False)

    def report(self, part: float) -> None:
        """Report the part of the work that is done."""
        if self.on_part is not None:
            self.on_part(part)

    def count(self, **numbers: int) -> None:
        """Add to counters."""
        for name, number in numbers.items():
            if name not in COUNTERS:
                raise KeyError(name)
            if number:
                self.counters[name] = self.counters.get(name, 0) + int(number)

    def __enter__(self) -> Account:
        self._began = (perf_counter(), process_time())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        self.wall_s += perf_counter() - self._began[0]
        self.cpu_s += process_time() - self._began[1]

    def as_dict(self) -> dict[str, Any]:
        """The account in the form of the result."""
        return {
            "wall_s": self.wall_s,
            "cpu_s": self.cpu_s,
            "bytes": self.bytes,
            "workspace_bytes": self.workspace_bytes,
            "counters": dict(self.counters),
        }


def totals(stages: Mapping[str, Account]) -> dict[str, int]:
    """Sum of every counter over all stages, including zeros.

    Parameters
    ----------
    stages : mapping of str to Account

    Returns
    -------
    dict of str to int
    """
    accounts = stages.values()
    return {name: sum(account.counters.get(name, 0) for account in accounts) for name in COUNTERS}


def beside_plan(
    counted: Mapping[str, Mapping[str, int]],
    guessed: Mapping[str, Mapping[str, Any]] | None = None,
) -> dict[str, dict[str, Any]]:
    """Predictions of a run, for its cost.

    Parameters
    ----------
    counted : mapping of str to mapping
        Exact counters by stage.
    guessed : mapping of str to mapping, optional
        Seconds, bytes and all counters by stage, from a plan of the scene.

    Returns
    -------
    dict of str to dict
        "counters" and the other predictions by stage; "bytes" of a stage may be among its counts.

    Raises
    ------
    InputError
        If the plan belongs to another scene: its counts contradict the known ones.
    """
    found: dict[str, dict[str, Any]] = {}
    for stage, known in counted.items():
        plan = (guessed or {}).get(stage, {})
        counters = plan.get("counters", {})
        known = dict(known)
        exact = {"bytes": known.pop("bytes")} if "bytes" in known else {}
        for name, number in known.items():
            if guessed is not None and counters.get(name, 0) != number:
                raise InputError(
                    f"plan: expected a plan of this scene, {number} {name} in the stage {stage}, "
                    f"found {counters.get(name, 0)}"
                )
        found[stage] = {**plan, **exact, "counters": {**counters, **known}}
    return found


#: Types that hold no array.
PLAIN = (str, float, int)


def held_bytes(*things: object) -> int:
    """Bytes of all distinct arrays in objects: in dataclasses, sequences and mappings.

    Parameters
    ----------
    *things : object

    Returns
    -------
    int
        A view counts as the array that owns its memory; an object with `nbytes` counts as that
        value.
    """
    owners: dict[int, int] = {}
    left, seen = list(things), set()
    while left:
        thing = left.pop()
        if thing is None or isinstance(thing, PLAIN) or id(thing) in seen:
            continue
        seen.add(id(thing))
        if isinstance(thing, np.ndarray):
            while isinstance(thing.base, np.ndarray):
                thing = thing.base
            owners[id(thing)] = thing.nbytes
        elif is_dataclass(thing):
            held = getattr(thing, "nbytes", None)
            if held is None:
                left += [getattr(thing, name) for name in thing.__dataclass_fields__]
            else:
                owners[id(thing)] = held
        elif isinstance(thing, Mapping):
            left += thing.values()
        elif isinstance(thing, list | tuple):
            left += thing
    return sum(owners.values())
