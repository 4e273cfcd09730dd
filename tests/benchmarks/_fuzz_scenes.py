"""Scenes spoiled at random are solved or refused in one line; solutions balance their torque."""

from __future__ import annotations

import warnings

import numpy as np

import flankload as fl
from flankload.errors import FlankloadError, SceneError
from flankload.mechanisms import mechanism_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.studies.tolerance import first_scene
from tests.support.balance import imbalance
from tests.support.finer_solutions import TooLongError, at_most
from tests.support.spoiled_scenes import Tree, spoiled
from tests.support.tally import Tally

#: A scene may ask for more than is worth waiting for: then it is no trial.
MOST_CPU_S = 10.0
#: Of the sum of the moments' sizes.
BALANCE = 1e-12
#: One scene in so many is planned, too.
PLANNED = 8
#: The longest line that makes sense, but for names of files.
LONGEST_LINE = 600


def fuzz_scenes(seed: int, count: int) -> Tally:
    """Spoil so many scenes.

    Parameters
    ----------
    seed : int
    count : int

    Returns
    -------
    Tally
        wrong: a result that is not finite, pulls or does not balance, an error of several lines;
        silent: what must be refused was not.
    """
    tally = Tally("scenes")
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        tree, why = spoiled(rng)
        try:
            with warnings.catch_warnings(), at_most(MOST_CPU_S):
                warnings.simplefilter("error")
                _try(tally, tree, why, f"seed [{seed}, {k}]", plan=rng.integers(PLANNED) == 0)
        except TooLongError:
            continue
        tally.tried += 1
    return tally


def _try(tally: Tally, tree: Tree, why: str | None, place: str, *, plan: bool) -> None:
    try:
        scene = fl.Scene.from_dict(tree)
        if why is not None:
            tally.fault("silent", f"{place}: {why[:80]}")
            return
        _check(scene)
        if plan:
            fl.plan(scene)
        found = fl.solve(scene)
        for result in found.by_torque:
            for fault in faults_of(result):
                tally.fault("wrong", f"{place}: {fault}")
    except FlankloadError as error:
        line = str(error)
        named = not isinstance(error, SceneError) or (error.key and error.expected and error.found)
        if "\n" in line or not named or len(line) > LONGEST_LINE + 5000 * ("aaaa" in line):
            tally.fault("wrong", f"{place}: {line[:200]!r}")
    except TooLongError:
        raise
    except Exception as error:
        tally.fault("traceback", f"{place}: {type(error).__name__}: {str(error)[:120]}")


def _check(scene: fl.Scene) -> None:
    """Check a scene as the command does."""
    if scene.body_2.kind in ("belt", "chain"):
        mechanism_of(scene).describe(scene)
    else:
        build_bodies(first_scene(scene))


def faults_of(result: fl.Result) -> list[str]:
    """Properties that no result of any scene may have."""
    faults = []
    for name in ("rotation_rad", "site_force_N", "peak_pressure_MPa", "load_share"):
        if not np.isfinite(getattr(result, name)).all():
            faults.append(f"{name} is not finite")
    if faults:
        return faults
    if (result.site_force_N < 0).any():
        faults.append(f"a force of {result.site_force_N.min():.3g} N")
    total = result.load_share.sum(axis=1)
    loaded = result.site_force_N.sum(axis=1) > 0
    if (np.abs(total[loaded] - 1) > BALANCE).any() or (total[~loaded] != 0).any():
        faults.append("load shares do not add up")
    off = imbalance(result)
    if not off <= BALANCE:
        faults.append(f"moments are off by {off:.2g}")
    return faults
