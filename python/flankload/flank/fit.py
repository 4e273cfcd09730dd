"""Fit of exact profile pieces by a curve parametrised by arc length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import is_dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from flankload.base.arrays import Floats
from flankload.base.rotation import lengths_of
from flankload.flank.curve import FlankCurve

#: u (m,) -> point, first and second derivative with respect to u, each (m, 2).
Place = Callable[[Floats], tuple[Floats, Floats, Floats]]

DEGREE = 5

#: Gauss rule for the arc length of an interval.
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(12)

#: Largest distance of a fit from the exact curve, relative to the length of all pieces; it is not
#: less than the rounding error of coordinates, relative to the distance from the axis.
FIT_TOLERANCE, ROUNDING_LIMIT = 1e-11, 256 * float(np.finfo(float).eps)

#: Relative positions in an interval at which a fit is compared with the exact curve.
_CHECKED_PARTS = np.array([0.1, 0.3, 0.5, 0.7, 0.9])

#: Last Newton step to a given arc length, relative to the interval; the remaining distance is
#: evaluated to second order, so that the error is its cube.
_LAST_STEP = 1e-4
#: Number of cached fits, a few kB each.
CACHED_FITS = 256
#: Largest number of halvings; a piece that needs more has a jump and is refused.
_MOST_HALVINGS = 50


class CurvePiece(NamedTuple):
    """One smooth piece of an exact profile.

    Attributes
    ----------
    label : str
        Kind of the piece: "fillet", "flank", "relief", "tip_radius", "tip_chamfer".
    place : callable
        u (m,) -> point, first and second derivative with respect to u, each (m, 2), mm.
    u_start, u_end : float
        Parameter at the ends, in the direction from root to tip.
    corner_before : bool
        The curve has a sharp corner at the start of the piece.
    knots : (k,) array
        Parameters inside the piece, in its direction, at which a higher derivative jumps.
    """

    label: str
    place: Place
    u_start: float
    u_end: float
    corner_before: bool = False
    knots: Floats = np.empty(0)


def fit_flank_curve(
    pieces: Sequence[CurvePiece], *, tolerance_mm: float | None = None, corner_at_end: bool = False
) -> FlankCurve:
    """Fit exact pieces by quintic polynomials in arc length.

    Each interval matches point, unit tangent and curvature vector of the exact curve at its ends
    (quintic Hermite). It is halved until its distance from the exact curve, measured at equal arc
    length, is within the tolerance.

    Parameters
    ----------
    pieces : sequence of CurvePiece
        In order from root to tip; each begins at the end of the previous one.
    tolerance_mm : float, optional
        Largest distance of the fit from the exact curve. Default: proportional to the length of
        the curve, so that curves of all sizes are divided into the same intervals.
    corner_at_end : bool
        The curve ends in a sharp corner.

    Returns
    -------
    FlankCurve

    Raises
    ------
    ValueError
        If there are no pieces, or a piece has a jump.
    """
    if not pieces:
        raise ValueError("pieces: expected at least one piece, found none")
    if tolerance_mm is None:
        tolerance_mm = fit_tolerance_mm(pieces)
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


def fit_tolerance_mm(pieces: Sequence[CurvePiece]) -> float:
    """Default tolerance of a fit, mm.

    Parameters
    ----------
    pieces : sequence of CurvePiece

    Returns
    -------
    float
        Proportional to the length of the curve.
    """
    length = far = 0.0
    for piece in pieces:
        lengths, (end, _, _) = _lengths_and_ends(piece, _intervals(piece))
        start, _, _ = piece.place(np.array([piece.u_start]))
        length += float(lengths.sum())
        far = max(far, float(lengths_of(np.concatenate([start, end])).max()))
    return max(FIT_TOLERANCE * length, ROUNDING_LIMIT * far)


def _fit_piece(piece: CurvePiece, tolerance: float) -> tuple[Floats, Floats]:
    """Lengths (n,) and coefficients (n, 2, 6) of the intervals of one piece, in order.

    Methods of dataclasses (fillets, involutes) are cached, since designs of a body share them.
    """
    owner = getattr(piece.place, "__self__", None)
    if piece.knots.size or not is_dataclass(owner):
        return _fit(piece, tolerance)
    place = (owner, piece.place.__name__)
    return _fit_cached(place, piece.label, piece.u_start, piece.u_end, tolerance)


@lru_cache(maxsize=CACHED_FITS)
def _fit_cached(
    place: tuple[object, str], label: str, start: float, end: float, tolerance: float
) -> tuple[Floats, Floats]:
    """Fit of a piece whose place is the named method of a dataclass."""
    return _fit(CurvePiece(label, getattr(*place), start, end), tolerance)


def _fit(piece: CurvePiece, tolerance: float) -> tuple[Floats, Floats]:
    """Fit of a piece, as from `_fit_piece`."""
    ends = _intervals(piece)
    done: list[tuple[Floats, Floats, Floats]] = []
    lengths = _arc_lengths(piece, ends)
    for _ in range(_MOST_HALVINGS):
        coefficients = _hermite(piece, ends, lengths)
        halves = _halves(ends)
        parts = _arc_lengths(piece, halves)
        # the sum over both halves differs if the Gauss rule is too coarse for the arc length
        worst = np.abs(parts.reshape(2, -1).sum(axis=0) - lengths)
        good = np.maximum(worst, _deviations(piece, ends, lengths, coefficients)) <= tolerance
        done.append((ends[good, 0], lengths[good], coefficients[good]))
        if good.all():
            break
        left = np.tile(~good, 2)
        ends, lengths = halves[left], parts[left]
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


def _intervals(piece: CurvePiece) -> Floats:
    """Both ends (m, 2) of the intervals of a piece between its knots."""
    marks = np.concatenate([[piece.u_start], piece.knots, [piece.u_end]])
    return np.stack([marks[:-1], marks[1:]], axis=1)


def _halves(ends: Floats) -> Floats:
    """Halves of intervals (m, 2): all first halves, then all second halves."""
    middle = ends.mean(axis=1)
    return np.concatenate([np.stack([ends[:, 0], middle], 1), np.stack([middle, ends[:, 1]], 1)])


def _arc_lengths(piece: CurvePiece, ends: Floats) -> Floats:
    """Arc length between the two parameters of each row of `ends` (m, 2)."""
    return _lengths_and_ends(piece, ends)[0]


def _lengths_and_ends(
    piece: CurvePiece, ends: Floats
) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
    """Arc length (m,) of each row of `ends` (m, 2); place and derivatives (m, 2) at its end."""
    half = 0.5 * (ends[:, 1] - ends[:, 0])
    u = ends.mean(axis=1)[:, None] + half[:, None] * _GAUSS_POINTS
    places = piece.place(np.concatenate([u.ravel(), ends[:, 1]]))
    speed = lengths_of(places[1][: u.size]).reshape(u.shape)
    point, first, second = (part[u.size :] for part in places)
    return np.abs(half) * (speed @ _GAUSS_WEIGHTS), (point, first, second)


def _hermite(piece: CurvePiece, ends: Floats, lengths: Floats) -> Floats:
    """Quintics (m, 2, 6) in arc length that match points, tangents and curvatures of the ends."""
    sign = 1.0 if piece.u_end > piece.u_start else -1.0
    point, first, second = piece.place(ends.T.ravel())
    speed = lengths_of(first)[:, None]
    tangent = first / speed
    along = (second * tangent).sum(axis=1, keepdims=True)
    bent = (second - along * tangent) / speed**2
    (p0, p1), (t0, t1), (k0, k1) = (np.split(at, 2) for at in (point, sign * tangent, bent))
    return hermite_quintics((p0, t0, k0), (p1, t1, k1), lengths)


def hermite_quintics(
    near: tuple[Floats, Floats, Floats], far: tuple[Floats, Floats, Floats], lengths: Floats
) -> Floats:
    """Quintics through points with given derivatives at both ends of intervals.

    Parameters
    ----------
    near, far : three (m, 2) arrays
        Points and their first two derivatives at the beginning and at the end.
    lengths : (m,) array
        Lengths of the intervals.

    Returns
    -------
    (m, 2, 6) array
        Coefficients of ascending powers.
    """
    (p0, t0, k0), (p1, t1, k1) = near, far
    h = lengths[:, None]
    # remainders at the far end of the Taylor polynomial about the near end
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
    low, high = (np.repeat(of(axis=1), _CHECKED_PARTS.size) for of in (ends.min, ends.max))
    span = np.repeat(ends[:, 1] - ends[:, 0], _CHECKED_PARTS.size)
    starts = np.repeat(ends[:, 0], _CHECKED_PARTS.size)
    wanted = (lengths[:, None] * _CHECKED_PARTS).ravel()
    u = starts + span * np.tile(_CHECKED_PARTS, len(ends))
    for _ in range(30):
        found, (point, first, second) = _lengths_and_ends(piece, np.stack([starts, u], axis=1))
        speed = lengths_of(first)
        step = np.sign(span) * (wanted - found) / speed
        if (np.abs(step) <= _LAST_STEP * np.abs(span)).all():
            break
        u = np.clip(u + step, low, high)
    # the remaining arc length, to second order
    along = (second * first).sum(axis=1) / speed**2
    bend = second - along[:, None] * first
    exact = point + step[:, None] * first + 0.5 * step[:, None] ** 2 * bend
    powers = wanted.reshape(len(ends), -1, 1) ** np.arange(DEGREE + 1)
    fitted = np.einsum("mck,mpk->mpc", coefficients, powers)
    worst: Floats = lengths_of(fitted - exact.reshape(fitted.shape)).max(axis=1)
    return worst
