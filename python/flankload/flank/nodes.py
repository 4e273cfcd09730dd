"""Curves through the nodes of a mesh, for flanks without a known exact profile."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from flankload.base.arrays import Floats
from flankload.flank.curve import FlankCurve
from flankload.flank.fit import CurvePiece, Place, fit_flank_curve
from flankload.flank.spline import interpolating_spline

#: Newton's steps to the closest point of a curve end when they are this part of its length.
NEAR, MOST_STEPS = 1e-12, 50


def curve_through_nodes(points: ArrayLike) -> FlankCurve:
    """Smooth curve through the nodes of a mesh flank.

    Quintic spline over the chord length (not-a-knot ends) through all points, including mid-side
    nodes (cubic for fewer than 6 points), refitted as a function of arc length. It ends in a sharp
    corner.

    Parameters
    ----------
    points : (m, 2) array_like
        Nodes in order from root to tip, at least 4, mm.

    Returns
    -------
    FlankCurve

    Raises
    ------
    ValueError
        If there are fewer than 4 points, or two neighbours coincide.
    """
    place, knots = _spline(_checked_nodes(points))
    piece = CurvePiece("flank", place, float(knots[0]), float(knots[-1]), knots=knots[1:-1])
    return fit_flank_curve([piece], corner_at_end=True)


def nodes_deviation(points: ArrayLike) -> float:
    """Estimate the distance of `curve_through_nodes` from the true profile, mm.

    The curve through every second node is compared with the omitted nodes. The error of the curve
    through all nodes is at least of fourth order in their spacing, hence 1/(2^4 - 1) = 1/15 of
    that distance (Richardson).

    Parameters
    ----------
    points : (m, 2) array_like
        Nodes in order, mm.

    Returns
    -------
    float
        Largest estimated distance; infinite for fewer than 7 nodes, which do not suffice.
    """
    nodes = _checked_nodes(points)
    if nodes.shape[0] < 7:
        return float("inf")
    left_out = np.arange(1, nodes.shape[0] - 1, 2)
    place, knots = _spline(np.delete(nodes, left_out, axis=0))
    # the kept node before node 2 k + 1 is number k
    start, wanted = knots[: left_out.size], nodes[left_out]
    u = start + np.linalg.norm(wanted - nodes[left_out - 1], axis=1)
    for _ in range(MOST_STEPS):
        # Newton's method for the derivative of half the squared distance
        point, first, second = place(u)
        away = point - wanted
        bend = (first**2).sum(axis=1) + (away * second).sum(axis=1)
        step = -(away * first).sum(axis=1) / np.where(bend > 0, bend, 1.0)
        u = np.clip(u + step, start, knots[1 : left_out.size + 1])
        if np.abs(step).max() <= NEAR * knots[-1]:
            break
    return float(np.linalg.norm(place(u)[0] - wanted, axis=1).max()) / 15.0


def _checked_nodes(points: ArrayLike) -> Floats:
    nodes = np.asarray(points, dtype=float)
    if nodes.ndim != 2 or nodes.shape[1] != 2 or nodes.shape[0] < 4:
        raise ValueError(f"points: expected shape (m, 2) with m >= 4, found {nodes.shape}")
    steps = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    if not steps.min() > 1e-12 * steps.max():
        raise ValueError("points: expected different neighbours, found two that coincide")
    return nodes


def _spline(nodes: Floats) -> tuple[Place, Floats]:
    """Spline through the nodes over the chord length; chord length of each node."""
    chord = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    knots = np.concatenate([[0.0], np.cumsum(chord)])
    spline = interpolating_spline(knots, nodes, degree=5 if len(nodes) >= 6 else 3)
    return spline.derivatives, knots
