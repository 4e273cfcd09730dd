"""Contact problems: each loop, and those on which loops break."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import flankload as fl
from flankload import _core, errors
from flankload.contact.problem import GENERAL
from tests.support.cylinder_problem import cylinder
from tests.support.gear_like import gear_like
from tests.support.general_like import general_like

from .cases import Case
from .quantities import CONTACT

THREE = [[10, 9.4, 8], [9.4, 10, 9.4], [8, 9.4, 10]]
TWINS = [[2, 1, 1, 0.5], [1, 2, 2, 1], [1, 2, 2, 1], [0.5, 1, 1, 2]]
#: As many forces of a large problem as characterize it.
SAMPLES = 12


def quantities_of(solve: Callable[[], fl.ContactState]) -> dict[str, Any]:
    """The state in numbers, or the error in its place."""
    try:
        state = solve()
    except errors.NegativeForce as error:
        return {"outcome": "NegativeForce", **_numbers(error.state)}
    except errors.NoContactState as error:
        return {
            "outcome": f"NoContactState, {'proven' if error.proven else 'not proven'}",
            "held": error.largest_torque,
        }
    except errors.ContactError as error:
        return {"outcome": type(error).__name__}
    return {"outcome": "solved", **_numbers(state)}


def _numbers(state: fl.ContactState) -> dict[str, Any]:
    n = state.normal_forces.size
    some = np.unique(np.linspace(0, n - 1, min(n, SAMPLES)).astype(int))
    found: dict[str, Any] = {
        "status": state.status,
        "active_pairs": state.active_pairs if n <= SAMPLES else [state.active_pairs.size],
        "motions": state.motions,
        "gaps": state.final_gap_angles[some],
        "tangent": state.tangent,
        "condition": state.info.condition,
    }
    undetermined = {k for group in state.info.undetermined for k in group}
    if undetermined:
        found["sums_of_groups"] = [
            state.normal_forces[list(group)].sum() for group in state.info.undetermined
        ]
        # neither the split nor numbers that follow from it alone
        some = np.array([k for k in some if k not in undetermined])
        found.pop("condition")
        found.pop("active_pairs")
    if state.status in (0, 1, -6) or undetermined:
        found["forces"] = state.normal_forces[some]
    return found


def _angles(
    matrix: Any, gaps: Any, torque: float, *, levers: Any = None, method: str = "auto", why: str
) -> Case:
    n = len(gaps)
    row = [1.0] * n if levers is None else levers
    return Case(
        inputs={
            "flexibility_matrix_rad_per_N": matrix,
            "lever_arms_mm": row,
            "gap_angles_rad": gaps,
            "torque_Nmm": torque,
            "method": method,
        },
        provenance=why,
        solve=partial(
            quantities_of, partial(fl.solve_contact, matrix, row, gaps, torque, method=method)
        ),
        known=CONTACT,
    )


def _gear_like(seed: int, method: str, *, friction: bool = False) -> Case:
    rng = np.random.default_rng(seed)
    problem = gear_like(rng)
    while problem.gap_angles.size < 40 or (problem.friction > 0) != friction:
        problem = gear_like(rng)
    return Case(
        inputs={
            "generator": "tests/support/gear_like.py: the first problem of 40 pairs or more "
            + ("with" if friction else "without")
            + " friction",
            "seed": seed,
            "pairs": problem.gap_angles.size,
            "friction": problem.friction,
            "torque_Nmm": problem.torque,
            "method": method,
        },
        provenance="seeded gear-like problem; state judged in 60 digits by tests/hard_cases",
        solve=partial(
            quantities_of,
            partial(
                fl.solve_contact,
                problem.flexibility,
                problem.torque_row,
                problem.gap_angles,
                problem.torque,
                normal_lever_arms=problem.levers,
                method=method,
            ),
        ),
        known=CONTACT,
    )


def _cylinder(n: int, method: str, *, friction: float = 0.0) -> Case:
    p = cylinder(n, friction)

    def solve() -> fl.ContactState:
        return fl.solve_contact_general(
            p.compliance, p.gaps, p.levers, p.torque, load_rows=p.row, method=method
        )

    return Case(
        inputs={
            "generator": "tests/support/cylinder_problem.py: cylinder on a half-plane that bends",
            "pairs": n,
            "friction": friction,
            "torque_Nmm": p.torque,
            "method": method,
        },
        provenance="closed form of the matrix; for the pressure Hertz",
        solve=partial(quantities_of, solve),
        known=CONTACT,
    )


def _general(seed: int, *, held: bool) -> Case:
    rng = np.random.default_rng(seed)
    problem, can_be_held = general_like(rng)
    while can_be_held != held or problem.motions.shape[1] < 2:
        problem, can_be_held = general_like(rng)

    return Case(
        inputs={
            "generator": "tests/support/general_like.py: the first of two motions or more whose "
            f"loads can {'' if held else 'not '}be held",
            "seed": seed,
            "pairs": problem.gaps.size,
            "motions": problem.motions.shape[1],
        },
        provenance="seeded; HiGHS says whether the loads can be held",
        solve=partial(
            quantities_of,
            partial(
                fl.solve_contact_general,
                problem.compliance,
                problem.gaps,
                problem.motions,
                problem.loads,
                load_rows=problem.load_rows,
            ),
        ),
        known=CONTACT,
    )


def _several_torques(seed: int) -> Case:
    rng = np.random.default_rng(seed)
    problem = gear_like(rng)
    while problem.gap_angles.size < 40 or problem.friction > 0:
        problem = gear_like(rng)
    torques = problem.torque * np.array([1.0, 0.1, 0.0, 3.0])

    def solve() -> dict[str, Any]:
        states = fl.solve_contact_torques(
            problem.flexibility,
            problem.torque_row,
            problem.gap_angles,
            torques,
            normal_lever_arms=problem.levers,
        )
        return {
            "status": [state.status for state in states],
            "motions": [state.rotation for state in states],
            "forces": [state.normal_forces.max() for state in states],
            "active_pairs": [state.active_pairs.size for state in states],
        }

    return Case(
        inputs={
            "generator": "tests/support/gear_like.py: the first problem of 40 pairs or more "
            "without friction",
            "seed": seed,
            "torques_Nmm": torques.tolist(),
        },
        provenance="the states of each torque alone, on one kept factor",
        solve=solve,
        known=CONTACT,
    )


def _with_rows_exchanged(seed: int) -> Case:
    """Loop of elimination with row exchanges: only the flat interface offers it."""
    rng = np.random.default_rng(seed)
    problem = gear_like(rng)
    while problem.gap_angles.size < 40 or problem.friction == 0:
        problem = gear_like(rng)
    levers = problem.levers

    def solve() -> dict[str, Any]:
        forces, gaps, motion, tangent, active, _, _, info = _core.flankload_solve_contact(
            np.asfortranarray(levers[:, None] * problem.flexibility),
            levers * problem.gap_angles,
            np.asfortranarray(levers[:, None]),
            np.asfortranarray(problem.torque_row[:, None]),
            np.array([problem.torque]),
            GENERAL,
            5,
            np.empty(0, dtype=np.int32),
        )
        some = np.unique(np.linspace(0, forces.size - 1, SAMPLES).astype(int))
        return {
            "outcome": "solved",
            "status": info,
            "active_pairs": [int(active.sum())],
            "motions": motion,
            "gaps": gaps[some],
            "tangent": tangent,
            "forces": forces[some],
        }

    return Case(
        inputs={
            "generator": "tests/support/gear_like.py: the first problem of 40 pairs or more "
            "with friction",
            "seed": seed,
            "friction": problem.friction,
            "torque_Nmm": problem.torque,
            "method": "single, rows exchanged (5 at the flat interface)",
        },
        provenance="seeded gear-like problem; state judged in 60 digits by tests/hard_cases",
        solve=solve,
        known=CONTACT,
    )


def _preload() -> Case:
    matrix, gaps = [[2.0, 0.5], [0.5, 2.0]], [-0.1, 0.2]
    return Case(
        inputs={
            "compliance_matrix_mm_per_N": matrix,
            "normal_gaps_mm": gaps,
            "motions": [1.0, -1.0],
            "loads": [0.0],
        },
        provenance="two flanks that face away from each other, one overlapping; no load",
        solve=partial(
            quantities_of, partial(fl.solve_contact_general, matrix, gaps, [1.0, -1.0], 0.0)
        ),
        known=CONTACT,
    )


def contact_cases() -> dict[str, Case]:
    """All cases by name."""
    jump = "the middle pair touches first and then carries nothing: F = (5, 0, 5), rotation 91"
    cases = {
        f"three_flanks_{method}": _angles(THREE, [1, 0, 1], 10, method=method, why=jump)
        for method in ("single", "block", "load_path", "paper")
    }
    near = (np.array(TWINS) + np.diag([0, 1e-10, 1e-10, 0])).tolist()
    place = np.linspace(0, 1, 20)
    tie = np.exp(-np.abs(place[:, None] - place))
    cases |= {
        "near_twins": _angles(near, [0] * 4, 5, why="two pairs at nearly the same place"),
        "exact_twins": _angles(TWINS, [0] * 4, 5, why="two pairs at the same place"),
        "ties": _angles(tie.tolist(), [0] * 20, 1, why="all gaps are equal"),
        "no_torque": _angles(THREE, [3, 2, 4], 0, why="the least gap angle is the rotation"),
        "tiny_torque": _angles(THREE, [1, 0, 1], 1e-12, why="loads far below all scales"),
        "huge_torque": _angles(THREE, [1, 0, 1], 1e12, why="loads far above all scales"),
        "three_states": _angles([[1, 2], [2, 1]], [0, 0], 1, why="three states, none preferred"),
        "no_state": _angles(
            [[2, 1], [1, 1.5]],
            [0, 0],
            1,
            levers=[1, -1],
            why="levers of both signs: refused, a row scale must be positive",
        ),
        "preload": _preload(),
        "several_motions": _general(11, held=True),
        "several_motions_not_held": _general(12, held=False),
        "gear_paper": _gear_like(21, "paper"),
        "gear_torques": _several_torques(20),
        "gear_rows_exchanged": _with_rows_exchanged(22),
        "gear_friction": _gear_like(22, "auto", friction=True),
        "gear_friction_load_path": _gear_like(22, "load_path", friction=True),
        "cylinder_100": _cylinder(100, "auto"),
        "cylinder_400_block": _cylinder(400, "block"),
        "cylinder_400_cascade": _cylinder(400, "cascade"),
        "cylinder_400_friction": _cylinder(400, "auto", friction=0.3),
    }
    cases |= {
        f"gear_{method}": _gear_like(20, method)
        for method in ("single", "block", "cascade", "primal", "load_path")
    }
    return {f"contact_{name}": case for name, case in cases.items()}
