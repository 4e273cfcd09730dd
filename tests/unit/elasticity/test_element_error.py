"""Error of the elements in a compliance, on a rectangle: exact fields, finer meshes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from flankload.bodies.body import Material
from flankload.elasticity.fe_error import compliance_error, fillet_difference, recovered_strains
from flankload.meshes.plane_mesh import raise_to_quadratic
from tests.support.plane_stiffness import plane_stiffness
from tests.support.tolerances import ROUND_OFF

STEEL = Material(206000.0, 0.3)
KINDS = ["quad9", "triangle6"]
#: Of the rectangle, mm; left and lower side slide, so that fields are smooth into the corners.
WIDTH, HEIGHT = 2.0, 1.0
#: Elements up the rectangle, and of the finer mesh, four times as many.
ROWS = 6
FINER = 4
#: True error of the meshes over the estimate, below and above: of smooth pressures …
SMOOTH = (0.7, 1.2)
#: … and of even ones on a single element, or half of one.
NARROW = (0.8, 2.5)
#: Order of the energy error of quadratic elements, 4, reduced for two meshes.
LEAST_ORDER = 3.7


def rectangle(
    kind: str, rows: int, *, shaken: float = 0.0
) -> tuple[np.ndarray, tuple[tuple[str, np.ndarray], ...]]:
    """Straight elements; nodes inside moved by up to a part of an element."""
    x, y = np.meshgrid(np.linspace(0, WIDTH, 2 * rows + 1), np.linspace(0, HEIGHT, rows + 1))
    nodes = np.column_stack([x.ravel(), y.ravel()])
    inside = (nodes[:, 0] > 0) & (nodes[:, 0] < WIDTH) & (nodes[:, 1] > 0) & (nodes[:, 1] < HEIGHT)
    moved = np.random.default_rng(3).uniform(-shaken, shaken, nodes.shape) * HEIGHT / rows
    nodes = nodes + inside[:, None] * moved
    number = np.arange(len(nodes)).reshape(x.shape)
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    if kind == "quad9":
        return raise_to_quadratic(nodes, (("quad", np.column_stack([a, b, c, d])),))
    halves = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return raise_to_quadratic(nodes, (("triangle", halves),))


def pressed(nodes: np.ndarray, pressures: list[Callable[[np.ndarray], np.ndarray]]) -> np.ndarray:
    """Loads (2N, p) of pressures on the upper side."""
    top = np.flatnonzero(np.isclose(nodes[:, 1], HEIGHT, rtol=0.0, atol=1e-9))
    top = top[np.argsort(nodes[top, 0])]
    loads = np.zeros((2 * len(nodes), len(pressures)))
    for edge in zip(top[:-2:2], top[1:-1:2], top[2::2], strict=True):
        begin, end = nodes[edge[0], 0], nodes[edge[2], 0]
        at = (np.arange(400) + 0.5) / 400  # midpoints: pressures may end within an element
        shapes = np.stack([(1 - at) * (1 - 2 * at), 4 * at * (1 - at), at * (2 * at - 1)])
        for k, pressure in enumerate(pressures):
            loads[2 * np.array(edge) + 1, k] -= (
                (end - begin) / at.size * shapes @ pressure(begin + at * (end - begin))
            )
    return loads


def solved(
    kind: str, rows: int, pressures: list[Callable[[np.ndarray], np.ndarray]]
) -> tuple[np.ndarray, np.ndarray]:
    """Compliance (p, p) of the pressures, and the estimate of its error."""
    nodes, cells = rectangle(kind, rows)
    slides = [2 * np.flatnonzero(nodes[:, 0] == 0), 2 * np.flatnonzero(nodes[:, 1] == 0) + 1]
    free = np.setdiff1d(np.arange(2 * len(nodes)), np.concatenate(slides))
    loads, moved = pressed(nodes, pressures), np.zeros((2 * len(nodes), len(pressures)))
    matrix = plane_stiffness(nodes, cells, STEEL, "strain")[np.ix_(free, free)]
    moved[free] = spsolve(matrix.tocsc(), loads[free]).reshape(len(free), -1)
    return loads.T @ moved, error_of(nodes, cells, "strain", moved)


def error_of(
    nodes: np.ndarray,
    cells: tuple[tuple[str, np.ndarray], ...],
    plane: str,
    moved: np.ndarray,
) -> np.ndarray:
    smoothed = recovered_strains(nodes, cells, moved)
    return compliance_error(nodes, cells, STEEL, plane, moved, smoothed)


def smooth(x: np.ndarray) -> np.ndarray:
    return 1 + np.cos(np.pi * x / WIDTH)


def smooth_twice(x: np.ndarray) -> np.ndarray:
    return np.cos(2 * np.pi * x / WIDTH) - 1


def even_within(middle: float, half: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda x: (np.abs(x - middle) < half).astype(float)


@cache
def of_smooth(kind: str, rows: int) -> tuple[np.ndarray, np.ndarray]:
    return solved(kind, rows, [smooth, smooth_twice])


def polynomial(nodes: np.ndarray, degree: int) -> np.ndarray:
    """Displacements (2N, p), every one a polynomial of a degree, seeded."""
    x, y = nodes.T
    terms = np.stack([x**i * y**j for i in range(degree + 1) for j in range(degree + 1 - i)])
    factors = np.random.default_rng(5).normal(size=(3, 2, len(terms)))
    return np.einsum("pct,tn->ncp", factors, terms).reshape(2 * len(nodes), 3)


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("degree", [1, 2])
def test_fields_of_the_elements_have_no_error(kind: str, plane: str, degree: int) -> None:
    """Even and linear stresses, on shaken straight elements; cubic displacements are not held."""
    nodes, cells = rectangle(kind, ROWS, shaken=0.2)
    held, beyond = (error_of(nodes, cells, plane, polynomial(nodes, n)) for n in (degree, 3))
    moved = polynomial(nodes, degree)
    energy = moved.T @ (plane_stiffness(nodes, cells, STEEL, plane) @ moved)
    np.testing.assert_allclose(held, 0.0, rtol=0.0, atol=ROUND_OFF * np.abs(energy).max())
    assert np.linalg.eigvalsh(beyond).min() > 1e-7 * np.abs(energy).max()


def test_turning_and_shifting_miss_nothing() -> None:
    nodes, cells = rectangle("quad9", ROWS, shaken=0.2)
    turned = np.column_stack([-nodes[:, 1], nodes[:, 0]]).reshape(-1, 1)
    shifted = np.tile([1.0, -2.0], len(nodes))[:, None]
    fe_error = error_of(nodes, cells, "strain", np.hstack([turned, shifted]))
    scale = STEEL.young_modulus_MPa * WIDTH * HEIGHT
    np.testing.assert_allclose(fe_error, 0.0, rtol=0.0, atol=ROUND_OFF * scale)


@pytest.mark.parametrize("kind", KINDS)
def test_missed_is_symmetric_positive_and_bilinear(kind: str) -> None:
    nodes, cells = rectangle(kind, ROWS, shaken=0.2)
    rng = np.random.default_rng(7)
    moved, mixed = rng.normal(size=(2 * len(nodes), 4)), rng.normal(size=(4, 3))
    fe_error = error_of(nodes, cells, "strain", moved)
    scale = np.abs(fe_error).max()
    np.testing.assert_allclose(fe_error, fe_error.T, rtol=0.0, atol=ROUND_OFF * scale)
    assert np.linalg.eigvalsh(fe_error).min() > 0
    of_mixed = error_of(nodes, cells, "strain", moved @ mixed)
    np.testing.assert_allclose(
        of_mixed, mixed.T @ fe_error @ mixed, rtol=0.0, atol=ROUND_OFF * scale * len(nodes)
    )


@pytest.mark.parametrize("kind", KINDS)
def test_for_smooth_pressures_it_is_the_difference_from_a_finer_mesh(kind: str) -> None:
    """Both pressures, and the one with the other: a matrix, not numbers."""
    coarse, estimated = of_smooth(kind, ROWS)
    fine, _ = of_smooth(kind, FINER * ROWS)
    true = np.linalg.eigvals(np.linalg.solve(estimated, fine - coarse)).real
    assert SMOOTH[0] < true.min()
    assert true.max() < SMOOTH[1]


@pytest.mark.parametrize("kind", KINDS)
def test_it_decreases_like_the_error_of_the_elements(kind: str) -> None:
    estimated = [np.trace(of_smooth(kind, rows)[1]) for rows in (ROWS, 2 * ROWS)]
    assert np.log2(estimated[0] / estimated[1]) > LEAST_ORDER


@pytest.mark.parametrize("half", [0.5, 0.25], ids=["an element", "half of one"])
@pytest.mark.parametrize("kind", KINDS)
def test_of_narrow_pressures_it_is_within_its_band(kind: str, half: float) -> None:
    """Even pressure about the middle of an element, and about a node."""
    size = HEIGHT / ROWS
    pressures = [even_within(middle * size, half * size) for middle in (3.5, 6.0)]
    coarse, estimated = solved(kind, ROWS, pressures)
    fine, _ = solved(kind, FINER * ROWS, pressures)
    true = np.diag(fine - coarse) / np.diag(estimated)
    assert NARROW[0] < true.min()
    assert true.max() < NARROW[1]


def test_difference_in_a_fillet_is_the_largest_one_over_the_largest_strain() -> None:
    """Not that where the strain is largest: there, both may cross."""
    own, recovered = np.array([1.0, 0.5]), np.array([[1.0, 0.0, 0.0], [0.6, 0.0, 0.0]])
    on = SimpleNamespace(nodes=np.arange(2), shapes=np.eye(2), tangents=np.array([[1.0, 0.0]] * 2))
    fillets: Any = SimpleNamespace(on_elements=on, columns=lambda *_: np.eye(2))
    assert fillet_difference(fillets, own[:, None], recovered) == pytest.approx(0.1)
