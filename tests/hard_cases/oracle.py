"""An independent judge of a state of contact: its own set of pairs solved in 60 digits."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath as mp
import numpy as np

import flankload as fl

EPS = float(np.finfo(float).eps)
DIGITS = 60


@dataclass(frozen=True)
class Verdict:
    """What 60-digit arithmetic says of a state.

    Attributes
    ----------
    forward_error : float
        Largest error of a force, relative to the largest force.
    rotation_error : float
        Error of the rotation, relative to its own size or that of the largest gap angle.
    backward_error : float
        Largest error of a row, gaps and forces of the wrong sign included, relative to its size.
    exact_violation : float
        The same for the exact solution of this set of pairs: wrong signs only.
    """

    forward_error: float
    rotation_error: float
    backward_error: float
    exact_violation: float


def judge(
    matrix: np.ndarray,
    row: np.ndarray,
    gaps: np.ndarray,
    torque: float,
    state: fl.ContactState,
    levers: np.ndarray | None = None,
) -> Verdict:
    """Solve and check the set of pairs of a state; the numbers given are taken as exact."""
    matrix, row, gaps = (np.asarray(part, dtype=float) for part in (matrix, row, gaps))
    n = gaps.size
    levers = np.abs(row) if levers is None else np.asarray(levers, dtype=float)
    active = state.active_pairs.tolist()
    k = len(active)
    with mp.workdps(DIGITS):
        a = [[mp.mpf(float(entry)) for entry in line] for line in matrix]
        m = [mp.mpf(float(entry)) for entry in row]
        e = [mp.mpf(float(entry)) for entry in gaps]
        load = mp.mpf(float(torque))
        bordered = mp.zeros(k + 1)
        right = mp.zeros(k + 1, 1)
        for r, i in enumerate(active):
            for c, j in enumerate(active):
                bordered[r, c] = a[i][j]
            bordered[r, k] = -1
            bordered[k, r] = m[i] / max(abs(part) for part in m)
            right[r] = -e[i]
        right[k] = load / max(abs(part) for part in m)
        exact = mp.lu_solve(bordered, right)
        forces = [mp.mpf(0)] * n
        for r, i in enumerate(active):
            forces[i] = exact[r]
        rotation = exact[k]
        largest = max(abs(force) for force in forces)
        given = [mp.mpf(float(force)) for force in state.normal_forces]
        turned = mp.mpf(float(state.rotation))

        def row_errors(force: list[mp.mpf], phi: mp.mpf, *, closed: bool) -> mp.mpf:
            worst = mp.mpf(0)
            for i in range(n):
                terms = [a[i][j] * force[j] for j in active]
                size = sum(map(abs, terms)) + abs(e[i]) + abs(phi)
                gap = sum(terms) + e[i] - phi
                wrong = abs(gap) if closed and i in active else max(-gap, mp.mpf(0))
                worst = max(worst, wrong / size if size else wrong)
                worst = max(worst, -force[i] / largest)
            return worst

        held = sum(m[i] * given[i] for i in range(n))
        size = sum(abs(m[i] * given[i]) for i in range(n)) + load
        turn = max(abs(rotation), *(abs(part) for part in e))
        return Verdict(
            forward_error=float(
                max(abs(x - y) for x, y in zip(given, forces, strict=True)) / largest
            ),
            rotation_error=float(abs(turned - rotation) / turn),
            backward_error=float(
                max(row_errors(given, turned, closed=True), abs(held - load) / size)
            ),
            exact_violation=float(row_errors(forces, rotation, closed=False)),
        )
