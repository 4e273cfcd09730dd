"""What is left where a contact works on a sharp corner: the force turns for both bodies.

Over a sharp corner the force has the mean of both flanks' normals. The body with the corner knows
what a force along its flank at the tip moves (`BodyCompliance.turned`); its mate, whose flank goes
on, pushes and recedes along its own normal, and so does a body from a file without that response.
By how much they yield too much follows in closed form: what moves a place, bending of the tooth and
turning of the rim, moves it along its circle; with n the normal of the flank at the contact, n'
that of the force and u the direction of the circle, places i and j yield to each other k_i k_j
times as much, k = (n'·u)/(n·u), 1 where the flank itself touches. Of the place's own yielding the
near field has no preferred direction; it reaches as far as the contact.

All of it is in doubt: its sign is known, but what it may cancel of other sources holds for one
torque and position, and is not counted on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.error_rules import Left
from flankload.analysis.sampling_error import mean_stiffness
from flankload.elasticity.near_field import mode_values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.pairing import Pairing

    Floats = NDArray[np.float64]

#: A site takes part where it takes up more than this part of what the stiffest does.
LEAST_PART = 1e-3
#: The compliance of a site under its own force is at least this part of its whole compliance.
LEAST_OWN = 0.1
#: Distance from the end of the flank, relative to its length, at which its own normal is evaluated.
SHORT = 1e-6


def tip_error(
    found: Sweep,
    bodies: tuple[Body, Body],
    compliances: tuple[BodyCompliance, BodyCompliance],
    pairing: Pairing,
    face_width_mm: float,
) -> dict[str, Left]:
    """Errors by inclined forces in the quantities of a sweep.

    Parameters
    ----------
    found : Sweep
        With its pairs.
    bodies, compliances, pairing, face_width_mm
        Those of the sweep.

    Returns
    -------
    dict
        By quantity; empty if no tip carries load or its circle is unknown.
    """
    none = np.zeros_like(found.site_force_N)
    turned, between = none.copy(), np.zeros((*none.shape, none.shape[1]))
    for z in (0, 1):
        if compliances[z].modes.nodes is None:
            on_body = _yields(found, bodies[z], compliances[z], pairing, z)
            for whole, part in zip((turned, between), on_body, strict=True):
                whole += part / face_width_mm
    if not turned.any():
        return {}
    changes = _changes(found, turned, between)
    return {name: Left(np.zeros_like(one), np.abs(one)) for name, one in changes.items()}


def _changes(found: Sweep, lost: Floats, between: Floats) -> dict[str, Floats]:
    """Excess of each quantity if sites (P, S) are too compliant."""
    rotation, force = found.rotation_rad, found.site_force_N
    error, apart = _answer(found, lost, between)
    tiny = np.finfo(float).tiny
    grown = np.clip(apart / np.maximum(force, tiny), -1.0, 1.0)
    peak = np.where(found.site_corner <= 0, found.site_peak_N_per_mm, 0.0)
    left = {
        "transmission_error": error / np.abs(rotation).max(),
        "load_share": apart / np.maximum(force.sum(axis=1, keepdims=True), tiny),
        # the peak of a line contact goes with the root of its force
        "peak_pressure": 0.5 * grown * peak / max(float(peak.max()), tiny),
    }
    true = rotation - error
    for name, (with_error, without) in {
        "transmission_error_mean": (rotation.mean(), true.mean()),
        "transmission_error_peak_to_peak": (np.ptp(rotation), np.ptp(true)),
    }.items():
        if with_error:
            left[name] = np.asarray((with_error - without) / abs(with_error))
    stiff = mean_stiffness(rotation)
    if stiff is not None:
        part = (stiff * error / rotation).mean() / stiff.mean()
        left["stiffness_secant"] = left["stiffness_tangent"] = np.asarray(part)
    return left


def _answer(found: Sweep, lost: Floats, between: Floats) -> tuple[Floats, Floats]:
    """Excess of rotation (P,) and forces (P, S) if sites are too compliant.

    With coupled springs C: C w = b dφ/dM for the marginal forces w gives the compliance of each
    site under its own force; then C dF - b dφ = lost, where b·dF = 0.
    """
    rotation = np.zeros_like(found.rotation_rad)
    forces = np.zeros_like(lost)
    for p, (marginal, softness) in enumerate(
        zip(found.site_force_per_torque, found.tangent_rad_per_Nmm, strict=True)
    ):
        at = np.flatnonzero((found.site_force_N[p] > 0) & (marginal > LEAST_PART * marginal.max()))
        w, n = marginal[at], at.size
        if not n:
            continue
        lever = 1.0 / w.sum()
        springs = np.zeros((n + 1, n + 1))
        springs[:n, :n] = between[p][np.ix_(at, at)]
        np.fill_diagonal(springs, 0.0)
        alone = lever * softness / w
        own = (lever * softness - springs[:n, :n] @ w) / w
        springs[np.arange(n), np.arange(n)] = np.maximum(own, LEAST_OWN * alone)
        springs[:n, n] = springs[n, :n] = lever
        change = np.linalg.solve(springs, np.append(lost[p, at], 0.0))
        forces[p, at], rotation[p] = -change[:n], change[n]
    return rotation, forces


def _yields(
    found: Sweep, body: Body, compliance: BodyCompliance, pairing: Pairing, z: int
) -> tuple[Floats, Floats]:
    """Loss of displacement at each site under all forces, and compliance between sites.

    Returns
    -------
    turned : (P, S) array
        By the inclination of forces; mm² (per width).
    between : (P, S, S) array
        By the modes; mm²/N (per width).
    """
    none = np.zeros_like(found.site_force_N)
    pairs = found.pairs
    loaded = pairs.column("force") > 0
    at = pairs.position[loaded], pairs.sites[loaded]
    force, s = (pairs.column(name)[loaded] for name in ("force", f"s_{z + 1}"))
    low, high = body.mode_range_mm
    turned = found.site_corner[at] == 2 - z  # the mate's corner
    if compliance.turned is None and compliance.modes.tip is None:
        turned |= found.site_corner[at] == z + 1
    if body.involute is None:
        turned[:] = False

    def mean(values: Floats) -> Floats:
        """Over the forces of each site: (P, S, …)."""
        columns = values.reshape(force.size, -1)
        sums = np.zeros((*none.shape, columns.shape[1]))
        np.add.at(sums, at, columns * force[:, None])
        whole = np.zeros_like(none)
        np.add.at(whole, at, force)
        sums /= np.where(whole > 0, whole, 1.0)[..., None]
        return sums if values.ndim > 1 else sums[..., 0]

    place, normal = (
        np.stack([pairs.column(f"{name}{axis}")[loaded] for axis in "xy"], axis=1)
        for name in ("", "normal_")
    )
    place[:, 0] -= z * pairing.center_distance_mm
    turn = np.ones_like(s)
    if turned.any():
        pushed = _along_circle((1 - 2 * z) * normal[turned], place[turned])
        own = np.minimum(s[turned], high - SHORT * (high - low))
        meant = _along_circle(body.curve.normal(own), body.curve.point(own))
        turn[turned] = pushed / meant
    turn = mean(turn)
    n = compliance.smooth.shape[1]
    within = s.clip(low, compliance.modes.tip.end_mm if compliance.modes.tip else high)
    modes = mean(mode_values(within, body.mode_range_mm, n, tip=compliance.modes.tip))
    teeth = pairing.site_teeth[z]
    block = compliance.block_of(teeth[:, None], teeth[None, :], body.teeth)
    yields = np.einsum("pia,ijab,pjb->pij", modes, compliance.smooth[block], modes)
    between = yields.copy()
    width = np.zeros_like(none)
    np.add.at(width, at, pairs.column("cell")[loaded])
    sites = np.arange(teeth.size)
    near = np.log(np.where(width > 0, width, 1.0))
    for psi, corner in zip(compliance.near.wedge, body.mode_range_mm, strict=True):
        away = np.maximum(mean(np.abs(s - corner)), 0.5 * width)
        near += psi * np.log(np.where(width > 0, 2.0 * away, 1.0))
    yields[:, sites, sites] -= compliance.near.kernel * near
    less = 1.0 - turn[:, :, None] * turn[:, None, :]
    less *= (width > 0)[:, :, None] & (width > 0)[:, None, :]
    lost = ((less * yields) @ found.site_force_N[:, :, None])[..., 0]
    return lost, between


def _along_circle(normal: Floats, place: Floats) -> Floats:
    """Component of normals (m, 2) along the circle about the origin through places (m, 2)."""
    across = place[:, 0] * normal[:, 1] - place[:, 1] * normal[:, 0]
    return np.asarray(across / np.hypot(*place.T))
