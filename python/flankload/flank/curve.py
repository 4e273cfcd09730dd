"""The flank curve: points, tangents, normals and curvature at arc lengths, and closest points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, sin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flankload.base.arrays import Floats
from flankload.base.rotation import lengths_of

#: Largest gap (relative to the length) and angle (rad) between the ends of a closed curve.
CLOSURE_GAP, CLOSURE_ANGLE = 1e-9, 1e-6
#: Labels of the active flank, without fillet and tip.
ACTIVE = ("root_relief", "flank", "relief")


@dataclass(frozen=True)
class FlankCurve:
    """A plane curve parametrised by arc length, piecewise quintic.

    Attributes
    ----------
    breaks : (n + 1,) array
        Arc length at the ends of the intervals, mm, ascending; a complete curve begins at 0.
    coefficients : (n, 2, degree + 1) array
        Coefficients of ascending powers of s - breaks[k], for x and y in mm.
    labels : tuple of n str
        Label of each interval.
    corners : (n + 1,) bool array
        True at breaks with a sharp corner; the last entry: the curve ends in a corner.
    """

    breaks: Floats
    coefficients: Floats
    labels: tuple[str, ...]
    corners: NDArray[np.bool_]

    @property
    def length_mm(self) -> float:
        """Arc length of the complete curve, mm."""
        return float(self.breaks[-1])

    @cached_property
    def closed(self) -> bool:
        """Whether the curve is closed and smooth at its ends: one turn around a body."""
        if self.corners[0] or self.corners[-1]:
            return False
        ends = [0.0, self.length_mm]
        apart = np.diff(self.point(ends), axis=0), np.diff(self.tangent(ends), axis=0)
        return bool(
            np.linalg.norm(apart[0]) <= CLOSURE_GAP * self.length_mm
            and np.linalg.norm(apart[1]) <= CLOSURE_ANGLE
        )

    def derivatives(self, s: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Point and its first two derivatives by arc length, each (m, 2).

        Parameters
        ----------
        s : (m,) array_like
            Arc length, mm; beyond the ends the end intervals are extrapolated.
        """
        point, first, second = self._by_arc_length(s, 2)
        return point, first, second

    def _by_arc_length(self, s: ArrayLike, order: int) -> list[Floats]:
        """Point and its derivatives up to an order, each (m, 2), by Horner's rule."""
        places = np.atleast_1d(np.asarray(s, dtype=float))
        interval = np.searchsorted(self.breaks[1:-1], places, side="right")
        x = (places - self.breaks[interval])[:, None]
        c = self.coefficients[interval]
        values = [c[:, :, -1].copy(), *(np.zeros((x.size, 2)) for _ in range(order))]
        for power in range(c.shape[2] - 2, -1, -1):
            for k in range(order, 0, -1):
                values[k] = values[k] * x + k * values[k - 1]
            values[0] = values[0] * x + c[:, :, power]
        return values

    def point(self, s: ArrayLike) -> Floats:
        """Points at arc lengths s (m,): (m, 2), mm."""
        return self._by_arc_length(s, 0)[0]

    def tangent(self, s: ArrayLike) -> Floats:
        """Unit tangents towards the tip at arc lengths s (m,): (m, 2)."""
        first = self._by_arc_length(s, 1)[1]
        return first / lengths_of(first)[:, None]

    def normal(self, s: ArrayLike) -> Floats:
        """Outward unit normals at arc lengths s (m,): (m, 2)."""
        tangent = self.tangent(s)
        return np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)

    def curvature(self, s: ArrayLike) -> Floats:
        """Curvature at arc lengths s (m,), 1/mm; positive where the flank is convex."""
        _, first, second = self.derivatives(s)
        speed = lengths_of(first)
        return (first[:, 1] * second[:, 0] - first[:, 0] * second[:, 1]) / speed**3

    def rotated(self, angle: float) -> FlankCurve:
        """Return the curve, rotated counter-clockwise about the origin by an angle in rad."""
        turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
        return replace(self, coefficients=np.einsum("ij,njk->nik", turn, self.coefficients))

    def range_of(self, *labels: str) -> tuple[float, float]:
        """Start and end of the range of arc length that contains all intervals with the labels.

        Raises
        ------
        ValueError
            If no interval has one of the labels.
        """
        found = [k for k, label in enumerate(self.labels) if label in labels]
        if not found:
            raise ValueError(
                f"labels: expected some of {sorted(set(self.labels))}, found {list(labels)}"
            )
        return float(self.breaks[found[0]]), float(self.breaks[found[-1] + 1])

    @property
    def active_range(self) -> tuple[float, float]:
        """Arc lengths of the flank with its reliefs; those of all the curve without such labels."""
        if not set(ACTIVE) & set(self.labels):
            return 0.0, self.length_mm
        return self.range_of(*ACTIVE)

    def cut(self, low: float, high: float) -> FlankCurve:
        """Return the part between two breaks, with the same arc lengths and corners at its ends.

        Parameters
        ----------
        low, high : float
            Arc lengths of two breaks, mm.
        """
        first, last = np.searchsorted(self.breaks, [low, high])
        corners = self.corners[first : last + 1].copy()
        corners[[0, -1]] = True
        return FlankCurve(
            breaks=self.breaks[first : last + 1],
            coefficients=self.coefficients[first:last],
            labels=self.labels[first:last],
            corners=corners,
        )

    def arc_length_of(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Closest points of the curve.

        Parameters
        ----------
        points : (m, 2) array_like
            Points near the curve, mm.

        Returns
        -------
        s, distance : (m,) arrays
            Arc length of the closest point of the curve, and its distance (>= 0), mm.
        """
        wanted = np.atleast_2d(np.asarray(points, dtype=float))
        parts = np.arange(8) / 8
        samples = np.append(
            (self.breaks[:-1, None] + np.diff(self.breaks)[:, None] * parts).ravel(),
            self.breaks[-1],
        )
        squares = ((wanted[:, None, :] - self.point(samples)[None, :, :]) ** 2).sum(axis=2)
        nearest = np.argmin(squares, axis=1)
        low = samples[np.maximum(nearest - 1, 0)]
        high = samples[np.minimum(nearest + 1, samples.size - 1)]
        s = samples[nearest]
        round_off = 4 * np.finfo(float).eps * max(self.length_mm, np.abs(wanted).max(initial=0.0))
        for _ in range(50):
            # Newton's method for the derivative of half the squared distance, within [low, high]
            point, first, second = self.derivatives(s)
            away = point - wanted
            slope = (away * first).sum(axis=1)
            bend = (first**2).sum(axis=1) + (away * second).sum(axis=1)
            step = -slope / np.where(bend > 0, bend, 1.0)
            new = np.clip(s + step, low, high)
            done = np.abs(new - s).max(initial=0.0) <= round_off
            s = new
            if done:
                break
        return s, lengths_of(self.point(s) - wanted)
