"""Independent check of a state of contact: its own set of pairs solved in 60 digits."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath as mp
import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lu_factor, lu_solve

import flankload as fl

EPS = float(np.finfo(float).eps)
DIGITS = 60
# The exact solution is refined until its last correction is below this fraction of it.
SETTLED = mp.mpf(10) ** -40
MAX_REFINEMENTS = 60
#: Verdicts that are kept: a solver that finds the same bits from several guesses is judged once.
MOST_VERDICTS = 64
_VERDICTS: dict[tuple[bytes, ...], Verdict] = {}


@dataclass(frozen=True)
class Verdict:
    """Assessment of a state in 60-digit arithmetic.

    Attributes
    ----------
    forward_error : float
        Largest error of a force, relative to the largest force, both times sqrt(K_ii); NaN if the
        active pairs do not constrain every motion.
    motion_error : float
        Largest error of a motion, relative to the largest motion, gap or force, each on the scale
        of the pairs (motions by their largest lever, rows over sqrt(K_ii)); NaN as above.
    backward_error : float
        Largest residual of a row, gaps and forces of the wrong sign included, relative to its size.
    exact_violation : float
        The same for the exact solution of this set of pairs: wrong signs only. If the active pairs
        do not constrain every motion, that of the state itself.
    """

    forward_error: float
    motion_error: float
    backward_error: float
    exact_violation: float


@dataclass(frozen=True)
class Problem:
    """The general form: K (n, n), g0 (n), B and R (n, q), Q (q); the numbers count as exact."""

    compliance: np.ndarray
    gaps: np.ndarray
    motions: np.ndarray
    load_rows: np.ndarray
    loads: np.ndarray


def judge(
    matrix: ArrayLike, row: ArrayLike, gaps: ArrayLike, torque: float, state: fl.ContactState
) -> Verdict:
    """Check a state of the angle form; row levers cancel in its equations."""
    matrix = np.asarray(matrix, dtype=float)
    return judge_general(matrix, gaps, np.ones(len(matrix)), torque, state, load_rows=row)


def judge_problem(problem: Problem, state: fl.ContactState) -> Verdict:
    """Check a state of a problem."""
    return judge_general(
        problem.compliance,
        problem.gaps,
        problem.motions,
        problem.loads,
        state,
        load_rows=problem.load_rows,
    )


def judge_general(
    compliance: ArrayLike,
    gaps: ArrayLike,
    motions: ArrayLike,
    loads: ArrayLike,
    state: fl.ContactState,
    *,
    load_rows: ArrayLike | None = None,
) -> Verdict:
    """Solve and check the set of pairs of a state; the given numbers count as exact."""
    force_scale = np.atleast_1d(np.asarray(loads, dtype=float))
    shape = (np.size(gaps), force_scale.size)
    levers = np.asarray(motions, dtype=float).reshape(shape)
    problem = Problem(
        np.asarray(compliance, dtype=float),
        np.asarray(gaps, dtype=float),
        levers,
        levers if load_rows is None else np.asarray(load_rows, dtype=float).reshape(shape),
        force_scale,
    )
    arrays = (*vars(problem).values(), state.normal_forces, state.motions)
    key = (*(array.tobytes() for array in arrays), bytes(str(shape), "ascii"))
    if key not in _VERDICTS:
        if len(_VERDICTS) == MOST_VERDICTS:
            del _VERDICTS[next(iter(_VERDICTS))]
        _VERDICTS[key] = _verdict(problem, state)
    return _VERDICTS[key]


def _verdict(problem: Problem, state: fl.ContactState) -> Verdict:
    """Solve and check the set of pairs of a state."""
    active = np.flatnonzero(state.normal_forces)
    with mp.workdps(DIGITS):
        given = _exact(state.normal_forces[active])
        moved = _exact(state.motions)
        backward = max(
            _worst_row(problem, active, given, moved, closed=True),
            _worst_load(problem, active, given),
        )
        solved = _exact_solution(problem, active)
        if solved is None:
            violation = _worst_row(problem, active, given, moved, closed=False)
            return Verdict(np.nan, np.nan, float(backward), float(violation))
        forces, motion = solved
        violation = _worst_row(problem, active, forces, motion, closed=False)
        root = np.sqrt(problem.compliance.diagonal())
        levers = np.abs(problem.motions / root[:, np.newaxis]).max(axis=0)
        pressed = _size(forces, root[active])
        return Verdict(
            forward_error=_distance(given, forces, root[active], pressed),
            motion_error=_distance(
                moved, motion, levers, max(pressed, np.abs(problem.gaps / root).max())
            ),
            backward_error=float(backward),
            exact_violation=float(violation),
        )


def _exact(values: np.ndarray) -> list:
    """The numbers of an array as lists of 60-digit ones."""
    if values.ndim > 1:
        return [_exact(line) for line in values]
    return [mp.mpf(value) for value in values.tolist()]


class _Lines:
    """Rows of doubles as whole numbers times powers of two: their products are exact."""

    def __init__(self, values: np.ndarray) -> None:
        fractions, powers = np.frexp(values)
        self._whole = (fractions * 2.0**53).astype(np.int64).astype(object)
        self._powers = powers.astype(np.int64) - 53

    def times(self, numbers: list) -> list:
        """Σ_j A_ij x_j of 60-digit numbers, rounded once."""
        parts = [mp.mpf(number)._mpf_[:3] for number in numbers]
        digits = np.array([-int(man) if sign else int(man) for sign, man, _ in parts], dtype=object)
        powers = self._powers + np.array([power for _, _, power in parts], dtype=np.int64)
        least = powers.min(axis=1)
        shifts = (powers - least[:, np.newaxis]).astype(object)
        totals = np.left_shift(self._whole, shifts) @ digits
        return [mp.mpf((total, power)) for total, power in zip(totals, least.tolist(), strict=True)]


def _size(numbers: list, weight: np.ndarray) -> float:
    """Largest weighted number."""
    return float(max((abs(x) * w for x, w in zip(numbers, weight, strict=True)), default=0))


def _distance(given: list, exact: list, weight: np.ndarray, size: float) -> float:
    """Largest weighted difference relative to the size, or to the largest entry if it is larger."""
    wrong = _size([y - x for x, y in zip(exact, given, strict=True)], weight)
    size = max(size, _size(exact, weight))
    if not wrong:
        return 0.0
    return wrong / size if size else np.inf


def _worst_row(
    problem: Problem, active: np.ndarray, forces: list, motion: list, *, closed: bool
) -> mp.mpf:
    """Largest residual of a row relative to its size Σ|K_ij|F_j + |g0_i| + Σ|B_ic q_c|.

    A gap must not be negative; with `closed` that of an active pair must be zero; no force may be
    negative, on the scale of the largest, both times sqrt(K_ii). Residuals are computed in 60
    digits; for sizes double precision is sufficient.
    """
    strengths = np.abs(np.array(forces, dtype=float))
    sizes = (
        np.abs(problem.compliance[:, active]) @ strengths
        + np.abs(problem.gaps)
        + np.abs(problem.motions) @ np.abs(np.array(motion, dtype=float))
    )
    equations = np.column_stack(
        [problem.compliance[:, active], problem.motions, problem.gaps[:, np.newaxis]]
    )
    gaps = _Lines(equations).times([*forces, *(-part for part in motion), 1])
    touching = set(active.tolist()) if closed else set()
    worst = mp.mpf(0)
    for i, (gap, size) in enumerate(zip(gaps, sizes.tolist(), strict=True)):
        if gap < 0 or i in touching:
            worst = max(worst, abs(gap) / size if size else abs(gap))
    if any(forces):
        root = np.sqrt(problem.compliance.diagonal()[active])
        pull = min(force * weight for force, weight in zip(forces, root, strict=True))
        worst = max(worst, -pull / _size(forces, root))
    return worst


def _worst_load(problem: Problem, active: np.ndarray, forces: list) -> mp.mpf:
    """Largest residual of a load, relative to Σ|R_ic|F_i + |Q_c|."""
    worst = mp.mpf(0)
    for c, load in enumerate(problem.loads.tolist()):
        parts = problem.load_rows[active, c]
        lack = abs(mp.fdot(_exact(parts), forces) - mp.mpf(load))
        size = np.abs(parts) @ np.array(forces, dtype=float) + abs(load)
        worst = max(worst, lack / float(size) if size else lack)
    return worst


def _exact_solution(problem: Problem, active: np.ndarray) -> tuple[list, list] | None:
    """Forces and motion of the active pairs to 40 digits; None if a motion is unconstrained.

    Solved in double precision on scales of powers of two, then refined with 60-digit residuals
    until nothing changes; by elimination in 60 digits if that does not converge.
    """
    k, q = active.size, problem.loads.size
    equations = np.zeros((k + q, k + q))
    equations[:k, :k] = problem.compliance[np.ix_(active, active)]
    equations[:k, k:] = -problem.motions[active]
    equations[k:, :k] = problem.load_rows[active].T
    right = np.concatenate([-problem.gaps[active], problem.loads])
    if k < q or np.linalg.matrix_rank(problem.motions[active]) < q:
        return None
    rows, columns = _scales(equations, k)
    solution = _refine(equations, rows, columns, right)
    if solution is None:
        try:
            solution = list(mp.lu_solve(mp.matrix(_exact(equations)), mp.matrix(_exact(right))))
        except ZeroDivisionError:
            return None
    return solution[:k], solution[k:]


def _scales(equations: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Powers of two for rows and columns: unit diagonal of K, then unit motions and loads."""
    pairs = np.exp2(-np.round(0.5 * np.log2(np.abs(equations.diagonal()[:k]))))
    loads = np.exp2(-np.round(np.log2(np.abs(equations[k:, :k] * pairs).max(axis=1))))
    motions = np.exp2(-np.round(np.log2(np.abs(equations[:k, k:].T * pairs).max(axis=1))))
    return np.concatenate([pairs, loads]), np.concatenate([pairs, motions])


def _refine(
    equations: np.ndarray, rows: np.ndarray, columns: np.ndarray, right: np.ndarray
) -> list | None:
    """Iterative refinement; None if it does not converge."""
    try:
        factor = lu_factor(equations * np.outer(rows, columns))
    except (np.linalg.LinAlgError, RuntimeWarning):
        return None
    weights, scales = _exact(rows), _exact(columns)
    residuals = _Lines(np.column_stack([-equations, right]))
    solution = [mp.mpf(0)] * len(right)
    before = mp.inf
    for _ in range(MAX_REFINEMENTS):
        lack = [
            weight * part
            for weight, part in zip(weights, residuals.times([*solution, 1]), strict=True)
        ]
        size = max(abs(part) for part in lack)
        if not size:
            return solution
        change = lu_solve(factor, np.array([part / size for part in lack], dtype=float))
        if not np.isfinite(change).all():
            return None
        step = size * mp.mpf(float(np.abs(change).max()))
        if step > before / 2:
            return None
        before = step
        solution = [
            old + scale * size * mp.mpf(new)
            for old, scale, new in zip(solution, scales, change.tolist(), strict=True)
        ]
        if step <= SETTLED * max(abs(x) / s for x, s in zip(solution, scales, strict=True)):
            return solution
    return None
