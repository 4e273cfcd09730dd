"""What modes miss where a contact works on a tip: its force turns.

Pressure modes push along the normal of the flank, and end with it. On a rounding, on a chamfer or
over a sharp corner the force turns towards the tooth's axis, in which the tooth hardly yields. What
moves a tip, bending of the tooth and turning of the rim, moves it along its circle: with n the
normal of the flank at its end, n' that of the contact and u the direction of the circle, places i
and j yield to each other k_i k_j times as much, k = (n'·u)/(n·u), 1 where the flank itself touches.
Of the place's own yielding the near field has no preferred direction; it reaches as far as the
rounding, or as the contact where that is longer.

Gears and rings with roundings of 0.08 and 0.2 modules, elements of 1/36 module, forces along the
rounding's own normals (turned by 3.5 to 37 degrees): the loss of compliance is 0.8 to 1.4 times
this, where it exceeds a twentieth. So 1.4 times what it changes is in doubt. Its sign is known, but
what it may cancel of other sources holds for one torque and position, and is not counted on.
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

#: Because forces turn: the loss of compliance over its closed form, at the most.
DOUBT = 1.4
#: A site takes part where it takes up more than this part of what the stiffest does.
LEAST_PART = 1e-3
#: What a site yields under its own force is at least this part of all that it yields.
LEAST_OWN = 0.1
#: Of the flank's length: so far from its end it has its own normal.
SHORT = 1e-6


def tip_error(
    found: Sweep,
    bodies: tuple[Body, Body],
    compliances: tuple[BodyCompliance, BodyCompliance],
    pairing: Pairing,
    face_width_mm: float,
) -> dict[str, Left]:
    """What turned forces leave in the quantities of a sweep.

    Parameters
    ----------
    found : Sweep
        With its pairs.
    bodies, compliances, pairing, face_width_mm
        Those of the sweep.

    Returns
    -------
    dict
        By quantity; empty where no tip works, or nothing is known of its circle.
    """
    none = np.zeros_like(found.site_force_N)
    turned, between = none.copy(), np.zeros((*none.shape, none.shape[1]))
    for z in (0, 1):
        if compliances[z].nodes is None:
            on_body = _yields(found, bodies[z], compliances[z], pairing, z)
            for whole, part in zip((turned, between), on_body, strict=True):
                whole += part / face_width_mm
    if not turned.any():
        return {}
    changes = _changes(found, DOUBT * turned, between)
    return {name: Left(np.zeros_like(one), np.abs(one)) for name, one in changes.items()}


def _changes(found: Sweep, lost: Floats, between: Floats) -> dict[str, Floats]:
    """By how much each quantity is too large where sites (P, S) yield too much."""
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
    """By how much rotation (P,) and forces (P, S) are too large where sites yield too much.

    As springs C that know each other: C w = b dφ/dM of the marginal forces w gives what each site
    yields under its own force; then C dF - b dφ = lost, where b·dF = 0.
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
    """What a body yields less at each site under all forces, and sites under each other's.

    Returns
    -------
    turned : (P, S) array
        Because forces turn; mm² (per width).
    between : (P, S, S) array
        mm²/N (per width), as the modes have it.
    """
    none = np.zeros_like(found.site_force_N)
    pairs = found.pairs
    loaded = pairs.column("force") > 0
    at = pairs.position[loaded], pairs.sites[loaded]
    force, s = (pairs.column(name)[loaded] for name in ("force", f"s_{z + 1}"))
    end = body.mode_range_mm[1]
    turned = (s > end) | (found.site_corner[at] == z + 1)
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
        on_flank = np.minimum(s[turned], _last(body))
        meant = _along_circle(body.curve.normal(on_flank), body.curve.point(s[turned]))
        turn[turned] = pushed / meant
    turn = mean(turn)
    n = compliance.smooth.shape[1]
    modes = mean(mode_values(s.clip(*body.mode_range_mm), body.mode_range_mm, n))
    teeth = pairing.site_teeth[z]
    block = compliance.block_of(teeth[:, None], teeth[None, :], body.teeth)
    yields = np.einsum("pia,ijab,pjb->pij", modes, compliance.smooth[block], modes)
    between = yields.copy()
    width = np.zeros_like(none)
    np.add.at(width, at, pairs.column("cell")[loaded])
    reach = np.maximum(width, body.curve.length_mm - end)
    sites = np.arange(teeth.size)
    near = np.log(np.where(width > 0, reach, 1.0))
    for psi, corner in zip(compliance.wedge, body.mode_range_mm, strict=True):
        away = np.maximum(mean(np.abs(s - corner)), 0.5 * reach)
        near += psi * np.log(np.where(width > 0, 2.0 * away, 1.0))
    yields[:, sites, sites] -= compliance.kernel * near
    less = 1.0 - turn[:, :, None] * turn[:, None, :]
    less *= (width > 0)[:, :, None] & (width > 0)[:, None, :]
    lost = ((less * yields) @ found.site_force_N[:, :, None])[..., 0]
    return lost, between


def _last(body: Body) -> float:
    """The last place of the flank itself, before a chamfer has its own direction."""
    low, high = body.mode_range_mm
    return high - SHORT * (high - low)


def _along_circle(normal: Floats, place: Floats) -> Floats:
    """Component of normals (m, 2) along the circle about the origin through places (m, 2)."""
    across = place[:, 0] * normal[:, 1] - place[:, 1] * normal[:, 0]
    return np.asarray(across / np.hypot(*place.T))
