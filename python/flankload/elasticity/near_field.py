"""Pressure modes on a flank, their consistent loads, and the analytic near field.

The compliance of a flank is the sum of the logarithm of a half-plane, K(s, s') = -c0 ln|s - s'|, on
the same flank, and a smooth remainder in terms of Legendre modes over the arc length. These modes
are the unit loads of the finite elements; the displacement under nodal forces would have no limit
under refinement.

The near field of tangential loads is a jump of the normal displacement, -j sign(s - s'): the
surface moves inwards in front of the load, outwards behind it.

At a free corner at the end of the modes, the near field has a mirror image behind the corner,
-c0 psi ln(d + d') (`bodies.free_corner`).

On a closed flank (a cam) of length L, the modes are harmonics, and the logarithm is that of the
chord, K(s, s') = -c0 ln|(L/pi) sin(pi (s - s')/L)|.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.polynomial.legendre import legvander

from flankload.base.gauss import leggauss
from flankload.bodies.body import MeshedFlank
from flankload.bodies.tip_modes import (
    Tip,
    image_with_tip,
    on_tip,
    projected_with_tip,
    tip_modes,
    tip_values,
)
from flankload.elasticity.finite_elements import plane_moduli
from flankload.elasticity.fronts.mirror import axis_of, reflection

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Material, SectorMesh

#: Largest distance between a node and the mirror image of another one, over the size of the mesh.
MIRROR_TOLERANCE = 1e-9
#: Gauss points for ln(1 + t) on [0, 1], besides those for the modes; each divides the error by 30.
LOGARITHM_POINTS = 14


def logarithm_strength(material: Material, plane: str) -> float:
    """c0 (mm²/N) of the normal displacement -c0 ln(distance) of a half-plane per force and width.

    2/(pi E'): 2 (1 - nu²)/(pi E) in plane strain, 2/(pi E) in plane stress.
    """
    return 2.0 / (np.pi * plane_moduli(material, plane)[0])


def jump_strength(material: Material, plane: str) -> float:
    """j (mm²/N) of the normal displacement of a half-plane per tangential force and width.

    Out of the material, -j in front of the force and j behind it, at any distance:
    (1 - nu')/(2 E'), (1 - 2 nu)(1 + nu)/(2 E) in plane strain; K. L. Johnson, Contact Mechanics,
    (2.23).
    """
    modulus, ratio = plane_moduli(material, plane)
    return (1.0 - ratio) / (2.0 * modulus)


def mode_values(
    s: Floats,
    mode_range_mm: tuple[float, float],
    n_modes: int,
    *,
    closed: bool = False,
    tip: Tip | None = None,
) -> Floats:
    """Legendre polynomials P_0 … P_(n_modes - 1) at arc lengths (n,), mm: (n, n_modes).

    On a closed flank, 1, cos t, sin t, cos 2t, … with t from 0 to 2 pi instead. With a tip behind
    the range, the last modes are those of the tip (`tip_modes`), on which the others keep their end
    values.
    """
    low, high = mode_range_mm
    if tip is not None:
        s = np.asarray(s, dtype=float)
        own = tip_modes(n_modes)
        flank = mode_values(np.minimum(s, high), mode_range_mm, n_modes - own)
        return np.hstack([flank, tip_values(s, high, tip, own)])
    if closed:
        turn = 2 * np.pi * (np.asarray(s, dtype=float) - low) / (high - low)
        order = np.arange(1, n_modes + 1) // 2  # 0, 1, 1, 2, 2, …
        phase = turn[:, None] * order
        return np.where(np.arange(n_modes) % 2 | (order == 0), np.cos(phase), np.sin(phase))
    values = legvander((2.0 * np.asarray(s) - low - high) / (high - low), n_modes - 1)
    return np.asarray(values, dtype=np.float64)


def to_coefficients(
    moments: Floats, mode_range_mm: tuple[float, float], *, tip: Tip | None = None
) -> Floats:
    """Mode coefficients (n_modes, …) of functions from their integrals with the modes.

    The integrals are over the range of the modes and over the tip behind it.
    """
    n_modes = len(moments)
    if tip is None:
        norms = mode_norms(mode_range_mm, n_modes)
        return np.asarray(moments / norms.reshape(-1, *[1] * (moments.ndim - 1)))
    products = mode_products(mode_range_mm, n_modes, tip)
    found = np.linalg.solve(products, moments.reshape(n_modes, -1))
    return np.asarray(found.reshape(moments.shape), dtype=np.float64)


def mode_products(
    mode_range_mm: tuple[float, float],
    n_modes: int,
    tip: Tip | None = None,
    *,
    closed: bool = False,
) -> Floats:
    """<P_a, P_b> over flank and tip, mm; without a tip the modes are orthogonal."""
    if tip is None:
        return np.diag(mode_norms(mode_range_mm, n_modes, closed=closed))
    high, flank = mode_range_mm[1], n_modes - tip_modes(n_modes)
    parts = on_tip(n_modes, tip)
    products = parts.T @ (mode_norms((high, tip.end_mm), len(parts))[:, None] * parts)
    products[:flank, :flank] += np.diag(mode_norms(mode_range_mm, flank))
    return np.asarray(products)


def mode_norms(mode_range_mm: tuple[float, float], n_modes: int, *, closed: bool = False) -> Floats:
    """D_a = integral of P_a² over the range, mm: length/(2a + 1); length/2 for a harmonic."""
    low, high = mode_range_mm
    if closed:
        return np.where(np.arange(n_modes) == 0, high - low, 0.5 * (high - low))
    return np.asarray((high - low) / (2.0 * np.arange(n_modes) + 1.0), dtype=np.float64)


def mode_loads(
    mesh: SectorMesh | MeshedFlank,
    mode_range_mm: tuple[float, float],
    n_modes: int,
    *,
    along: Literal["normal", "tangent"] = "normal",
    closed: bool = False,
    tip: Tip | None = None,
    twist: float | None = None,
) -> Floats:
    """Consistent nodal loads of the modes, along the outward normal or the tangent.

    B_qa = integral of N_q P_a n ds over the flank edges of the mesh and those of a tip, with
    quadratic geometry and shape functions and the same interpolation of s. The tangent points
    towards increasing arc length.

    Returns
    -------
    (2 N, n_modes) array, (3 N, n_modes) with a twist (`consistent_loads`)
        Per mm of width, degree of freedom 2*node + component.
    """
    turn = mode_range_mm[1] - mode_range_mm[0] if closed else None
    return consistent_loads(
        mesh,
        lambda s: mode_values(s, mode_range_mm, n_modes, closed=closed, tip=tip),
        count=n_modes,
        along=along,
        turn=turn,
        gauss_points=max(6, n_modes // 2 + 4),
        edges=None if tip is None else loaded_edges(mesh),
        twist=twist,
    )


def loaded_edges(flank: SectorMesh | MeshedFlank) -> tuple[Numbers, Floats]:
    """Nodes (m, 3) and arc lengths (mm) of the edges of a flank and its tip rounding or chamfer."""
    edges, s = flank.flank_edges, flank.flank_arc_length[flank.flank_edges]
    if isinstance(flank, MeshedFlank) or not flank.tip_edges.size:
        return edges, s
    return np.concatenate([edges, flank.tip_edges]), np.concatenate([s, flank.tip_arc_length])


def consistent_loads(
    mesh: SectorMesh | MeshedFlank,
    values: Callable[[Floats], Floats],
    *,
    count: int,
    along: Literal["normal", "tangent"] = "normal",
    turn: float | None = None,
    gauss_points: int = 6,
    edges: tuple[Numbers, Floats] | None = None,
    twist: float | None = None,
) -> Floats:
    """Consistent nodal loads of pressures along a flank, per mm of width.

    (2 N, count), degree of freedom 2*node + component; with a twist (3 N, count), 3*node +
    component.

    Parameters
    ----------
    values : callable
        Arc lengths (k,) -> pressures (k, count).
    along : {"normal", "tangent"}
        Out of the material, or towards increasing arc length.
    turn : float, optional
        Length of a closed flank, mm.
    edges : (m, 3) arrays, optional
        Nodes and arc lengths of the loaded edges; by default those of the flank.
    twist : float, optional
        Rotation kappa of the section along the axis, rad/mm. A pressure on the flank of a prism
        then has an axial component: (n, -kappa l) per arc length and width, with the lever arm l of
        n. A load along the profile is 1/cos(beta) = hypot(1, kappa l) times its tangent.
    """
    points, weights = leggauss(gauss_points)
    shape = np.stack(
        [points * (points - 1) / 2, points * (points + 1) / 2, 1 - points**2], axis=1
    )  # (g, 3), meshio's line3 order: ends, then middle
    slope = np.stack([points - 0.5, points + 0.5, -2 * points], axis=1)
    numbers, ends = edges or (mesh.flank_edges, mesh.flank_arc_length[mesh.flank_edges])
    place = mesh.nodes[numbers]  # (m, 3, 2)
    tangent = np.einsum("gk,mkd->mgd", slope, place)
    direction = tangent  # times ds, like the normal
    if along == "normal":
        direction = np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)
    if twist is not None:
        x, y = np.einsum("gk,mkd->dmg", shape, place)
        # l = P x n = P . t
        slope = twist * (x * tangent[..., 0] + y * tangent[..., 1])
        if along == "normal":
            direction = np.concatenate([direction, -slope[..., None]], axis=-1)
        else:
            secant = np.hypot(1.0, slope / np.hypot(tangent[..., 0], tangent[..., 1]))
            direction = np.pad(secant[..., None] * tangent, ((0, 0), (0, 0), (0, 1)))
    if turn is not None:  # a closed flank begins and ends at the same node
        ends = ends - turn * np.round((ends - ends[:, 2:]) / turn)
    s = ends @ shape.T  # (m, g)
    pressures = values(s.ravel()).reshape(*s.shape, count)
    local = np.einsum("g,gk,mga,mgd->mkda", weights, shape, pressures, direction)
    loads = np.zeros((len(mesh.nodes), direction.shape[-1], count))
    np.add.at(loads, numbers, local)
    return loads.reshape(-1, count)


def mirrored_loads(mesh: SectorMesh, loads: Floats, center_rad: float) -> tuple[Floats, int]:
    """Loads on the coast flank of a symmetric sector, and the tooth of this flank.

    Forces (2 N, p) on the flank of tooth 0 are mirrored, in three dimensions (3 N, p) rotated about
    the axis of symmetry: this turns a helix into itself. If the sector contains a space, the coast
    flank belongs to another tooth. `center_rad`: polar angle of the centre of tooth 0, or of its
    space for internal teeth. Raises ValueError if a node of the flank has no mirror image.
    """
    by_node = loads.reshape(len(mesh.nodes), -1, loads.shape[1])
    nodes = np.flatnonzero(by_node.any(axis=(1, 2)))
    images, tooth = coast_nodes(mesh, nodes, center_rad)
    mirrored = np.zeros_like(by_node)
    mirrored[images] = reflection(mesh, 1, by_node.shape[1], twisted=True) @ by_node[nodes]
    return mirrored.reshape(loads.shape), tooth


def coast_nodes(mesh: SectorMesh, nodes: Numbers, center_rad: float) -> tuple[Numbers, int]:
    """Mirror images (n,) of nodes of the flank, and the tooth as for `mirrored_loads`."""
    turn = reflection(mesh, 1, 2, twisted=True)
    # faster than the import of a search tree
    apart = [((mesh.nodes - place) ** 2).sum(axis=1) for place in mesh.nodes[nodes] @ turn]
    images = np.array([distance.argmin() for distance in apart])
    largest = max(float(distance.min()) for distance in apart)
    if largest > (MIRROR_TOLERANCE * float(np.abs(mesh.nodes).max())) ** 2:
        raise ValueError("mesh: expected a sector whose halves are mirror images")
    return images, round((axis_of(mesh) - center_rad) * mesh.teeth / np.pi)


def projected_logarithm(n_modes: int, length_mm: float, *, closed: bool = False) -> Floats:
    """<P_a, ln|s - s'| P_b> over a flank, in closed form: (n_modes, n_modes), mm².

    With x in [-1, 1] and Legendre functions of the second kind, for n >= 1
    int P_n(y) ln|x - y| dy = 2 (Q_(n+1) - Q_(n-1))/(2n + 1), and
    int P_m Q_n = (1 - (-1)^(m+n))/((m - n)(m + n + 1)) for m != n, else 0. The logarithm of the
    chord on a closed flank is diagonal: ln|2 sin(t/2)| = -sum cos(k t)/k.
    """
    if closed:
        order = np.arange(1, n_modes + 1) // 2
        diagonal = -(length_mm**2) / (4.0 * np.maximum(order, 1))
        diagonal[:1] = length_mm**2 * np.log(length_mm / (2 * np.pi))
        return np.diag(diagonal)
    on_unit = np.zeros((n_modes, n_modes))
    for m in range(n_modes):
        for n in range(max(m, 1), n_modes):
            if (m + n) % 2:
                continue
            value = (4.0 / (2 * n + 1)) * (
                1.0 / ((n - 1 - m) * (n + m)) - 1.0 / ((n + 1 - m) * (n + m + 2))
            )
            on_unit[m, n] = on_unit[n, m] = value
    if n_modes:
        on_unit[0, 0] = 4.0 * np.log(2.0) - 6.0
    half = 0.5 * length_mm
    result = half**2 * on_unit
    if n_modes:
        # the logarithm of the length couples to the constant mode only: (int P_0)² = length²
        result[0, 0] += np.log(half) * length_mm**2
    return result


def projected_image(n_modes: int, length_mm: float, *, at_high_end: bool) -> Floats:
    """<P_a, ln(d + d') P_b>, mm², with the distance d from the corner at one end of the flank.

    On both halves of the square, with x and x' = x t in [0, 1] from that end,
    ln(x + x') = ln x + ln(1 + t). The first term is integrated by shifted Legendre coefficients,
    int P~_n ln x = (-1)^(n+1)/(n (n + 1)), -1 for n = 0; the second by Gauss quadrature.
    """
    degree = np.arange(2 * n_modes)  # of two modes and x itself
    x, weights = (0.5 * part for part in leggauss(2 * n_modes))
    x += 0.5
    of_log = np.where(degree > 0, -((-1.0) ** degree) / np.maximum(degree * (degree + 1), 1), -1.0)
    log_weights = weights * (legvander(2 * x - 1, 2 * n_modes - 1) @ ((2 * degree + 1) * of_log))
    t, t_weights = (0.5 * part for part in leggauss(n_modes + LOGARITHM_POINTS))
    t += 0.5
    sign = -1.0 if at_high_end else 1.0
    near = legvander(sign * (2 * x - 1), n_modes - 1)
    further = legvander(sign * (2 * np.outer(x, t) - 1), n_modes - 1)  # (x, t, mode)
    inner = np.einsum("t,xtb->xb", t_weights, further)
    inner_log = np.einsum("t,xtb->xb", t_weights * np.log1p(t), further)
    half = (near * x[:, None]).T @ (log_weights[:, None] * inner + weights[:, None] * inner_log)
    result = np.asarray(length_mm**2 * (half + half.T))
    # the logarithm of the length couples to the constant mode only: (int P_0)² = length²
    result[:1, :1] += np.log(length_mm) * length_mm**2
    return result


def projected_near_field(
    n_modes: int,
    length_mm: float,
    *,
    wedge: tuple[float, float] = (0.0, 0.0),
    closed: bool = False,
    tip: Tip | None = None,
) -> Floats:
    """<P_a, K P_b> over a flank for the near field K of strength c0 = -1: mm².

    Parameters
    ----------
    length_mm : float
        Length of the modes' range.
    wedge : (float, float)
        Strengths psi of the mirror images behind its low and its high end.
    tip : Tip, optional
        Tip behind the range, with arc lengths from the low end of the range; no image at this end.
    """
    if tip is not None:
        span = (0.0, length_mm)
        near = projected_with_tip(projected_logarithm, np.log, n_modes, span, tip)
        if wedge[0]:
            image = projected_image(n_modes - tip_modes(n_modes), length_mm, at_high_end=False)
            near = near + wedge[0] * image_with_tip(image, n_modes, span, tip)
        return near
    near = projected_logarithm(n_modes, length_mm, closed=closed)
    for psi, at_high_end in zip(wedge, (False, True), strict=True):
        if psi:
            near = near + psi * projected_image(n_modes, length_mm, at_high_end=at_high_end)
    return near


def projected_sign(n_modes: int, length_mm: float, *, tip: Tip | None = None) -> Floats:
    """<P_a, sign(s - s') P_b> over a flank, in closed form: antisymmetric, mm².

    With x in [-1, 1], int P_n(y) sign(x - y) dy = 2 (P_(n+1) - P_(n-1))/(2n + 1) for n >= 1 and
    2 P_1 for n = 0: only modes of neighbouring degrees are coupled. The tip is that of
    `projected_near_field`.
    """
    if tip is not None:
        return projected_with_tip(
            projected_sign, lambda x: -np.ones_like(x), n_modes, (0.0, length_mm), tip, mirror=-1.0
        )
    n = np.arange(n_modes - 1)
    below = 4.0 / ((2 * n + 1) * (2 * n + 3))
    on_unit = np.diag(below, -1) - np.diag(below, 1)
    return np.asarray((0.5 * length_mm) ** 2 * on_unit)
