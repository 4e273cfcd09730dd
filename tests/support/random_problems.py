"""Seeded random contact problems of all kinds for the fuzz, with known facts about their states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.support.gear_like import gear_like
from tests.support.general_like import general_like
from tests.support.oracle import Problem

Rng = np.random.Generator


@dataclass(frozen=True)
class Trial:
    """A problem; `exists` is True if a state is known to exist, False if known not to."""

    problem: Problem
    exists: bool | None


def gears(rng: Rng) -> Trial:
    """Tooth pairs of a gear pair, torque 0.03 … 30 times the nominal one, friction up to 0.8."""
    gear = gear_like(rng)
    column = np.array(gear.levers)[:, None]
    row = np.array(gear.torque_row)[:, None]
    problem = Problem(
        gear.levers[:, None] * gear.flexibility,
        gear.levers * gear.gap_angles,
        column,
        column if gear.friction == 0 else row,
        np.array([gear.torque]),
    )
    return Trial(problem, True if gear.friction == 0 else None)


def general(rng: Rng) -> Trial:
    """Definite matrices with one to four motions, preload, scales from 1e-8 to 1e8."""
    problem, held = general_like(rng)
    return Trial(problem, held)


def rubbing(rng: Rng) -> Trial:
    """Teeth with friction 0.3 … 2 and one to three motions: K without symmetry or definite part."""
    q, n = int(rng.integers(1, 4)), int(rng.integers(4, 75))
    friction = rng.uniform(0.3, 2.0)
    teeth = int(rng.integers(1, 6))
    tooth = np.sort(rng.integers(0, teeth, n))
    place = np.arange(n) * rng.uniform(0.02, 0.2)
    near = np.exp(-np.abs(place[:, None] - place) / rng.uniform(0.05, 2.0))
    compliance = np.where(tooth[:, None] == tooth, near + rng.uniform(0.1, 3.0), 0.2)
    sense = rng.choice([-1.0, 1.0], teeth)[tooth] * rng.uniform(0.0, 1.0, n)
    across = rng.uniform(-1.0, 1.0, (n, n)) * rng.uniform(0.1, 1.0)
    compliance = compliance * (1.0 + friction * across * sense)
    np.fill_diagonal(compliance, np.abs(compliance.diagonal()) + 0.1)
    turn = 2.0 * np.pi * (tooth / teeth + 0.003 * place)
    radius = rng.uniform(5.0, 60.0)
    normals = np.column_stack([radius - 0.05 * place, np.cos(turn), np.sin(turn)])
    tangents = np.column_stack([rng.uniform(0.2, 1.0, n) * radius, -np.sin(turn), np.cos(turn)])
    motions = normals[:, :q]
    rows = motions + friction * sense[:, None] * tangents[:, :q]
    gaps = rng.uniform(0.0, 1.0) * place**2 + rng.uniform(0.0, 1.0, teeth)[tooth]
    size = 10.0 ** rng.uniform(-3, 4)
    loads = size * rows.T @ (np.abs(rng.standard_normal(n)) * (rng.random(n) < 0.5))
    return Trial(Problem(compliance, gaps, motions, rows, loads), None)


def decades(rng: Rng) -> Trial:
    """Each lever on its own decade over 9 … 30 decades; forces hold the loads."""
    q = int(rng.integers(1, 5))
    n = int(rng.integers(q + 1, 25))
    root = rng.standard_normal((n, n))
    compliance = root @ root.T / n + 10.0 ** rng.uniform(-3, 0) * np.eye(n)
    levers = rng.standard_normal((n, q)) * 10.0 ** -rng.uniform(0, rng.uniform(9, 30), (n, q))
    levers *= rng.choice([0.0, 1.0, 1.0, 1.0], (n, q))
    levers[:q] = np.where(levers[:q] == 0.0, 1.0, levers[:q])
    loads = levers.T @ np.abs(rng.standard_normal(n))
    return Trial(Problem(compliance, rng.uniform(-0.3, 1.0, n), levers, levers, loads), True)


def scales(rng: Rng) -> Trial:
    """Rows, motions and loads on their own scales: the problem with different units for each."""
    problem, held = general_like(rng)
    n, q = problem.motions.shape
    rows = 10.0 ** rng.uniform(-12, 12, n)
    columns = 10.0 ** rng.uniform(-12, 12, q)
    same = problem.motions is problem.load_rows
    motions = problem.motions * rows[:, None] * columns
    load_rows = motions if same else problem.load_rows * rows[:, None] * columns
    # Only as products that no rounding moves off the cone of the rows: see `held`.
    held_loads = load_rows.T @ np.abs(rng.standard_normal(n) / rows)
    loads = held_loads if held else problem.loads * columns
    return Trial(
        Problem(
            problem.compliance * np.outer(rows, rows),
            problem.gaps * rows,
            motions,
            load_rows,
            loads,
        ),
        held,
    )


def nearly_dependent(rng: Rng) -> Trial:
    """A rotation and a shift with nearly the same pairs, links that press either way."""
    n = int(rng.integers(4, 40))
    place = np.linspace(0.0, 1.0, n)
    unit = 10.0 ** rng.uniform(-8, 8)
    near = np.exp(-np.abs(place[:, None] - place) / rng.uniform(0.05, 2.0))
    compliance = unit * (near + rng.uniform(0.01, 1.0) * np.eye(n))
    sense = np.where(rng.random(n) < rng.uniform(0.0, 0.5), 1.0, -1.0)
    radius = 10.0 ** rng.uniform(0, 5)
    levers = np.column_stack([radius + rng.uniform(0.1, 3.0) * place, np.ones(n)]) * sense[:, None]
    gaps = 10.0 ** rng.uniform(-2, 2) * (place - rng.uniform(0, 1)) ** 2
    forces = np.abs(rng.standard_normal(n)) * 10.0 ** rng.uniform(-6, 6)
    return Trial(Problem(compliance, gaps, levers, levers, levers.T @ forces), True)


def narrow_cones(rng: Rng) -> Trial:
    """Load rows that differ by 1e-2 … 1e-12 of their size, some of opposite sign."""
    q = int(rng.integers(2, 5))
    n = int(rng.integers(q + 2, 20))
    root = rng.standard_normal((n, n))
    width = np.r_[1.0, 10.0 ** -rng.uniform(2, 12, q - 1)]
    levers = rng.standard_normal(q) + rng.standard_normal((n, q)) * width
    levers[rng.random(n) < rng.uniform(0.0, 0.3)] *= -1.0
    loads = levers.T @ rng.uniform(0.1, 1.0, n) * 10.0 ** rng.uniform(-4, 4)
    compliance = root @ root.T / n + 0.1 * np.eye(n)
    return Trial(Problem(compliance, rng.uniform(-0.3, 1.0, n), levers, levers, loads), True)


def twins(rng: Rng) -> Trial:
    """Pairs that are equal except for 1e-16 … 1e-10 of them, gears with one motion or more."""
    q = int(rng.integers(1, 4))
    n = int(rng.integers(q + 2, 30))
    root = rng.standard_normal((n, n))
    compliance = root @ root.T / n + 0.1 * np.eye(n)
    levers = rng.standard_normal((n, q))
    levers[:, 0] = np.abs(levers[:, 0])
    gaps = rng.uniform(0.0, 1.0, n)
    of = rng.integers(0, n, int(rng.integers(1, n)))
    pairs = np.concatenate([np.arange(n), of])
    apart = 10.0 ** rng.uniform(-16, -10)
    compliance = compliance[np.ix_(pairs, pairs)]
    noise = apart * np.concatenate([np.zeros(n), rng.uniform(0, 1, of.size)])
    compliance = compliance + np.diag(noise)
    loads = levers.T @ np.abs(rng.standard_normal(n))
    return Trial(Problem(compliance, gaps[pairs], levers[pairs], levers[pairs], loads), True)


def whole_numbers(rng: Rng) -> Trial:
    """Ties everywhere: small integers, generated around a state so that one exists exactly."""
    q = int(rng.integers(1, 4))
    n = int(rng.integers(q + 1, 14))
    kind = int(rng.integers(3))
    matrix = rng.integers(-3, 4, (n, n))
    if kind == 0:
        matrix = matrix @ matrix.T
    elif kind == 1:
        matrix = matrix + matrix.T
    np.fill_diagonal(matrix, np.maximum(matrix.diagonal(), rng.integers(1, 6, n)))
    levers = rng.integers(-2, 3, (n, q))
    rows = levers if rng.random() < 0.7 else rng.integers(-2, 3, (n, q))
    forces = rng.integers(0, 4, n) * (rng.random(n) < 0.4)
    open_by = rng.integers(0, 4, n) * (forces == 0)
    gaps = open_by - matrix @ forces + levers @ rng.integers(-3, 4, q)
    columns = levers.astype(float)
    load_rows = columns if rows is levers else rows.astype(float)
    loads = load_rows.T @ forces
    loads[loads == 0] = rng.choice([0.0, -0.0])
    # Otherwise the state leaves a motion free, which no set of pairs in contact shows.
    on = forces > 0
    bordered = np.block([[matrix[np.ix_(on, on)], -levers[on]], [rows[on].T, np.zeros((q, q))]])
    held = bool(np.linalg.matrix_rank(bordered) == len(bordered))
    problem = Problem(matrix.astype(float), gaps.astype(float), columns, load_rows, loads)
    return Trial(problem, True if held else None)


def without_structure(rng: Rng) -> Trial:
    """Random matrices with a positive diagonal: often no state, often several."""
    q = int(rng.integers(1, 4))
    n = int(rng.integers(q + 1, 16))
    matrix = rng.standard_normal((n, n))
    np.fill_diagonal(matrix, rng.uniform(0.2, 1.5, n))
    levers = rng.standard_normal((n, q))
    rows = levers + rng.choice([0.0, 0.3]) * rng.standard_normal((n, q))
    loads = rows.T @ np.abs(rng.standard_normal(n))
    return Trial(Problem(matrix, rng.uniform(-0.3, 1.0, n), levers, rows, loads), None)


def no_load(rng: Rng) -> Trial:
    """Torque 0 or -0.0: gaps, preload or overlap only; K is positive definite."""
    n = int(rng.integers(1, 30))
    root = rng.standard_normal((n, n))
    levers = rng.uniform(rng.choice([0.1, -1.0]), 1.0, (n, 1))
    problem = Problem(
        root @ root.T / n + 0.1 * np.eye(n),
        rng.uniform(rng.choice([0.0, -0.3]), 1.0, n) * 10.0 ** rng.uniform(-6, 6),
        levers,
        levers,
        np.array([rng.choice([0.0, -0.0])]),
    )
    return Trial(problem, True)


KINDS: dict[str, Callable[[Rng], Trial]] = {
    make.__name__: make
    for make in (
        gears,
        general,
        rubbing,
        decades,
        scales,
        nearly_dependent,
        narrow_cones,
        twins,
        whole_numbers,
        without_structure,
        no_load,
    )
}
