"""A flank as a plane curve by arc length: root fillet, active flank and tip in one.

Every body hands over this form: quintic polynomials over intervals of arc length s [mm], from the
root (s = 0) to the tip. Along growing s the material lies on the right: with the unit tangent t,
n = (-t_y, t_x) is the unit normal out of the material.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: u (m,) -> place, first and second derivative by u, each (m, 2).
Place = Callable[[Floats], tuple[Floats, Floats, Floats]]

DEGREE = 5

#: Gauss rule for the arc length of an interval; the intervals are short.
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(12)

#: Parts of an interval at which a fit is compared with the exact curve.
_CHECKED_PARTS = np.array([0.1, 0.3, 0.5, 0.7, 0.9])

#: Halvings of a piece before it is refused: such a piece has a jump.
_MOST_HALVINGS = 50


class CurvePiece(NamedTuple):
    """One smooth piece of an exact profile.

    Attributes
    ----------
    label : str
        What the piece is: "fillet", "flank", "relief", "tip_radius", "tip_chamfer".
    place : callable
        u (m,) -> place, first and second derivative by u, each (m, 2), mm.
    u_start, u_end : float
        Ends of the parameter, in the direction from root to tip.
    corner_before : bool
        The curve has a sharp corner where the piece begins.
    """

    label: str
    place: Place
    u_start: float
    u_end: float
    corner_before: bool = False


@dataclass(frozen=True)
class FlankCurve:
    """A curve by its own arc length, piecewise quintic.

    Attributes
    ----------
    breaks : (n + 1,) array
        Arc length at the ends of the intervals, mm; ascending from 0.
    coefficients : (n, 2, degree + 1) array
        Ascending powers of s - breaks[k], for x and y in mm.
    labels : tuple of n str
        What each interval is.
    corners : (n + 1,) bool array
        True at breaks with a sharp corner; at the last one where the curve ends in a corner.
    """

    breaks: Floats
    coefficients: Floats
    labels: tuple[str, ...]
    corners: NDArray[np.bool_]

    @property
    def length_mm(self) -> float:
        """Arc length of the whole curve."""
        return float(self.breaks[-1])

    def derivatives(self, s: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Place and its first two derivatives by arc length, each (m, 2).

        Parameters
        ----------
        s : (m,) array_like
            Arc length, mm; outside the curve the end interval goes on.
        """
        places = np.atleast_1d(np.asarray(s, dtype=float))
        interval = np.clip(
            np.searchsorted(self.breaks, places, side="right") - 1, 0, len(self.labels) - 1
        )
        x = (places - self.breaks[interval])[:, None]
        c = self.coefficients[interval]
        point, first, second = c[:, :, -1].copy(), np.zeros((x.size, 2)), np.zeros((x.size, 2))
        for power in range(c.shape[2] - 2, -1, -1):
            second = second * x + 2 * first
            first = first * x + point
            point = point * x + c[:, :, power]
        return point, first, second

    def point(self, s: ArrayLike) -> Floats:
        """Places at arc lengths s (m,): (m, 2), mm."""
        return self.derivatives(s)[0]

    def tangent(self, s: ArrayLike) -> Floats:
        """Unit tangents towards the tip at arc lengths s (m,): (m, 2)."""
        first = self.derivatives(s)[1]
        return first / np.linalg.norm(first, axis=1, keepdims=True)

    def normal(self, s: ArrayLike) -> Floats:
        """Unit normals out of the material at arc lengths s (m,): (m, 2)."""
        tangent = self.tangent(s)
        return np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)

    def curvature(self, s: ArrayLike) -> Floats:
        """Curvature at arc lengths s (m,), 1/mm; positive where the flank is convex."""
        _, first, second = self.derivatives(s)
        speed = np.linalg.norm(first, axis=1)
        return (first[:, 1] * second[:, 0] - first[:, 0] * second[:, 1]) / speed**3

    def rotated(self, angle: float) -> FlankCurve:
        """Return the same curve, turned counter-clockwise about the origin by an angle in rad."""
        turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
        return replace(self, coefficients=np.einsum("ij,njk->nik", turn, self.coefficients))

    def range_of(self, *labels: str) -> tuple[float, float]:
        """Arc lengths between which all intervals with one of the labels lie.

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

    def arc_length_of(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Closest places on the curve.

        Parameters
        ----------
        points : (m, 2) array_like
            Places near the curve, mm.

        Returns
        -------
        s, distance : (m,) arrays
            Arc length of the closest place of the curve and its distance (>= 0), mm.
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
        for _ in range(50):
            # Newton on the derivative of half the squared distance, kept between the neighbours
            point, first, second = self.derivatives(s)
            away = point - wanted
            slope = (away * first).sum(axis=1)
            bend = (first**2).sum(axis=1) + (away * second).sum(axis=1)
            step = -slope / np.where(bend > 0, bend, 1.0)
            new = np.clip(s + step, low, high)
            done = np.abs(new - s).max(initial=0.0) <= 4 * np.finfo(float).eps * self.length_mm
            s = new
            if done:
                break
        return s, np.linalg.norm(self.point(s) - wanted, axis=1)


def fit_flank_curve(
    pieces: Sequence[CurvePiece], *, tolerance_mm: float = 1e-10, corner_at_end: bool = False
) -> FlankCurve:
    """Fit exact pieces by quintics in arc length.

    Each interval takes place, unit tangent and curvature vector of the exact curve at its ends
    (quintic Hermite) and is halved until it is within the tolerance of the exact curve, place by
    place at equal arc length.

    Parameters
    ----------
    pieces : sequence of CurvePiece
        In order from root to tip; each begins where the one before ends.
    tolerance_mm : float
        Largest distance of the fit from the exact curve.
    corner_at_end : bool
        The curve ends in a sharp corner.

    Returns
    -------
    FlankCurve

    Raises
    ------
    ValueError
        If there are no pieces, or a piece cannot be fitted (it has a jump).
    """
    if not pieces:
        raise ValueError("pieces: expected at least one piece, found none")
    lengths, coefficients, labels, corners = [], [], [], []
    for piece in pieces:
        part_lengths, part_coefficients = _fit_piece(piece, tolerance_mm)
        lengths.append(part_lengths)
        coefficients.append(part_coefficients)
        labels += [piece.label] * part_lengths.size
        corners += [piece.corner_before] + [False] * (part_lengths.size - 1)
    breaks = np.concatenate([[0.0], np.cumsum(np.concatenate(lengths))])
    return FlankCurve(
        breaks=breaks,
        coefficients=np.concatenate(coefficients),
        labels=tuple(labels),
        corners=np.array([*corners, corner_at_end]),
    )


def _fit_piece(piece: CurvePiece, tolerance: float) -> tuple[Floats, Floats]:
    """Lengths (n,) and coefficients (n, 2, 6) of the intervals of one piece, in order."""
    ends = np.array([[piece.u_start, piece.u_end]], dtype=float)
    done: list[tuple[Floats, Floats, Floats]] = []
    for _ in range(_MOST_HALVINGS):
        lengths = _arc_lengths(piece, ends)
        coefficients = _hermite(piece, ends, lengths)
        good = _deviations(piece, ends, lengths, coefficients) <= tolerance
        done.append((ends[good, 0], lengths[good], coefficients[good]))
        left = ends[~good]
        if not left.size:
            break
        middle = left.mean(axis=1)
        ends = np.concatenate(
            [np.stack([left[:, 0], middle], 1), np.stack([middle, left[:, 1]], 1)]
        )
    else:
        raise ValueError(
            f"piece {piece.label!r}: expected a smooth curve, found a jump near u = {ends[0, 0]:g}"
        )
    starts = np.concatenate([part[0] for part in done])
    order = np.argsort(starts if piece.u_end > piece.u_start else -starts)
    return (
        np.concatenate([part[1] for part in done])[order],
        np.concatenate([part[2] for part in done])[order],
    )


def _arc_lengths(piece: CurvePiece, ends: Floats) -> Floats:
    """Arc length between the two parameters of each row of `ends` (m, 2)."""
    half = 0.5 * (ends[:, 1] - ends[:, 0])
    u = ends.mean(axis=1)[:, None] + half[:, None] * _GAUSS_POINTS
    speed = np.linalg.norm(piece.place(u.ravel())[1], axis=1).reshape(u.shape)
    return np.abs(half) * (speed @ _GAUSS_WEIGHTS)


def _hermite(piece: CurvePiece, ends: Floats, lengths: Floats) -> Floats:
    """Quintics (m, 2, 6) in arc length with the places, tangents and curvatures of the ends."""
    sign = 1.0 if piece.u_end > piece.u_start else -1.0
    values = []
    for u in (ends[:, 0], ends[:, 1]):
        point, first, second = piece.place(u)
        speed = np.linalg.norm(first, axis=1, keepdims=True)
        tangent = first / speed
        along = (second * tangent).sum(axis=1, keepdims=True)
        values += [point, sign * tangent, (second - along * tangent) / speed**2]
    p0, t0, k0, p1, t1, k1 = values
    h = lengths[:, None]
    # what the Taylor polynomial of the near end leaves over at the far end
    place = (p1 - p0 - h * (t0 + 0.5 * h * k0)) / h**3
    slope = (t1 - t0 - h * k0) / h**2
    bend = (k1 - k0) / h
    return np.stack(
        [
            p0,
            t0,
            0.5 * k0,
            10 * place - 4 * slope + 0.5 * bend,
            (-15 * place + 7 * slope - bend) / h,
            (6 * place - 3 * slope + 0.5 * bend) / h**2,
        ],
        axis=2,
    )


def _deviations(piece: CurvePiece, ends: Floats, lengths: Floats, coefficients: Floats) -> Floats:
    """Largest distance (m,) of each interval from the exact curve at equal arc length."""
    low, high = ends.min(axis=1)[:, None], ends.max(axis=1)[:, None]
    span = (ends[:, 1] - ends[:, 0])[:, None]
    wanted = lengths[:, None] * _CHECKED_PARTS
    u = ends[:, :1] + span * _CHECKED_PARTS
    starts = np.broadcast_to(ends[:, :1], u.shape)
    for _ in range(30):
        rows = np.stack([starts.ravel(), u.ravel()], axis=1)
        found = _arc_lengths(piece, rows).reshape(u.shape)
        speed = np.linalg.norm(piece.place(u.ravel())[1], axis=1).reshape(u.shape)
        step = np.sign(span) * (wanted - found) / speed
        u = np.clip(u + step, low, high)
        # the place along the curve is then known to 1e-8 of the interval, across it to its square
        if (np.abs(step) <= 1e-8 * np.abs(span)).all():
            break
    powers = wanted[:, :, None] ** np.arange(DEGREE + 1)
    fitted = np.einsum("mck,mpk->mpc", coefficients, powers)
    exact = piece.place(u.ravel())[0].reshape(fitted.shape)
    worst = np.linalg.norm(fitted - exact, axis=2).max(axis=1)
    # a Gauss rule too coarse for the arc length shows in the two halves
    middle = ends.mean(axis=1)
    halves = _arc_lengths(piece, np.stack([ends[:, 0], middle], 1))
    halves = halves + _arc_lengths(piece, np.stack([middle, ends[:, 1]], 1))
    return np.maximum(worst, np.abs(halves - lengths))


def curve_through_nodes(
    points: ArrayLike, *, label: str = "flank", corner_at_end: bool = True
) -> FlankCurve:
    """Smooth curve through the nodes of a mesh flank.

    A quintic spline over the chord length (not-a-knot ends) through all points, mid-side nodes
    included (cubic below 6 points), then the same curve by its own arc length.

    Parameters
    ----------
    points : (m, 2) array_like
        Nodes in order from root to tip, at least 4, mm.
    label : str
        What the curve is.
    corner_at_end : bool
        The curve ends in a sharp corner.

    Returns
    -------
    FlankCurve

    Raises
    ------
    ValueError
        If there are fewer than 4 points, or two neighbours coincide.
    """
    place, knots = _spline(_checked_nodes(points))
    pieces = [CurvePiece(label, place, a, b) for a, b in pairwise(knots.tolist())]
    return fit_flank_curve(pieces, corner_at_end=corner_at_end)


def nodes_deviation(points: ArrayLike) -> float:
    """Estimate how far `curve_through_nodes` lies from the true profile, mm.

    The curve through every second node is compared at the left-out nodes; the curve through all is
    at least of fourth order in their spacing, so its own distance is a 2^4 - 1 = 15th (Richardson).

    Parameters
    ----------
    points : (m, 2) array_like
        Nodes in order, mm.

    Returns
    -------
    float
        Largest estimated distance; infinite where the nodes are too few to tell (below 7).
    """
    nodes = _checked_nodes(points)
    if nodes.shape[0] < 7:
        return float("inf")
    left_out = np.arange(1, nodes.shape[0] - 1, 2)
    coarse = curve_through_nodes(np.delete(nodes, left_out, axis=0))
    return float(coarse.arc_length_of(nodes[left_out])[1].max()) / 15.0


def _checked_nodes(points: ArrayLike) -> Floats:
    nodes = np.asarray(points, dtype=float)
    if nodes.ndim != 2 or nodes.shape[1] != 2 or nodes.shape[0] < 4:
        raise ValueError(f"points: expected shape (m, 2) with m >= 4, found {nodes.shape}")
    steps = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    if not steps.min() > 1e-12 * steps.max():
        raise ValueError("points: expected different neighbours, found two that coincide")
    return nodes


def _spline(nodes: Floats) -> tuple[Place, Floats]:
    """Spline through the nodes over the chord length, and the chord length at the nodes."""
    from scipy.interpolate import make_interp_spline

    chord = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    knots = np.concatenate([[0.0], np.cumsum(chord)])
    spline = make_interp_spline(knots, nodes, k=5 if len(nodes) >= 6 else 3)
    first, second = spline.derivative(1), spline.derivative(2)

    def place(u: Floats) -> tuple[Floats, Floats, Floats]:
        return spline(u), first(u), second(u)

    return place, knots
