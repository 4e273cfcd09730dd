"""From a scene that names a tolerance to its results: one run, or one and a tightened one."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol

from flankload.cost import COUNTERS, Account
from flankload.setting import Setting, with_setting
from flankload.steering.bought import bought
from flankload.steering.knobs import knobs_of
from flankload.steering.laws import LAWS, Law, as_told, elements_cost, states_cost, together
from flankload.steering.pick import AIM, Pick, cheapest, first_pick
from flankload.steering.told import told, told_by_source

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, MutableMapping, Sequence

    from flankload.elasticity.compliance import BodyCompliance
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.steering.knobs import Knobs

    Progress = Callable[[str, int, int], None]
    Kept = MutableMapping[int, tuple[BodyCompliance, Account]]

#: Part of the tolerance that adaptive positions are tightened to, and what they cannot fall below.
POSITIONS_AIM, LEAST_DOUBT = 0.4, 1e-5
#: What cannot be met is worth a second run where that leaves no more than this part of it.
MUCH_NEARER = 0.7


class Run(Protocol):
    """A run of a scene, `run_once`."""

    def __call__(
        self, scene: Scene, kept: Kept, progress: Progress | None
    ) -> Result | tuple[Result, ...]:
        """Results of a scene; compliances that it has solved are put into kept."""


def first_scene(scene: Scene) -> Scene:
    """A scene with the knobs that its tolerance begins with; itself where it names none.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Scene
    """
    if not scene.steers:
        return scene
    return _at(scene, first_pick(scene))


def solve_to_tolerance(
    scene: Scene, run: Run, progress: Progress | None = None
) -> Result | tuple[Result, ...]:
    """Results of a scene at the cheapest knobs that meet its tolerance.

    Parameters
    ----------
    scene : Scene
        That names a tolerance.
    run : callable
        Solves a scene whose knobs are named.
    progress : callable, optional
        As of `solve`.

    Returns
    -------
    Result, or a tuple of Results
        With `accuracy`.
    """
    with Account() as steering:
        knobs = knobs_of(scene)
        pick = first_pick(scene, knobs)
    kept: Kept = {}
    tell = _Halves(progress)
    found = _several(run(_at(scene, pick), kept, tell.first))
    extra = {"steering": steering}
    picks, errors = [pick], [told(found)]
    by_source = told_by_source(found)
    if by_source and max(errors[0].values()) > scene.accuracy.tolerance:
        with steering:
            second = _tightened(scene, knobs, pick, found, by_source)
        if second is not None and second.setting != pick.setting:
            same = _elements_of(second) == _elements_of(pick)
            extra["first run"] = _spent(found, without=set(kept) if same else set())
            picks.append(second)
            found = _several(run(_at(scene, second), kept if same else {}, tell.second))
            errors.append(told(found))
    said = bought(scene, knobs, picks, found, errors, told_by_source(found) or {})
    results = tuple(
        replace(result, accuracy=said, cost=_with_extra(result.cost, extra)) for result in found
    )
    tell.finish()
    return results if scene.has_torque_list else results[0]


def _at(scene: Scene, pick: Pick) -> Scene:
    """The scene with a pick's knobs named: it asks for no steering any more."""
    scene = with_setting(scene, pick.setting)
    return replace(scene, named_knobs=scene.named_knobs - {"accuracy.tolerance"})


def _several(found: Result | tuple[Result, ...]) -> tuple[Result, ...]:
    return found if isinstance(found, tuple) else (found,)


def _elements_of(pick: Pick) -> tuple[float | None, int | None]:
    return pick.setting.flank_element_mm, pick.setting.modes


def _tightened(
    scene: Scene,
    knobs: Knobs,
    done: Pick,
    results: Sequence[Result],
    by_source: Mapping[str, dict[str, float]],
) -> Pick | None:
    """The setting that should meet the tolerance, by what a run has told; None: not worth it."""
    tolerance = scene.accuracy.tolerance
    states = sum(result.position_rad.size for result in results if result.torque_Nm > 0)
    positions = Setting(count=done.setting.count, adaptive=done.setting.adaptive)
    left = max(by_source.get("positions", {}).values(), default=0.0)
    found = told(results)
    beside = together(by_source, found)
    if positions.adaptive is not None and left > POSITIONS_AIM * tolerance:
        part = POSITIONS_AIM * tolerance / left
        doubt = max(LEAST_DOUBT, part * positions.adaptive)
        positions = replace(positions, adaptive=float(f"{doubt:.2g}"))
        less = {name: part * error for name, error in by_source["positions"].items()}
        by_source = {**by_source, "positions": less}
    priced = _priced(LAWS[knobs.kind], results[0], done, states)
    spent = sum(stage["cpu_s"] for stage in results[0].cost["stages"].values())
    done = replace(done, seconds=spent)
    law = as_told(
        priced,
        by_source,
        beside,
        part=done.part,
        modes=done.modes,
        strips=done.strips,
    )
    missed = [quantity for quantity, error in found.items() if error > tolerance]
    for same_elements in (False, True):
        pick = cheapest(
            law,
            knobs,
            tolerance,
            positions=positions,
            states=states,
            done=done,
            same_elements=same_elements,
            aim=AIM,
        )
        if is_worth(pick, missed, found, tolerance):
            return pick
    return None


def is_worth(
    pick: Pick, missed: Collection[str], found: Mapping[str, float], tolerance: float
) -> bool:
    """Whether a finer run is likely to meet some of what is missed, or to come much nearer.

    Parameters
    ----------
    pick : Pick
        Of the finer run.
    missed : collection of str
        Quantities.
    found : mapping of str to float
        Their errors now.
    tolerance : float

    Returns
    -------
    bool
    """
    return any(pick.errors[quantity] <= tolerance for quantity in missed) or all(
        pick.errors[quantity] <= MUCH_NEARER * found[quantity] for quantity in missed
    )


def _priced(law: Law, result: Result, done: Pick, states: int) -> Law:
    """The law with the seconds of a run."""
    stages = {name: stage["cpu_s"] for name, stage in result.cost["stages"].items()}
    elements = sum(s for name, s in stages.items() if name.startswith("compliance"))
    sweeps = sum(stages.get(name, 0.0) for name in ("sweep", "tangent", "estimate"))
    return replace(
        law,
        elements_s=float(elements / elements_cost(done.part, done.modes)),
        state_s=float(sweeps / max(1, states) / states_cost(done.strips)),
    )


def _spent(found: Sequence[Result], *, without: set[int]) -> Account:
    """What a run has spent that is not counted in the next one; which bodies that takes over."""
    account = Account()
    kept = {f"compliance body {z + 1}" for z in without}
    for name, stage in found[0].cost["stages"].items():
        if name not in kept:
            account.wall_s += stage["wall_s"]
            account.cpu_s += stage["cpu_s"]
            account.count(**stage["counters"])
    return account


def _with_extra(cost: Mapping[str, Any], extra: Mapping[str, Account]) -> dict[str, Any]:
    """The cost of a run with what was spent beside it."""
    stages = {name: account.as_dict() | {"predicted": {}} for name, account in extra.items()}
    more = {
        name: cost.get(name, 0) + sum(account.counters.get(name, 0) for account in extra.values())
        for name in COUNTERS
        if name in cost
    }
    return {**cost, **more, "stages": {**stages, **cost["stages"]}}


class _Halves:
    """Progress of two runs as that of one: the second one may not come."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._total = 1
        self.first = None if progress is None else self._first
        self.second = None if progress is None else self._second

    def _first(self, stage: str, done: int, total: int) -> None:
        assert self._progress is not None
        self._total = total
        if done < total:
            self._progress(stage, done, 2 * total)

    def _second(self, stage: str, done: int, total: int) -> None:
        assert self._progress is not None
        if done < total:
            self._progress(stage, self._total + done * self._total // total, 2 * self._total)

    def finish(self) -> None:
        """Both are done."""
        if self._progress is not None:
            self._progress("done", 2 * self._total, 2 * self._total)
