"""Random problems of the general form: existence from linear programming, states in 60 digits."""

from __future__ import annotations

from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest

import flankload as fl
from flankload import errors
from tests.support import oracle
from tests.support.contact_fuzz import solve
from tests.support.general_like import general_like
from tests.support.oracle import EPS, Problem, judge_problem
from tests.support.tolerances import ROUND_OFF, SOLVER

METHODS = ("auto", "single", "block", "load_path")
#: Largest rounding error of a row or load, relative to its own size: as in the core.
ROW_TOLERANCE = 10 * EPS
#: Of a truss of links [N/mm], along the chain and across it: between rollers, to the ground.
STIFFNESS = ((2e3, 0.0), (1.0, 3.0))
#: Rollers in pockets with a second motion on which one level or another misses its equations.
SECOND_MOTION = (19, 29, 39, 44, 54)
#: Levers over many decades that a search of all cases took for loads that no forces hold.
SCATTERED = (10, 22, 53, 136, 171, 242, 306, 431, 555, 579, 669, 706)


def faults_of_state(problem: Problem, state: fl.ContactState) -> list[str]:
    """Errors of a state and its certificate by 60-digit arithmetic."""
    verdict = judge_problem(problem, state)
    forward = 20 * EPS * state.info.condition
    faults = {
        "a force or a gap is negative": state.normal_forces.min() < 0
        or state.final_gap_angles.min() < 0,
        f"backward error {verdict.backward_error:g}": verdict.backward_error > 10 * EPS,
        f"own backward error {state.info.backward_error:g}": state.info.backward_error > 10 * EPS,
        f"wrong pairs, by {verdict.exact_violation:g}": verdict.exact_violation > 10 * EPS,
        # Both are NaN where the pairs leave a motion free.
        f"force error {verdict.forward_error:g}": verdict.forward_error > forward,
        f"motion error {verdict.motion_error:g}": verdict.motion_error > forward,
        "not said to be unique": problem.motions is problem.load_rows and not state.info.unique,
    }
    return [name for name, there in faults.items() if there]


def faults_of_refusal(problem: Problem, motion: np.ndarray) -> list[str]:
    """Errors of a motion that proves that no forces hold the loads: R y <= 0 < Q y."""
    opening = problem.load_rows @ motion
    size = np.abs(problem.load_rows) @ np.abs(motion)
    faults = []
    if (opening > ROUND_OFF * size).any():
        faults.append("the motion closes a gap")
    if not problem.loads @ motion > ROUND_OFF * np.abs(problem.loads) @ np.abs(motion):
        faults.append("no load works on the motion")
    return faults


@pytest.mark.parametrize("seed", range(4))
def test_a_state_is_found_exactly_where_forces_can_hold_the_loads(seed: int) -> None:
    rng = np.random.default_rng(700 + seed)
    solved, none, faults = set(), 0, []
    for case in range(300):
        problem, held = general_like(rng)
        method = METHODS[case % len(METHODS)]
        warm = rng.permutation(problem.gaps.size)[: int(rng.integers(0, 9))] if case % 3 else None
        try:
            state = solve(problem, method, warm)
        except errors.NoContactState as error:
            found = faults_of_refusal(problem, error.motion)
            none += 1
            found += ["says no state"] if held else []
        except errors.ContactError as error:
            found = [type(error).__name__]
        else:
            found = faults_of_state(problem, state)
            found += [] if held else ["a state that cannot be"]
            solved.add((problem.loads.size, state.active_pairs.size))
        faults += [f"case {case}, {method}: {fault}" for fault in found]
    assert faults == []
    assert none >= 20
    # From as few pairs as motions up to many more, for each number of motions.
    for q in range(1, 5):
        sizes = {size for motions, size in solved if motions == q}
        assert q in sizes
        assert max(sizes) >= 20


@pytest.mark.parametrize("method", METHODS)
def test_a_load_along_one_pair(method: str) -> None:
    """Loads that one pair can hold alone, whole numbers: what rounding leaves on the pairs that
    only hold the other motions is no force, though on their loads nothing else works."""
    solved = 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        q = int(rng.integers(2, 5))
        n = int(rng.integers(q, q + 4))
        levers = rng.integers(-2, 3, (n, q)).astype(float)
        root = rng.integers(-3, 4, (n, n)).astype(float)
        loads = levers[int(rng.integers(n))]
        if np.linalg.matrix_rank(levers) < q or not loads.any():
            continue
        gaps = rng.integers(0, 4, n).astype(float)
        problem = Problem(root @ root.T + np.eye(n), gaps, levers, levers, loads)
        assert largest_lack(problem, solve(problem, method)) <= ROW_TOLERANCE
        solved += 1
    assert solved > 200


def test_a_load_along_one_of_two_pairs_that_could_jam() -> None:
    """Forces on pairs 2 and 4 together hold no load; K is not definite, pair 1 carries alone."""
    compliance = [[1, 0, -3, -2, -2], [0, 4, 4, 4, 4], [-3, 4, 5, -3, -3], [-2, 4, -3, 5, 2]]
    levers = [[-1, -1, 2, 0], [-2, 0, 0, 1], [1, 1, 1, 1], [0, 0, 1, 1], [-2, -2, -2, -2]]
    problem = Problem(
        np.array([*compliance, [-2, 4, -3, 2, 2]], dtype=float),
        np.array([3.0, 1.0, 0.0, 1.0, 2.0]),
        np.array(levers, dtype=float),
        np.array(levers, dtype=float),
        np.array([-2.0, 0.0, 0.0, 1.0]),
    )
    for method in METHODS:
        state = solve(problem, method)
        assert state.normal_forces.tolist() == [0.0, 1.0, 0.0, 0.0, 0.0]
        assert largest_lack(problem, state) <= ROW_TOLERANCE


def largest_lack(problem: Problem, state: fl.ContactState) -> Fraction:
    """Residuals of rows and loads, each relative to its own size, in exact numbers."""

    def lack(terms: list[Fraction], *, closed: bool) -> Fraction:
        total, size = sum(terms), sum(map(abs, terms))
        return (abs(total) if closed else max(-total, Fraction(0))) / size if size else Fraction(0)

    forces, motions = (
        [Fraction(float(x)) for x in numbers] for numbers in (state.normal_forces, state.motions)
    )
    worst = Fraction(0)
    for i, gap in enumerate(problem.gaps):
        terms = [Fraction(float(k)) * f for k, f in zip(problem.compliance[i], forces, strict=True)]
        terms += [-Fraction(float(b)) * m for b, m in zip(problem.motions[i], motions, strict=True)]
        worst = max(worst, lack([*terms, Fraction(float(gap))], closed=forces[i] > 0))
    for c, load in enumerate(problem.loads):
        rows = problem.load_rows[:, c]
        terms = [Fraction(float(r)) * f for r, f in zip(rows, forces, strict=True)]
        worst = max(worst, lack([*terms, -Fraction(float(load))], closed=True))
    return worst


@pytest.mark.parametrize("method", METHODS)
def test_levers_that_are_rounding(method: str) -> None:
    """Some levers are 1e-8 … 1e-300 of the others, as where a normal meets the axis: an answer,
    though such a pair would touch first or could hold a load by itself."""
    rng = np.random.default_rng(0)
    for _ in range(250):
        q = int(rng.integers(1, 4))
        n = int(rng.integers(q + 1, 10))
        root = rng.standard_normal((n, n))
        levers = rng.standard_normal((n, q))
        small = rng.permutation(n)[: int(rng.integers(1, n - q + 1))]
        columns = rng.permutation(q)[: int(rng.integers(1, q + 1))]
        levers[np.ix_(small, columns)] *= 10.0 ** -rng.choice([8, 12, 14, 17, 20, 100, 200, 300])
        loads = np.delete(levers, small, axis=0).T @ np.abs(rng.standard_normal(n - small.size))
        problem = Problem(
            root @ root.T / n + 10.0 ** rng.uniform(-3, 0) * np.eye(n),
            rng.uniform(-0.3, 1.0, n),
            levers,
            levers,
            loads,
        )
        assert faults_of_state(problem, solve(problem, method)) == []


@pytest.mark.parametrize("seed", SCATTERED)
def test_levers_over_many_decades_are_solved(seed: int) -> None:
    """Each lever on a decade of its own, 1e-100 … 1: K is positive definite and forces hold the
    loads, so that a state exists, but a table contains only rounding of these levers. It was taken
    for a proof that no forces hold the loads, later given up."""
    rng = np.random.default_rng(seed)
    q = int(rng.integers(1, 5))
    n = int(rng.integers(q + 1, 12))
    root = rng.standard_normal((n, n))
    compliance = root @ root.T / n + 10.0 ** rng.uniform(-3, 0) * np.eye(n)
    decades = rng.choice([0, 0, 0, 8, 12, 14, 17, 20, 100], (n, q))
    levers = rng.standard_normal((n, q)) * 10.0**-decades
    loads = levers.T @ np.abs(rng.standard_normal(n))
    problem = Problem(compliance, rng.uniform(-0.3, 1.0, n), levers, levers, loads)
    assert faults_of_state(problem, solve(problem, "auto")) == []


def rollers_in_pockets(rng: np.random.Generator, *, second_motion: bool) -> Problem:
    """Rollers of a chain under pretension, pressed on planes of their pockets, on a wheel without
    torque: the planes that carry have levers of rounding, and the rest of their moment remains
    on a plane with a lever."""
    n, p = int(rng.integers(2, 13)), int(rng.choice([3, 5, 9, 17]))
    angles = np.tile(np.linspace(-0.6, 0.6, p), n)
    angles[p // 2 :: p] = 0.0
    roller = np.repeat(np.arange(n), p)
    normals = np.zeros((n * p, n, 2))
    normals[np.arange(n * p), roller] = np.column_stack([np.sin(angles), np.cos(angles)])
    link = np.eye(n) - np.eye(n, k=-1)
    along, across = (np.linalg.inv(k * link.T @ link + own * np.eye(n)) for k, own in STIFFNESS)
    matrix = normals[..., 0] @ along @ normals[..., 0].T
    matrix += normals[..., 1] @ across @ normals[..., 1].T
    same = roller[:, None] == roller[None, :]
    matrix += same * (np.cos(angles[:, None] - angles) + 1e-4 * np.eye(n * p)) / 1e3
    levers = 34 * np.sin(angles)
    levers[angles == 0] = 4e-15 * rng.choice([0, 1, -1, 2], n)
    gaps = 3 * (1 - np.cos(angles)) - 0.05 + 0.01 * np.sin(angles) * roller
    columns, loads = levers[:, None], np.zeros(1)
    if second_motion:
        more = np.cos(np.arange(n * p)) * np.where(rng.random(n * p) < 0.6, 1e-17, 1.0)
        columns = np.column_stack([levers, more])
        loads = np.array([0.0, more @ np.abs(rng.standard_normal(n * p))])
    return Problem(0.5 * (matrix + matrix.T), gaps, columns, columns, loads)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("second_motion", [False, True])
def test_a_little_force_that_alone_holds_a_load(method: str, *, second_motion: bool) -> None:
    """Set to zero as rounding of the largest it left its load unmet, and the level that had found
    this state ended the ladder."""
    for seed in SECOND_MOTION if second_motion else range(30):
        problem = rollers_in_pockets(np.random.default_rng(seed), second_motion=second_motion)
        state = solve(problem, method)
        verdict = judge_problem(problem, state)
        assert verdict.exact_violation <= 10 * EPS
        assert verdict.backward_error <= SOLVER


def test_the_judge_agrees_with_elimination_in_60_digits() -> None:
    """Refinement from double precision and elimination agree in 40 digits."""
    rng = np.random.default_rng(17)
    compared = 0
    while compared < 12:
        problem, held = general_like(rng)
        if not held or problem.gaps.size > 20:
            continue
        active = solve(problem, "auto").active_pairs
        with mp.workdps(oracle.DIGITS):
            refined = oracle._exact_solution(problem, active)
            if refined is None:
                continue
            k, q = active.size, problem.loads.size
            bordered, right = mp.zeros(k + q), mp.zeros(k + q, 1)
            for r, i in enumerate(active):
                for c, j in enumerate(active):
                    bordered[r, c] = mp.mpf(float(problem.compliance[i, j]))
                for c in range(q):
                    bordered[r, k + c] = -mp.mpf(float(problem.motions[i, c]))
                    bordered[k + c, r] = mp.mpf(float(problem.load_rows[i, c]))
                right[r] = -mp.mpf(float(problem.gaps[i]))
            for c in range(q):
                right[k + c] = mp.mpf(float(problem.loads[c]))
            whole = list(mp.lu_solve(bordered, right))
            for part, one in zip((*refined[0], *refined[1]), whole, strict=True):
                assert abs(part - one) <= mp.mpf(10) ** -36 * max(map(abs, whole))
        compared += 1


def test_the_judge_finds_an_error_of_a_hundred_roundings() -> None:
    """Errors in a force, a motion, a gap and the set of pairs are found separately."""
    rng = np.random.default_rng(3)
    problem, held = general_like(rng)
    while not held or problem.loads.size < 2:
        problem, held = general_like(rng)
    state = solve(problem, "auto")
    assert faults_of_state(problem, state) == []
    largest = int((state.normal_forces * np.sqrt(problem.compliance.diagonal())).argmax())
    for name in ("normal_forces", "motions"):
        spoilt = {name: np.array(getattr(state, name)) for name in ("normal_forces", "motions")}
        spoilt[name][largest if name == "normal_forces" else 0] *= 1 + 1e3 * EPS
        wrong = fl.ContactState(**{**vars(state), **spoilt})
        assert any(fault.startswith("backward error") for fault in faults_of_state(problem, wrong))
    fewer = np.array(state.normal_forces)
    fewer[largest] = 0.0
    wrong = fl.ContactState(**{**vars(state), "normal_forces": fewer})
    assert any(fault.startswith("wrong pairs") for fault in faults_of_state(problem, wrong))
