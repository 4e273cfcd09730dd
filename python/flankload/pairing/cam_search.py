"""Points of a closed profile at which a function vanishes, at many positions at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.flank import FlankCurve

    Floats = NDArray[np.float64]

#: Samples in each interval of the profile, between which zeros are searched.
SAMPLES = 4
MOST_STEPS = 40


@dataclass(frozen=True)
class Places:
    """Points of a profile, (m,) of them: arc lengths, mm, and vectors (m, 2) in its frame.

    `point` is relative to the axis of the profile or to another point; `curvature`, 1/mm, is
    positive where convex.
    """

    s: Floats
    point: Floats
    tangent: Floats
    normal: Floats
    curvature: Floats

    def seen_from(self, apart: Floats) -> Places:
        """The same points relative to another origin: `apart` (m, 2) or (2,) is added."""
        return Places(self.s, self.point + apart, self.tangent, self.normal, self.curvature)

    def repeated(self, count: int) -> Places:
        """All points, repeated `count` times."""
        return Places(
            np.tile(self.s, count),
            np.tile(self.point, (count, 1)),
            np.tile(self.tangent, (count, 1)),
            np.tile(self.normal, (count, 1)),
            np.tile(self.curvature, count),
        )


def places_of(curve: FlankCurve, s: Floats) -> Places:
    """Points of a curve at arc lengths s (m,)."""
    return Places(s, curve.point(s), curve.tangent(s), curve.normal(s), curve.curvature(s))


def samples_of(curve: FlankCurve) -> Places:
    """Points all around a closed curve; the last one equals the first."""
    part = np.arange(SAMPLES) / SAMPLES
    inner = curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * part
    return places_of(curve, np.append(inner.ravel(), curve.length_mm))


def zeros_on(
    curve: FlankCurve,
    samples: Places,
    apart: Floats,
    rest: Callable[[Places], tuple[Floats, Floats]],
) -> tuple[NDArray[np.int64], Floats]:
    """Points of a closed curve at which a function changes its sign, at each position.

    Parameters
    ----------
    samples : Places
        From `samples_of`.
    apart : (P, 2) array
        Vector that is added to the points at each position.
    rest : callable
        Values (m,) at Places (m,), and their derivatives by arc length.

    Returns
    -------
    position, s : (k,) arrays
        Index of the position, and arc length, accurate to rounding.
    """
    count, n = len(apart), samples.s.size
    value, _ = rest(samples.repeated(count).seen_from(np.repeat(apart, n, axis=0)))
    value = value.reshape(count, n)
    value[:, -1] = value[:, 0]
    position, i = np.nonzero((value[:, :-1] < 0) != (value[:, 1:] < 0))
    low, high, below = samples.s[i], samples.s[i + 1], value[position, i] < 0
    s = 0.5 * (low + high)
    for _ in range(MOST_STEPS):
        # Newton's method in an interval that encloses the zero, with bisection as the fallback
        found, slope = rest(places_of(curve, s).seen_from(apart[position]))
        left = (found < 0) == below
        low, high = np.where(left, s, low), np.where(left, high, s)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = s - found / slope
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        done = np.abs(new - s).max(initial=0.0) <= 1e-15 * curve.length_mm
        s = new
        if done:
            break
    return position, s


def first_of(
    count: int, position: NDArray[np.int64], s: Floats, turn: Floats
) -> tuple[Floats, Floats]:
    """Arc length and angle of the least angle at each of `count` positions; NaN if none."""
    order = np.lexsort((turn, position))
    known, first = np.unique(position[order], return_index=True)
    found = np.full((2, count), np.nan)
    found[:, known] = s[order][first], turn[order][first]
    return found[0], found[1]


def wrapped(angle: Floats) -> Floats:
    """Angles in (-pi, pi]."""
    return np.asarray(np.pi - (np.pi - angle) % (2 * np.pi))


def polar(vectors: Floats, turn: Floats) -> Floats:
    """Polar angles in (-pi, pi] of vectors (m, 2) of a frame that is rotated by `turn`."""
    return wrapped(np.arctan2(vectors[:, 1], vectors[:, 0]) + turn)


def dot(a: Floats, b: Floats) -> Floats:
    """Scalar products (m,) of vectors (m, 2)."""
    return np.asarray((a * b).sum(axis=1))


def cross(a: Floats, b: Floats) -> Floats:
    """z components (m,) of the vector products of vectors (m, 2)."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
