"""Seeded random problems as they occur in gears, and checks of their solutions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import flankload as fl
from flankload import errors

EPS = float(np.finfo(float).eps)
METHODS = ("auto", "single", "block", "auto", "auto", "load_path")


@dataclass(frozen=True)
class GearLike:
    """A contact problem: A [rad/N], torque row and row levers [mm], gap angles [rad], torque."""

    flexibility: np.ndarray
    torque_row: np.ndarray
    levers: np.ndarray
    gap_angles: np.ndarray
    torque: float
    friction: float


def gear_like(rng: np.random.Generator) -> GearLike:
    """One to four tooth pairs: half-plane kernel, bending, rim, spacing errors, friction."""
    teeth = int(rng.integers(1, 5))
    cells = int(rng.integers(2, 26))
    tooth = np.repeat(np.arange(teeth), cells)
    modulus = 10.0 ** rng.uniform(4.0, 5.5)
    kernel = 2.0 / (np.pi * modulus)
    half_width = 10.0 ** rng.uniform(-2.0, -0.3)
    step = 2.0 * rng.uniform(1.2, 4.0) * half_width / cells
    place = np.tile((np.arange(cells) - 0.5 * (cells - 1)) * step, teeth)
    distance = np.abs(place[:, None] - place)
    upper, lower = distance + 0.5 * step, distance - 0.5 * step
    near = -(upper * np.log(upper) - lower * np.log(np.abs(lower)) - step) / step
    same = tooth[:, None] == tooth
    height = rng.uniform(0.5, 4.0, teeth)[tooth] + place
    bending = rng.uniform(0.5, 5.0) / modulus * np.outer(height, height)
    rim = rng.uniform(0.0, 2.0) / modulus
    compliance = np.where(same, kernel * (near + np.log(20.0)) + bending, 0.0)
    compliance = compliance + rim * 0.5 ** np.abs(tooth[:, None] - tooth)
    levers = 30.0 + rng.uniform(-2.0, 2.0, teeth)[tooth] + 0.3 * place
    curvature = 1.0 / rng.uniform(5.0, 20.0)
    gaps = 0.5 * curvature * (place - rng.uniform(-1.0, 1.0, teeth)[tooth] * half_width) ** 2
    gaps = gaps + (rng.uniform(0.0, 0.01, teeth) * rng.integers(0, 2))[tooth]
    friction = float(rng.choice([0.0, 0.0, rng.uniform(0.0, 0.2), rng.uniform(0.2, 0.8)]))
    sense = rng.choice([-1.0, 1.0], teeth)[tooth]
    slope = rng.uniform(0.0, 1.0, teeth)[tooth]
    row = levers * (1.0 + friction * sense * slope)
    if friction > 0:
        across = bending * rng.uniform(0.2, 1.2) + 0.2 * kernel * np.sign(place[:, None] - place)
        compliance = compliance + friction * sense[None, :] * np.where(same, across, 0.0)
    nominal = np.pi * half_width**2 * curvature / (4.0 * kernel) * teeth * 30.0
    return GearLike(
        compliance / levers[:, None],
        row,
        levers,
        gaps / levers,
        float(nominal * 10.0 ** rng.uniform(np.log10(0.03), np.log10(30.0))),
        friction,
    )


def outcome(problem: GearLike, method: str) -> str:
    """Solve: ``solved``, ``none`` (an error reports that there is no state) or the fault found."""
    try:
        state = fl.solve_contact(
            problem.flexibility,
            problem.torque_row,
            problem.gap_angles,
            problem.torque,
            normal_lever_arms=problem.levers,
            method=method,
        )
    except errors.NoContactState:
        return "none" if problem.friction > 0 else "wrong: says no state"
    except errors.ContactError as error:
        return f"wrong: {type(error).__name__}"
    forces = state.normal_forces.astype(np.longdouble)
    terms = problem.flexibility.astype(np.longdouble) * forces
    gap = terms.sum(axis=1) + problem.gap_angles - state.rotation
    size = np.abs(terms).sum(axis=1) + np.abs(problem.gap_angles) + abs(state.rotation)
    held = (problem.torque_row * forces).sum() - problem.torque
    around = (np.abs(problem.torque_row) * forces).sum() + problem.torque
    active = forces > 0
    if (forces < 0).any():
        return "wrong: tension"
    if (gap < -10 * EPS * size).any():
        return "wrong: overlap"
    if (np.abs(gap) > 10 * EPS * size)[active].any():
        return "wrong: force across a gap"
    if abs(held) > 10 * EPS * around:
        return "wrong: torque not held"
    if state.info.backward_error > 10 * EPS:
        return "wrong: backward error"
    return "solved"
