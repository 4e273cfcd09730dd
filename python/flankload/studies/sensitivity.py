"""Derivatives of results with respect to keys of a scene.

For given pairs in contact, the forces and the rotation of a state solve one linear system,
K F = b (phi - g), t . F = T, with coefficients that are smooth functions of every key. A derivative
is the central difference of two such solutions, on cells that follow the contact. As no pair comes
or goes within the step, its error is the square of the step; it agrees with that of the equations,
t . K⁻¹ b dphi = t . K⁻¹ dr and K dF = b dphi - dr, in which dr is the change of the residual.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.arguments import require
from flankload.base.card import Card
from flankload.base.text_table import text_table
from flankload.errors import InputError, SceneError
from flankload.mechanisms import Earlier, Parts, run_once
from flankload.mechanisms.registry import require_flanks
from flankload.result import Result
from flankload.scene.refusal import in_file, refuse
from flankload.scene.schema import scene_paths
from flankload.scene.tree import number_at

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.mechanisms.protocol import States
    from flankload.mechanisms.stage_clock import Progress
    from flankload.scene import Scene

    #: Name of a key figure, name of an array of a result, or a function of a result.
    Quantity = str | Callable[[Result], Any]

#: Step of a length relative to the centre distance: 1e-4 mm on a pair of gears of 100 mm. Rotations
#: are linear over it to 1e-8, and have rounding errors of 1e-7 of what they change.
LENGTH_STEP = 1e-6
#: The same for deviations, and for slopes, which act over a face width.
DEVIATION_STEP, SLOPE_STEP = 3e-8, 3e-9
#: Step of an angle, rad, and of other numbers, relative to their value or to 1.
ANGLE_STEP, RELATIVE_STEP = 1e-6, 1e-5
#: Step in each unit for a centre distance of 1 mm.
STEPS_OF_LENGTH = {"mm": LENGTH_STEP, "um": 1e3 * DEVIATION_STEP, "um/mm": 1e3 * SLOPE_STEP}
#: Tables whose keys set the discretization, not the drive.
NOT_PHYSICAL = ("accuracy", "positions")
#: Weights of the values at 0, 1 and 2 steps for a derivative to one side, at 0 and 1 for one of
#: first order, and at -1, 0 and 1 for one in the middle.
TO_ONE_SIDE, FIRST_ORDER, CENTRAL = (-1.5, 2.0, -0.5), (-1.0, 1.0, 0.0), (-0.5, 0.0, 0.5)


@dataclass(frozen=True)
class _Stencil:
    """Results at a step or two from the scene, in the order of a path's values."""

    step: float
    weights: tuple[float, float, float]
    results: tuple[tuple[Result, ...], ...]


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(Card):
    """Derivatives of all results of a scene; from `sensitivity`.

    Attributes
    ----------
    scene : Scene
    paths : tuple of str
    results : tuple of Result
        Results of the scene, one per torque.
    cost : dict
        CPU seconds of the scene itself, `run_s`, and of all derivatives, `derivatives_s`; number of
        states that were continued from known contacts, `continued_states`, and of those that were
        solved completely, `solved_states`, because their contact has no cells (lumped, slices), or
        cells that differ in number or were laid twice.
    """

    scene: Scene
    paths: tuple[str, ...]
    results: tuple[Result, ...]
    cost: dict[str, float]
    _stencils: tuple[_Stencil, ...] = field(repr=False)

    def derivative(self, quantity: Quantity) -> Floats:
        """Derivatives of a quantity per unit of each path.

        Parameters
        ----------
        quantity : str or callable
            Name of a number in `Result.summary`, of an array of `Result`, or a function of a Result
            that returns a number or an array.

        Returns
        -------
        (paths, torques, ...) array
            NaN where a result has no such quantity. Derivatives of a largest value are those at the
            place of the largest value.

        Raises
        ------
        InputError
            If a result has no quantity of that name.
        """
        return np.stack([self._combined(s.weights, s, quantity) for s in self._stencils])

    def to_each_side(self, quantity: Quantity) -> Floats:
        """One-sided differences, towards smaller and towards greater values.

        They differ by more than the step where a quantity has a kink: where another position or
        another flank begins to determine a largest value.

        Parameters
        ----------
        quantity : str or callable
            As in `derivative`.

        Returns
        -------
        (2, paths, torques, ...) array
            At the end of a range, NaN to the other side.
        """
        sides = []
        for stencil in self._stencils:
            first = self._combined((-1.0, 1.0, 0.0), stencil, quantity)
            last = self._combined((0.0, -1.0, 1.0), stencil, quantity)
            if stencil.weights != CENTRAL:
                nothing = np.full_like(first, np.nan)
                first, last = (nothing, first) if stencil.step > 0 else (first, nothing)
            sides.append((first, last))
        return np.stack([np.stack(side) for side in zip(*sides, strict=True)])

    def step_of(self, path: str) -> float:
        """Step over which the derivative to one of the paths was taken, in its unit."""
        return abs(self._stencils[self.paths.index(path)].step)

    def to_text(self, quantities: Sequence[str]) -> str:
        """A table of derivatives of numbers in `Result.summary`, a row for each path and torque."""
        columns = [self.derivative(quantity) for quantity in quantities]
        rows = [
            (path, f"{result.torque_Nm:g}", *(f"{column[k, t]:.4g}" for column in columns))
            for k, path in enumerate(self.paths)
            for t, result in enumerate(self.results)
        ]
        return "\n".join(text_table([("per unit of", "torque_Nm", *quantities), *rows], left=1))

    def _combined(
        self, weights: tuple[float, float, float], stencil: _Stencil, quantity: Quantity
    ) -> Floats:
        """Weighted sum of the values of a stencil over its step."""
        per_torque = []
        for t, result in enumerate(self.results):
            values = [
                _at_sites_of(result, one[t], _value(one[t], quantity)) for one in stencil.results
            ]
            shares = [w * value for w, value in zip(weights, values, strict=True) if w]
            per_torque.append(sum(shares, np.zeros_like(values[0])) / stencil.step)
        return np.stack(per_torque)


def sensitivity(
    scene: Scene,
    paths: Sequence[str],
    parts: Parts | None = None,
    *,
    first_order: bool = False,
    progress: Progress | None = None,
) -> Sensitivity:
    """Derivatives of all results of a scene with respect to some of its keys.

    Parameters
    ----------
    scene : Scene
        Two bodies with flanks, without `accuracy.tolerance` and `effects.choose`.
    paths : sequence of str
        Keys with numbers, as in `Scene.replace`. Those of bodies that reach their elements are
        differentiated by elements that are solved anew.
    parts : Parts, optional
        Bodies and compliances of similar scenes.
    first_order : bool
        Whether states that must be solved completely are solved on one side only, which halves
        their number: the error of a derivative is then the step, 1e-4, instead of its square.
    progress : callable, optional
        As for `flankload.solve`, called by each run.

    Returns
    -------
    Sensitivity

    Raises
    ------
    SceneError
        If a path leads to no number, or the scene is impossible on both sides of its value.
    """
    steps = _steps_of(scene, paths)
    parts = Parts() if parts is None else parts
    begin = time.process_time()
    states: list[States] = []
    results = run_once(
        scene, progress=progress, on_states=states.append, earlier=Earlier(parts=parts)
    )
    plain = scene.replace({"accuracy.estimate": False, "accuracy.tangents": False})
    solved = time.process_time()

    def continued(changes: dict[str, float]) -> tuple[Result, ...]:
        earlier = Earlier(parts=parts, similar=states[0])
        beside = run_once(
            plain.replace(changes), progress=progress, on_states=states.append, earlier=earlier
        )
        return tuple(map(_with_corners_of, results, beside))

    # complete states beside the scene differ from its own; continued ones from continued ones
    known = states[0].known
    complete = known is None or not known.count.any()
    middle = results if complete else continued({})
    stencils = tuple(
        _stencil(
            *(path, number_at(scene, path), step, middle, continued),
            first_order=first_order and complete,
        )
        for path, step in zip(paths, steps, strict=True)
    )
    anew = [np.isfinite(part.certificate[:, 0]) for beside in states[1:] for part in beside.found]
    cost = {
        "run_s": solved - begin,
        "derivatives_s": time.process_time() - solved,
        "continued_states": sum(int((~part).sum()) for part in anew),
        "solved_states": sum(int(part.sum()) for part in anew),
    }
    return Sensitivity(scene, tuple(paths), results, cost, stencils)


def _steps_of(scene: Scene, paths: Sequence[str]) -> list[float]:
    """Steps of keys; refuses scenes whose discretization or effects follow from their results."""
    fits = isinstance(paths, Sequence) and not isinstance(paths, str) and bool(paths)
    fits = fits and all(isinstance(path, str) for path in paths)
    require("paths", paths, "a sequence of paths", fits=fits)
    with in_file(scene.file):
        require_flanks(scene)
        if scene.names_tolerance:
            expected = "no tolerance for derivatives: the discretization must not change"
            refuse("accuracy.tolerance", expected, scene.accuracy.tolerance)
        if scene.effects.choose is not None:
            expected = "named effects for derivatives: they must not change"
            refuse("effects.choose", expected, scene.effects.choose)
        return [_step_of(scene, path) for path in paths]


def _step_of(scene: Scene, path: str) -> float:
    """Step of a key, by its unit."""
    value = number_at(scene, path)
    bare = "".join(part.split("]")[-1] for part in path.split("["))
    unit = next((key.unit for key in scene_paths() if key.path == bare), "")
    if bare.split(".")[0] in NOT_PHYSICAL:
        refuse(path, "a key of the bodies, the pair, the load or the effects", f"'{path}'")
    if unit in STEPS_OF_LENGTH:
        return STEPS_OF_LENGTH[unit] * (scene.pair.axes_apart_mm or 100.0)
    if unit == "deg":
        return float(np.degrees(ANGLE_STEP))
    return RELATIVE_STEP * (abs(value) or 1.0)


def _stencil(
    path: str,
    value: float,
    step: float,
    middle: tuple[Result, ...],
    continued: Callable[[dict[str, float]], tuple[Result, ...]],
    *,
    first_order: bool,
) -> _Stencil:
    """Results on both sides of a value, or on one side: at the end of its range, to first order."""
    sides: dict[int, tuple[Result, ...]] = {}
    refused: SceneError | None = None
    for sense in (1, -1):
        try:
            sides[sense] = continued({path: value + sense * step})
        except SceneError as error:
            refused = refused or error  # of a missing key before a value below its range
        if first_order and sense in sides:
            return _Stencil(sense * step, FIRST_ORDER, (middle, sides[sense], sides[sense]))
    if refused is None:
        return _Stencil(step, CENTRAL, (sides[-1], middle, sides[1]))
    if not sides:
        raise refused
    ((sense, beside),) = sides.items()
    beyond = continued({path: value + 2 * sense * step})
    return _Stencil(sense * step, TO_ONE_SIDE, (middle, beside, beyond))


def _value(result: Result, quantity: Quantity) -> Floats:
    """A quantity of a result; NaN for None."""
    if not isinstance(quantity, str):
        found = quantity(result)
    elif quantity in result.summary:
        found = result.summary[quantity]
    else:
        found = getattr(result, quantity, None)
        if not isinstance(found, np.ndarray):
            expected = "a number of Result.summary or an array of Result"
            raise InputError(f"quantity: expected {expected}, found {quantity!r}")
    return np.asarray(np.nan if found is None else found, dtype=float)


def _with_corners_of(base: Result, beside: Result) -> Result:
    """A result with the contacts on sharp corners of the base.

    The same pairs then count as off corners on both sides of the base, also where a contact reaches
    a corner within the step.
    """
    _, ours, theirs = np.intersect1d(base.sites, beside.sites, return_indices=True)
    corner = np.zeros_like(beside.corner_contact)
    corner[:, theirs] = base.corner_contact[:, ours]
    coast = beside.coast
    if coast is not None and base.coast is not None:
        of_coast = np.zeros_like(corner)
        of_coast[:, theirs] = base.coast.corner_contact[:, ours]
        coast = replace(coast, corner_contact=of_coast)
    return replace(beside, corner_contact=corner, coast=coast)


def _at_sites_of(base: Result, result: Result, value: Floats) -> Floats:
    """A value by positions and sites at the sites of the base; 0 at those without load."""
    alike = np.array_equal(base.sites, result.sites) or value.ndim < 2
    if alike or value.shape[1] != result.sites.size:
        return value
    aligned = np.zeros((value.shape[0], base.sites.size, *value.shape[2:]))
    _, ours, theirs = np.intersect1d(base.sites, result.sites, return_indices=True)
    aligned[:, ours] = value[:, theirs]
    return aligned
