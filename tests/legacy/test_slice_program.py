"""Two crowned rollers in slices by a program that knows nothing but the installed library."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flankload import _core
from flankload.contact.body_record import PARTS
from tests.support.crowned_cylinders import KERNEL, hertz_ellipse
from tests.support.programs import EXAMPLES, built, expect_printed, run

Floats = NDArray[np.float64]

FORCES = (1000.0, 4000.0)
LEVER, WIDTH, CROWN, SLOPE = 1000.0, 20.0, 4000.0, 5e-4
RADII = (20.0, 30.0)
EDGES = -10.0 + np.arange(21.0)
#: Line load beside the ellipse of Hertz, in parts of the largest: in a slice at its end the mean
#: of the parabola is not that of its middle.
INSIDE, AT_END = 1.5e-3, 0.02


def roller(radius: float, gaps: Floats, *parts: tuple[str, Floats]) -> Floats:
    """Record of a roller: the same operations as those of the program, in their order."""
    s = np.array([0.6 * radius * i / 8 for i in range(9)])
    coefficients = np.empty((8, 2, 8), order="F")
    for i in range(8):
        q = radius
        for j in range(8):
            turn = 0.5 * math.pi + 0.3 - s[i] / radius - j * 0.5 * math.pi
            coefficients[j, :, i] = q * math.cos(turn), q * math.sin(turn)
            q /= radius * (j + 1)
        coefficients[0, :, i] += LEVER, -radius
    arguments = (
        *(s, coefficients, np.zeros(9, np.intc), np.zeros(20), -gaps, s[[0, -1]], KERNEL),
        *(np.zeros((1, 1, 1), order="F"), np.ones((20, 20), np.intc, order="F")),
    )
    parts = (("axial", np.array([1.0, -10.0, 10.0, 0.0, 0.0, 0.0])), *parts)
    needed = _core.flankload_pack_body(*arguments, np.empty(0))
    record = np.empty(needed + sum(values.size for _, values in parts))
    assert _core.flankload_pack_body(*arguments, record) == 0
    for name, values in parts:
        assert _core.flankload_pack_part(PARTS.index(name) + 1, values, record) == 0
    return record


@pytest.fixture(scope="module")
def solved() -> tuple[Floats, Floats, Floats]:
    """Rotation (2,), line load and pressure (20, 2)."""
    low, high = EDGES[:-1], EDGES[1:]
    gaps = (high * high * high - low * low * low) / (6.0 * CROWN) + SLOPE * (low + 0.5)
    status, rotation, _, _, _, force, pressure, _, info = _core.flankload_sweep(
        20,
        np.array([[0.0], [math.pi], [1.0], [-1.0]], order="F"),
        2.0 * LEVER,
        LEVER * np.array(FORCES),
        roller(RADII[0], gaps, ("slices", EDGES)),
        roller(RADII[1], np.zeros(20)),
        np.array([10.0, 30.0, 2.5, 1.0, 0.0]),
        11,
        np.zeros(2, np.intc),
        np.empty(0, np.intc),
        np.empty(0),
    )
    assert info == 0
    assert (status == 0).all()
    return rotation[0], force[:, 0], pressure[:, 0]


@pytest.mark.parametrize("language", ["c", "modern_fortran"])
def test_crowned_rollers(
    language: str,
    solved: tuple[Floats, Floats, Floats],
    workshop: Path,
    environment: dict[str, str],
) -> None:
    """Every printed digit is that of the sweep from Python; the loads are those of an ellipse."""
    rotation, line_load, pressure = solved
    folder = built(EXAMPLES / language, workshop / language, environment, static=False)
    lines = [line.split() for line in run(folder / "crowned", None, environment).splitlines()]
    starts = [k for k, words in enumerate(lines) if words[0] == "force"]
    assert len(starts) == len(FORCES)
    for t, (first, end) in enumerate(zip(starts, [*starts[1:], len(lines)], strict=True)):
        assert lines[first][:-2] == ["force", f"{FORCES[t]:.0f}", "N,", "status", "0,", "rotation"]
        expect_printed(lines[first][-2], 1e3 * rotation[t])
        rows = lines[first + 2 : end]
        loaded = np.flatnonzero(line_load[:, t])
        assert len(rows) == loaded.size
        ellipse = hertz_ellipse(FORCES[t], 12.0, CROWN)
        largest = 0.75 * FORCES[t] / ellipse.large
        for j, row in zip(loaded, rows, strict=True):
            z = EDGES[j] + 0.5
            zeta = (z + SLOPE * CROWN) / ellipse.large
            assert float(row[0]) == z
            expect_printed(row[1], line_load[j, t])
            expect_printed(row[2], largest * (1.0 - zeta**2))
            expect_printed(row[3], pressure[j, t])
            expect_printed(row[4], ellipse.pressure * math.sqrt(1.0 - zeta**2))
            inside = abs(zeta) + 1.0 / ellipse.large < 1.0
            error = abs(float(row[1]) - float(row[2])) / largest
            assert error < (INSIDE if inside else AT_END)
