"""A row of the table of effects: what calls for it, what it adds to a run, how that shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from flankload.scene import Scene

#: How the size of an effect is found before the run: the same pair with another compliance, with
#: other gaps, with other places of contact, with other levers; by a law, from how far apart nodes
#: stand; or it changes no state at all.
SizeBy = Literal["compliance", "gaps", "places", "levers", "spacing", "nothing"]


@dataclass(frozen=True)
class Switch:
    """Whether a scene calls for an effect, and because of what.

    Attributes
    ----------
    on : bool
    because : str
        The key that says so, with its value; or what holds without a key.
    named : bool
        The scene names the key.
    """

    on: bool
    because: str
    named: bool


@dataclass(frozen=True)
class Work:
    """What an effect adds to a run, in units of what is there without it; negative: saves.

    Attributes
    ----------
    factorisations, growth_loads : float
        Of each body with finite elements; load cases that stand for the body's own forces.
    normal_loads, tangential_loads, coast_readings : float
        For each pressure mode of each loaded flank.
    recoveries : float
        For each place in the root fillets of a tooth.
    columns : float
        Influence columns, for each of the contact pairs of a position under a torque.
    solves : float
        Contact problems, for each position under a torque.
    """

    factorisations: float = 0
    growth_loads: float = 0
    normal_loads: float = 0
    tangential_loads: float = 0
    coast_readings: float = 0
    recoveries: float = 0
    columns: float = 0
    solves: float = 0


@dataclass(frozen=True)
class Effect:
    """A row of the table.

    Attributes
    ----------
    name : str
        Field of `Effects`.
    title : str
    keys : tuple of str
        What calls for it; "body_*" is either body.
    switch : callable
        Scene to Switch.
    stages : tuple of str
        Stages of the run that do its work, as `result.cost["stages"]` names them.
    work : Work
    counters : tuple of str
        Counters of `result.cost` that are 0 or absent without it.
    size_by : SizeBy
    excludes : tuple of str
        Effects that do not go with it; a scene with both is refused, and the error names both keys.
    of_teeth : bool
        Only bodies with teeth know it; a cam and its follower do not.
    coarser : bool
        With it less is computed than without: what it changes is an error.
    """

    name: str
    title: str
    keys: tuple[str, ...]
    switch: Callable[[Scene], Switch]
    stages: tuple[str, ...]
    work: Work = Work()
    counters: tuple[str, ...] = ()
    size_by: SizeBy = "nothing"
    excludes: tuple[str, ...] = ()
    of_teeth: bool = False
    coarser: bool = False
