"""Fit of exact profile pieces by a curve parametrised by arc length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import is_dataclass
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np

from flankload.base.arrays import Floats
from flankload.base.rotation import lengths_of
from flankload.flank.curve import FlankCurve

#: u (m,) -> point, first and second derivative with respect to u, each (m, 2).
Place = Callable[[Floats], tuple[Floats, Floats, Floats]]

T = TypeVar("T")

DEGREE = 5

#: Gauss rule for the arc length of an interval.
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(12)


def _integrals_from_start(points: Floats) -> Floats:
    """Matrix of the integrals from -1 to each point of the polynomial through all points."""
    form = np.polynomial.legendre
    number = np.eye(points.size)
    to_coefficients = np.linalg.inv(form.legvander(points, points.size - 1))
    matrix: Floats = form.legval(points, form.legint(number, lbnd=-1.0)).T @ to_coefficients
    return matrix


#: Arc lengths from the start of an interval to its Gauss points, from the speeds there.
_PARTS = _integrals_from_start(_GAUSS_POINTS)

#: Largest distance of a fit from the exact curve, relative to the length of all pieces; it is not
#: less than the rounding error of coordinates, relative to the distance from the axis.
FIT_TOLERANCE, ROUNDING_LIMIT = 1e-11, 256 * float(np.finfo(float).eps)

#: Number of cached fits, a few kB each, and sizes of pieces.
CACHED_FITS = 512
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
    length at the points of a Gauss rule, is within the tolerance.

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
        part_lengths, part_coefficients = _cached(_fit, piece, tolerance_mm)
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
    sizes = [_cached(_length_and_reach, piece) for piece in pieces]
    length, reach = sum(size[0] for size in sizes), max(size[1] for size in sizes)
    return max(FIT_TOLERANCE * length, ROUNDING_LIMIT * reach)


def _length_and_reach(piece: CurvePiece) -> tuple[float, float]:
    """Arc length of a piece and its largest distance from the axis, mm."""
    found = _evaluated(piece, _intervals(piece))
    return float(found.lengths.sum()), float(lengths_of(found.points).max())


def _cached(call: Callable[..., T], piece: CurvePiece, *others: float) -> T:
    """Call a function of a piece.

    Methods of dataclasses (fillets, involutes) are cached, since designs of a body share them.
    """
    owner = getattr(piece.place, "__self__", None)
    if piece.knots.size or not is_dataclass(owner):
        return call(piece, *others)
    place = (owner, piece.place.__name__)
    found: T = _of_method(call, place, piece.label, piece.u_start, piece.u_end, *others)
    return found


@lru_cache(maxsize=CACHED_FITS)
def _of_method(
    call: Callable[..., T],
    place: tuple[object, str],
    label: str,
    start: float,
    end: float,
    *others: float,
) -> T:
    """Call a function of a piece whose place is the named method of a dataclass."""
    return call(CurvePiece(label, getattr(*place), start, end), *others)


class _Evaluated(NamedTuple):
    """A piece in intervals: at the start of each, at its Gauss points, and at its end.

    Attributes
    ----------
    ends : (m, 2) array
        Parameters at both ends.
    lengths, parts : (m,) and (m, 12) arrays
        Arc lengths of the intervals, and from their starts to the Gauss points.
    points, first, second : (m, 14, 2) arrays
        Points and derivatives by the parameter.
    """

    ends: Floats
    lengths: Floats
    parts: Floats
    points: Floats
    first: Floats
    second: Floats


def _fit(piece: CurvePiece, tolerance: float) -> tuple[Floats, Floats]:
    """Lengths (n,) and coefficients (n, 2, 6) of the intervals of one piece, in order."""
    done: list[tuple[Floats, Floats, Floats]] = []
    found = _evaluated(piece, _intervals(piece))
    for _ in range(_MOST_HALVINGS):
        coefficients = _hermite(found, backward=piece.u_end < piece.u_start)
        halves = _evaluated(piece, _halves(found.ends))
        # the sum over both halves differs if the Gauss rule is too coarse for the arc length
        worst = np.abs(halves.lengths.reshape(2, -1).sum(axis=0) - found.lengths)
        good = np.maximum(worst, _deviations(found, coefficients)) <= tolerance
        done.append((found.ends[good, 0], found.lengths[good], coefficients[good]))
        if good.all():
            break
        left = np.tile(~good, 2)
        found = _Evaluated(*(values[left] for values in halves))
    else:
        raise ValueError(
            f"piece {piece.label!r}: expected a smooth curve, found a jump near "
            f"u = {found.ends[0, 0]:g}"
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


def _evaluated(piece: CurvePiece, ends: Floats) -> _Evaluated:
    """Evaluate a piece in intervals between the two parameters of each row of `ends` (m, 2)."""
    half = 0.5 * (ends[:, 1:] - ends[:, :1])
    middle = ends.mean(axis=1, keepdims=True)
    u = np.concatenate([ends[:, :1], middle + half * _GAUSS_POINTS, ends[:, 1:]], axis=1)
    points, first, second = (part.reshape(*u.shape, 2) for part in piece.place(u.ravel()))
    speed = np.abs(half) * lengths_of(first[:, 1:-1])
    return _Evaluated(ends, speed @ _GAUSS_WEIGHTS, speed @ _PARTS.T, points, first, second)


def _hermite(found: _Evaluated, *, backward: bool) -> Floats:
    """Quintics (m, 2, 6) in arc length that match points, tangents and curvatures of the ends.

    `backward`: the parameter falls along the curve.
    """
    point, first, second = (of[:, [0, -1]] for of in (found.points, found.first, found.second))
    speed = lengths_of(first)[..., np.newaxis]
    tangent = first / speed
    along = (second * tangent).sum(axis=2, keepdims=True)
    bent = (second - along * tangent) / speed**2
    if backward:
        tangent = -tangent
    near, far = ((point[:, k], tangent[:, k], bent[:, k]) for k in (0, 1))
    return hermite_quintics(near, far, found.lengths)


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


def _deviations(found: _Evaluated, coefficients: Floats) -> Floats:
    """Largest distance (m,) of each interval from the exact curve at equal arc length."""
    powers = found.parts[..., np.newaxis] ** np.arange(DEGREE + 1)
    fitted = np.einsum("mck,mpk->mpc", coefficients, powers)
    worst: Floats = lengths_of(fitted - found.points[:, 1:-1]).max(axis=1)
    return worst
