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
from flankload.elasticity.near_field import mode_products, mode_values, to_coefficients
from flankload.elasticity.sector_closure import made_symmetric

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

    Its modes are those of the modified flank, at equal arc lengths. With tangential loads, forces
    have the direction of that flank.
    """
    if found.tangential is not None:
        found = _turned(found, _products(found, body))
    if found.modes.nodes is None:
        return _in_modes_of(body, found)
    nodes = _nodes_across(body, found.modes.nodes)
    return replace(found, modes=replace(found.modes, range_mm=body.mode_range_mm, nodes=nodes))


def _in_modes_of(body: Body, found: BodyCompliance) -> BodyCompliance:
    """The compliance in terms of the modes on the modified flank, at equal arc lengths.

    Polynomials are polynomials on any range. The modified flank is some hundredths of a millimetre
    longer, by which they are extrapolated. The modes of a tip remain those of the tip.
    """
    old, n, count = found.modes, found.flank_modes, found.modes_along
    span, tip = body.mode_range_mm, None if old.tip is None else body.tip
    points, weights = leggauss(n)
    half = 0.5 * (span[1] - span[0])
    s = span[0] + half * (1.0 + points)
    before = mode_values(s, old.range_mm, n)
    matrix: Floats = np.eye(count)
    moments = mode_values(s, span, n).T @ (half * weights[:, None] * before)
    matrix[:n, :n] = to_coefficients(moments, span)
    if found.root is not None and found.root.range_mm is None:
        # in the plane, loads of root stress are coefficients of pressures, else forces
        moments = matrix.T @ mode_products(span, count, tip)
        loads = to_coefficients(moments, old.range_mm, tip=old.tip)
    else:
        loads = np.asarray(np.kron(matrix.T, np.eye(old.axial.count)))
    matrix = np.asarray(np.kron(matrix, np.eye(old.axial.count)))
    rim, error = found.rim, found.fe_error
    found = found.with_blocks(lambda blocks: matrix @ blocks @ matrix.T)
    coast = found.coast
    if coast is not None:
        coast = replace(coast, normal=made_symmetric(coast.normal, coast.exchanged)[0])
    return replace(
        found,
        smooth=made_symmetric(found.smooth, found.exchanged)[0],
        coast=coast,
        modes=replace(old, range_mm=span, tip=tip),
        expansion=found.expansion.with_shifts(lambda modes: modes @ matrix.T),
        root=found.root_under(lambda table: table @ loads),
        rim=None if rim is None else rim.with_loads(lambda table: table @ matrix.T),
        fe_error=None if error is None else matrix @ error @ matrix.T,
    )


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
    rim, p = found.rim, len(products)
    if rim is not None:
        rim = rim.with_loads(lambda table: table[..., :p] + table[..., p:] @ products.T)
    return replace(found, smooth=smooth, coast=coast, root=root, rim=rim)


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
    kinks, high = _kinks(body), modes.range_mm[1]
    marks = np.unique([low, *kinks[(kinks > low) & (kinks < high)], high, end])
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
    """Arc lengths on the modified flank at which its parts begin."""
    labels, breaks = body.curve.labels, body.curve.breaks
    return np.array([breaks[k] for k in range(1, len(labels)) if labels[k] != labels[k - 1]])


def _across(body: Body, s: Floats) -> Floats:
    """Arc lengths on the modified flank, for those on the flank of the elements."""
    high, first, end = body.unmodified.mode_range_mm[1], body.mode_range_mm[1], body.curve.length_mm
    on_tip = np.interp(s, [high, body.unmodified.curve.length_mm], [first, end])
    return np.where(s > high, on_tip, np.minimum(s, first))


def on_elements(body: Body, s: Floats) -> Floats:
    """Arc lengths on the flank of the elements, for those on the flank of the body."""
    if body.elements is None:
        return s
    high, first, end = body.unmodified.mode_range_mm[1], body.mode_range_mm[1], body.curve.length_mm
    on_tip = np.interp(s, [first, end], [high, body.unmodified.curve.length_mm])
    return np.where(s > first, on_tip, np.minimum(s, high))


def _nodes_across(body: Body, nodes: Floats) -> Floats:
    """Nodes (n,) on the modified flank; those at the ends of the flank remain there."""
    found = _across(body, nodes)
    for old, new in zip(body.unmodified.mode_range_mm, body.mode_range_mm, strict=True):
        found[np.abs(nodes - old).argmin()] = new
    return found
