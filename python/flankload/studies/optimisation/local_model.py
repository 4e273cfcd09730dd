"""Objective and constraints at one point, and their first-order model around it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import FlankloadError

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


@dataclass(frozen=True)
class Maximum:
    """Numbers (k,) at one torque whose largest is the goal or limit, with their gradients (k, n).

    `row` is the number of the goal to which it is added; gradients are those with respect to the
    variables as parts of their ranges.
    """

    row: int
    values: Floats
    gradients: Floats

    def at(self, step: Floats) -> float:
        """Largest number of the model after a step."""
        return float((self.values + self.gradients @ step).max())

    def reachable(self, low: Floats, high: Floats) -> Maximum:
        """The same without the numbers that cannot be the largest within the bounds of a step."""
        up, down = np.maximum(self.gradients, 0.0), np.minimum(self.gradients, 0.0)
        most = self.values + up @ high + down @ low
        least = self.values + up @ low + down @ high
        kept = most >= least.max()
        return Maximum(self.row, self.values[kept], self.gradients[kept])


@dataclass(frozen=True)
class Goals:
    """The merit of a point: the worst objective plus a penalty on violated limits.

    The sums of maxima (r rows) of a point are multiplied by `factors` (o + c, r): one line for each
    of o objectives that could be the worst, one for each of c limits. The margin is subtracted from
    `limits` already, and is their relative distance from the limits that must be kept. `penalty` is
    the merit of the violation of a limit by itself, in the `scale` of the objective.
    """

    factors: Floats
    n_objectives: int
    limits: Floats
    margin: float = 0.0
    scale: float = 1.0
    penalty: float = 10.0

    @property
    def limit_scale(self) -> Floats:
        """Magnitudes of the limits."""
        return np.where(self.limits == 0.0, 1.0, np.abs(self.limits))

    def objective(self, point: Point, step: Floats | None = None) -> float:
        """The worst objective of a point, or of its model after a step."""
        return float((self.factors @ point.rows(step))[: self.n_objectives].max())

    def excess(self, point: Point, step: Floats | None = None) -> Floats:
        """(c,) Amounts by which limits are exceeded, relative to them; negative if kept."""
        sums = (self.factors @ point.rows(step))[self.n_objectives :]
        return np.asarray((sums - self.limits) / self.limit_scale)

    def keeps_limits(self, point: Point) -> bool:
        """Whether all limits are kept, without regard to the margin."""
        return not np.any(self.excess(point) > self.margin / (1.0 + self.margin))

    def merit(self, point: Point, step: Floats | None = None) -> float:
        """Objective in its scale plus penalty."""
        violation = float(np.maximum(self.excess(point, step), 0.0).sum())
        return self.objective(point, step) / self.scale + self.penalty * violation


@dataclass(frozen=True)
class Point:
    """A solved point: the variables (n,) as parts of their ranges, 0 to 1, and its maxima."""

    x: Floats
    maxima: tuple[Maximum, ...]
    n_rows: int

    def within(self, radius: float) -> tuple[Floats, Floats]:
        """Bounds of steps within a radius and the ranges of the variables."""
        return np.maximum(-radius, -self.x), np.minimum(radius, 1.0 - self.x)

    def rows(self, step: Floats | None = None) -> Floats:
        """(r,) Sums of the maxima by their rows, here or after a step of the model."""
        step = np.zeros(self.x.size) if step is None else step
        sums = np.zeros(self.n_rows)
        for maximum in self.maxima:
            sums[maximum.row] += maximum.at(step)
        return sums


def best_step(point: Point, goals: Goals, low: Floats, high: Floats) -> Floats:
    """Step (n,) with the least merit of the model within bounds (n,), as parts of the ranges.

    The epigraph form is a linear program: number t_j is at least each number of maximum j, z is at
    least each objective, and e_c is the excess of limit c (R. Fletcher, Practical Methods of
    Optimization, 2nd ed., chapter 14).

    Raises FlankloadError if numbers are too large or too small for the linear program.
    """
    from scipy.optimize import linprog

    n, m, limits = point.x.size, len(point.maxima), goals.limits.size
    columns = n + m + 1 + limits
    sums = np.zeros((point.n_rows, columns))
    lines, right = [], []
    for j, maximum in enumerate(point.maxima):
        sums[maximum.row, n + j] = 1.0
        near = maximum.reachable(low, high)
        block = np.zeros((near.values.size, columns))
        block[:, :n], block[:, n + j] = near.gradients, -1.0
        lines.append(block)
        right.append(-near.values)
    block = goals.factors @ sums
    objectives = np.arange(goals.n_objectives)
    block[objectives, n + m] = -1.0
    block[goals.n_objectives :] /= goals.limit_scale[:, None]
    block[goals.n_objectives :, n + m + 1 :] = -np.eye(limits)
    lines.append(block)
    right += [np.zeros(goals.n_objectives), goals.limits / goals.limit_scale]
    cost = np.zeros(columns)
    cost[n + m], cost[n + m + 1 :] = 1.0 / goals.scale, goals.penalty
    bounds = [*zip(low, high, strict=True), *[(None, None)] * (m + 1), *[(0.0, None)] * limits]
    found = linprog(
        cost, A_ub=np.vstack(lines), b_ub=np.concatenate(right), bounds=bounds, method="highs"
    )
    if found.x is None:
        raise FlankloadError(f"the linear program of a step has no solution: {found.message}")
    return np.asarray(np.clip(found.x[:n], low, high))
