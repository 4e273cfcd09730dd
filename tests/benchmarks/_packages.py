"""Packages that solve the contact problem as a quadratic program or as a linear complementarity
problem, each called in the way that suits it best, on one thread, with its tightest tolerances.

Without friction the problem is min ½ FᵀK F + g0ᵀF with F >= 0 and mᵀF = M; the multiplier of the
equation is φ. With friction K is not symmetric, and what remains is complementarity.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from tests.support.cylinder_problem import Problem, Vector

#: Scaled forces, and the seconds that finding them took.
Found = tuple[Vector, float]
NO_BOUND = 1e20


@dataclass(frozen=True)
class Scaled:
    """A problem with unit diagonal, largest torque lever one and torque one.

    Attributes
    ----------
    matrix, gaps, levers, row : ndarray
        K, g0, b and m.
    unit : ndarray of shape (n,)
        Force of each pair [N] whose scaled force is one.
    """

    matrix: Vector
    gaps: Vector
    levers: Vector
    row: Vector
    unit: Vector

    @property
    def symmetric(self) -> bool:
        """There is no friction."""
        return bool((self.matrix == self.matrix.T).all() and (self.row == self.levers).all())


@dataclass(frozen=True)
class Package:
    """A package, how it is called, and what of it is timed.

    Attributes
    ----------
    name, module : str
        As it is installed, as it is imported.
    solve : callable
        Takes a scaled problem; only what `timed` says is counted.
    timed : str
    friction : bool
        Solves problems with friction too.
    """

    name: str
    module: str
    solve: Callable[[Scaled], Found]
    timed: str
    friction: bool = False


def scale(problem: Problem) -> Scaled:
    """Scale a problem as packages like it best."""
    rows = 1.0 / np.sqrt(problem.compliance.diagonal())
    lever = (rows * problem.row).max()
    load = problem.torque / lever
    return Scaled(
        matrix=np.ascontiguousarray(problem.compliance * (rows[:, None] * rows)),
        gaps=rows * problem.gaps / load,
        levers=rows * problem.levers / lever,
        row=rows * problem.row / lever,
        unit=rows * load,
    )


def solve_daqp(scaled: Scaled) -> Found:
    """Dual active set; with friction as an affine variational inequality, rows weighted by m/b."""
    import daqp

    n = scaled.gaps.size
    weight = scaled.row / scaled.levers
    words = {} if scaled.symmetric else {"is_avi": True}
    forces, _, _, info = daqp.solve(
        weight[:, None] * scaled.matrix,
        weight * scaled.gaps,
        scaled.row[None, :].copy(),
        np.append(np.full(n, NO_BOUND), 1.0),
        np.append(np.zeros(n), 1.0),
        np.append(np.zeros(n), 5).astype(np.int32),
        primal_tol=1e-13,
        dual_tol=1e-13,
        iter_limit=100000,
        eps_prox=0.0,
        **words,
    )
    return np.asarray(forces), info["solve_time"]


def solve_quadprog(scaled: Scaled) -> Found:
    """Goldfarb and Idnani."""
    import quadprog

    n = scaled.gaps.size
    constraints = np.column_stack((scaled.row, np.eye(n)))
    bounds = np.append(1.0, np.zeros(n))
    start = time.perf_counter()
    forces = quadprog.solve_qp(scaled.matrix, -scaled.gaps, constraints, bounds, 1)[0]
    return forces, time.perf_counter() - start


def solve_proxsuite(scaled: Scaled) -> Found:
    """Proximal augmented Lagrangian, dense, forces as a box."""
    from proxsuite import proxqp

    n = scaled.gaps.size
    program = proxqp.dense.QP(n, 1, 0, True)
    program.settings.eps_abs = 1e-12
    program.settings.eps_rel = 0.0
    program.settings.initial_guess = proxqp.InitialGuess.NO_INITIAL_GUESS
    program.init(
        scaled.matrix,
        scaled.gaps,
        scaled.row[None, :],
        np.ones(1),
        l_box=np.zeros(n),
        u_box=np.full(n, NO_BOUND),
    )
    start = time.perf_counter()
    program.solve()
    return np.array(program.results.x), time.perf_counter() - start


def solve_highs(scaled: Scaled) -> Found:
    """Active set of HiGHS."""
    import highspy

    n = scaled.gaps.size
    solver = highspy.Highs()
    options: dict[str, bool | str | float] = {
        "output_flag": False,
        "threads": 1,
        "parallel": "off",
        "primal_feasibility_tolerance": 1e-10,
        "dual_feasibility_tolerance": 1e-10,
        "qp_regularization_value": 0.0,
    }
    for name, value in options.items():
        solver.setOptionValue(name, value)
    model = highspy.HighsModel()
    program, hessian = model.lp_, model.hessian_
    program.num_col_, program.num_row_ = n, 1
    program.col_cost_ = scaled.gaps
    program.col_lower_, program.col_upper_ = np.zeros(n), np.full(n, highspy.kHighsInf)
    program.row_lower_ = program.row_upper_ = np.ones(1)
    program.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    program.a_matrix_.start_ = np.array([0, n])
    program.a_matrix_.index_ = np.arange(n)
    program.a_matrix_.value_ = scaled.row
    # The lower triangle by columns, which is the upper one by rows.
    hessian.dim_, hessian.format_ = n, highspy.HessianFormat.kTriangular
    row, column = np.triu_indices(n)
    hessian.start_ = np.append(0, np.cumsum(np.arange(n, 0, -1)))
    hessian.index_, hessian.value_ = column, scaled.matrix[row, column]
    solver.passModel(model)
    start = time.perf_counter()
    solver.run()
    seconds = time.perf_counter() - start
    return np.array(solver.getSolution().col_value), seconds


def solve_lemke(scaled: Scaled) -> Found:
    """Lemke's method for forces and rotation; the torque is the row that belongs to φ."""
    from quantecon.optimize import lcp_lemke

    n = scaled.gaps.size
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n], matrix[:n, n], matrix[n, :n] = scaled.matrix, -scaled.levers, scaled.row
    right = np.append(scaled.gaps, -1.0)
    start = time.perf_counter()
    found = lcp_lemke(matrix, right)
    seconds = time.perf_counter() - start
    return found.z[:n] if found.success else np.full(n, np.nan), seconds


def solve_nnls(scaled: Scaled) -> Found:
    """Non-negative least squares for the point of a polytope next to the origin, which is exact.

    With K = L Lᵀ and y = m F the energy is ½ |P y|² + const where Σ y = 1 and
    P = Lᵀ diag(m)⁻¹ + (L⁻¹ g0) 1ᵀ. Minimising |P y|² + w² (Σ y - 1)² over y >= 0 instead only
    shortens y, whatever w.
    """
    from scipy.optimize import nnls

    n = scaled.gaps.size
    factor = cholesky(scaled.matrix, lower=True)
    center = solve_triangular(factor, scaled.gaps, lower=True)
    columns = factor.T / scaled.row + center[:, None]
    size = np.linalg.norm(columns, axis=0).min()
    matrix = np.vstack((columns, np.full((1, n), size)))
    right = np.append(np.zeros(n), size)
    start = time.perf_counter()
    parts, _ = nnls(matrix, right)
    seconds = time.perf_counter() - start
    return parts / (parts.sum() * scaled.row), seconds


PACKAGES = (
    Package("daqp", "daqp", solve_daqp, "its solve time, factor of K not counted", friction=True),
    Package("quadprog", "quadprog", solve_quadprog, "solve_qp"),
    Package("proxsuite", "proxsuite", solve_proxsuite, "dense QP.solve after init"),
    Package("highspy", "highspy", solve_highs, "Highs.run after passModel"),
    Package("quantecon", "quantecon", solve_lemke, "lcp_lemke, compiled before", friction=True),
    Package("scipy", "scipy", solve_nnls, "nnls, factor of K not counted"),
)
