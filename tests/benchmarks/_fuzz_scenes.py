"""Scenes spoiled at random are solved or refused in one line; solutions balance their torque."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

import flankload as fl
from flankload.errors import FlankloadError, SceneError
from flankload.mechanisms import mechanism_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.studies.tolerance import first_scene
from tests.support.finer_solutions import TooLongError, at_most
from tests.support.spoiled_scenes import Tree, spoiled
from tests.support.tally import Tally

#: A scene may ask for more than is worth waiting for: then it is no trial.
MOST_CPU_S = 10.0
#: Of the sum of the moments' sizes.
BALANCE = 1e-9
#: The same of slices, whose inclination to the section is that at the place of least gap.
SLICE_BALANCE = 1e-5
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
    """As the command does."""
    if scene.body_2.kind in ("belt", "chain"):
        mechanism_of(scene).describe(scene)
    else:
        build_bodies(first_scene(scene))


def faults_of(result: fl.Result) -> list[str]:
    """What cannot be of a result, whatever the scene."""
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
    if not off <= (BALANCE if result.slices is None else SLICE_BALANCE):
        faults.append(f"moments are off by {off:.2g}")
    return faults


def imbalance(result: fl.Result) -> float:
    """Largest sum of all moments on body 1 over the sum of their sizes.

    The forces of a chain's rollers have directions of their own, which are not looked at.
    """
    torque = 1000 * result.torque_Nm
    drive: Any = result.drive
    if drive is not None:
        if drive.name == "chain":
            return 0.0
        forces = np.column_stack([result.site_force_N, drive.land_friction_N])
        parts = np.column_stack(
            [forces * result.reference_radius_mm, -torque * np.ones(len(forces))]
        )
        sizes = np.maximum(np.abs(parts).sum(axis=1), np.finfo(float).tiny)
        return float((np.abs(parts.sum(axis=1)) / sizes).max())
    worst = 0.0
    coast = () if result.coast is None else (result.coast.pair_tables,)
    for tables in zip(result.pair_tables, *coast, strict=True):
        moments = (
            _moments(table, side, _twist(result))
            for table, side in zip(tables, (1, -1), strict=False)
        )
        parts = np.concatenate([[-torque], *moments])
        size = np.abs(parts).sum()
        worst = max(worst, abs(parts.sum()) / size if size > 0 else 0.0)
    return worst


def _twist(result: fl.Result) -> float:
    """Twist of body 1, rad/mm; 0 in a plane scene."""
    slices = result.slices
    return 0.0 if slices is None else slices.tangent_helix_base / result.reference_radius_mm


def _moments(table: Any, side: int, twist: float) -> np.ndarray:
    """Moments of normal and friction forces about the axis of body 1, N mm; side -1: coast flanks.

    Arc length grows from root to tip on both sides of a tooth, friction is positive that way. On a
    helix the normal of a flank leaves the plane of the section.
    """
    along = table.x_mm * table.normal_y - table.y_mm * table.normal_x
    parts = [table.force_N * along / np.hypot(1.0, twist * along)]
    if table.friction_force_N is not None:
        across = table.x_mm * table.normal_x + table.y_mm * table.normal_y
        parts.append(side * table.friction_force_N * across)
    return np.concatenate(parts)
