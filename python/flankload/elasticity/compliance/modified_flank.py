"""Compliance of a modified flank from elements that follow the unmodified one.

Modifications of a flank are micrometres, but they turn its normal, by up to some hundredths. The
displacement that counts and the forces have that direction: with the normal n and the tangent t of
the flank of the elements, and the angle delta between both flanks,

    n' = n + delta t,    u.n' = u.n + delta u.t,

to the first order. In terms of modes, with the products G = <P_i delta P_j> and those of the modes
themselves D, the response K of normal displacements to normal loads and T to tangential loads give

    K' = K + T S' + (T S')',    S = D^-1 G,

with ' for the response with load and reading exchanged (Betti). T includes its near field: the jump
-j sign(s - s') becomes j sign(s - s') (delta(s) - delta(s')), and images behind free corners have
the logarithm of a length, so that without them results would depend on the unit of length.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.elasticity.near_field import mode_values, to_coefficients

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.elasticity.compliance.body_compliance import BodyCompliance
    from flankload.elasticity.compliance.contributions import RootResponse

#: Gauss points of each part of a flank, between two kinks of its modifications: exact for products
#: of modes of degree 16 and a parabola, as of crowning.
POINTS = 18


def on_modified_flank(found: BodyCompliance, body: Body) -> BodyCompliance:
    """The compliance of a body with a modified flank, from that of `body.elements`.

    Arc lengths are those of the modified flank, and with tangential loads forces have its
    direction.
    """
    if found.tangential is not None:
        found = _turned(found, _products(found, body))
    modes, span = found.modes, body.mode_range_mm
    nodes = None if modes.nodes is None else _across(body, modes.nodes)
    tip = None if modes.tip is None else body.tip
    return replace(found, modes=replace(modes, range_mm=span, tip=tip, nodes=nodes))


def _turned(found: BodyCompliance, products: Floats) -> BodyCompliance:
    """The compliance for forces in turned directions; products (p, p): S above."""
    assert found.tangential is not None
    along = found.tangential.copy()
    if found.along_near is not None:
        along[found.own_blocks] += found.along_near
    half = along @ products.T
    # this sum is symmetric to the last bit
    smooth = found.smooth + (half + half[found.exchanged].transpose(0, 2, 1))
    coast = found.coast
    if coast is not None and coast.tangential is not None:
        along = coast.tangential.copy()
        if found.along_near is not None:
            signs = found.modes.mirror_signs(len(found.along_near))
            along[2 * len(smooth)] += signs[:, None] * found.along_near * signs
        half = along @ products.T
        exchanged = half[coast.exchanged].transpose(0, 2, 1)
        coast = replace(coast, normal=coast.normal + (half + exchanged))
    root = None if found.root is None else _root(found.root, products)
    return replace(found, smooth=smooth, coast=coast, root=root)


def _root(root: RootResponse, products: Floats) -> RootResponse:
    """Root stress under loads in turned directions."""
    # in the plane for mode coefficients of pressures, in three dimensions for moments of forces
    p, products = len(products), products if root.range_mm is None else products.T

    def turned(response: Floats) -> Floats:
        normal, along = response[..., :p], response[..., p:]
        return np.concatenate([normal + along @ products, along], axis=-1)

    return root.with_each(turned)


def _products(found: BodyCompliance, body: Body) -> Floats:
    """S (p, p) of the modes of a compliance; of nodes the angles at these."""
    modes, tip = found.modes, found.modes.tip
    if modes.nodes is not None:
        return np.diag(_angle(body, modes.nodes))
    low, end = modes.range_mm[0], modes.range_mm[1] if tip is None else tip.end_mm
    kinks = _kinks(body)
    marks = np.unique([low, *kinks[(kinks > low) & (kinks < end)], end])
    points, weights = leggauss(POINTS)
    half = 0.5 * np.diff(marks)[:, None]
    s = (0.5 * (marks[:-1] + marks[1:])[:, None] + half * points).ravel()
    values = mode_values(s, modes.range_mm, found.modes_along, tip=tip)
    measure = (half * weights).ravel() * _angle(body, s)
    products = to_coefficients(values.T @ (measure[:, None] * values), modes.range_mm, tip=tip)
    # the loads along a profile are 1/cos(beta_b) of those normal to it
    cosine = modes.axial.cos_base_helix
    return np.asarray(np.kron(cosine * products, np.eye(modes.axial.count)))


def _angle(body: Body, s: Floats) -> Floats:
    """Angle delta (n,), rad, at arc lengths on the flank of the elements."""
    normal, tangent = body.curve.normal(_across(body, s)), body.unmodified.curve.tangent(s)
    return np.asarray(np.sum(normal * tangent, axis=1))


def _kinks(body: Body) -> Floats:
    """Arc lengths on the flank of the elements at which parts of the modified flank begin."""
    labels, breaks = body.curve.labels, body.curve.breaks
    begins = [breaks[k] for k in range(1, len(labels)) if labels[k] != labels[k - 1]]
    here, there = _ends(body)
    return np.interp(begins, there, here)


def _across(body: Body, s: Floats) -> Floats:
    """Arc lengths on the modified flank, for those on the flank of the elements."""
    return np.interp(s, *_ends(body))


def _ends(body: Body) -> tuple[list[float], list[float]]:
    """Arc lengths of the ends of the active flank and of the tip, on the elements and on the body.

    These parts have lengths that differ by micrometres, and correspond to each other.
    """
    both = []
    for each in (body.unmodified, body):
        low, high = each.mode_range_mm
        end = each.curve.length_mm
        both.append([low, high, end] if end > high else [low, high])
    return both[0], both[1]
