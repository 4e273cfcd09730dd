"""Error of contacts on a sharp corner: one body is computed with the normal of its own flank.

At a sharp corner the force has the mean of the normals of both flanks. In the plane, the body with
the corner includes the response along its flank (`BodyCompliance.turned`). Its mate is computed
with its own normal, as is a body from a file without that response, and both bodies in three
dimensions; these are too compliant. The excess has a closed form: bending of the tooth and rotation
of the rim displace a place along its circle about the axis. With the normal n of the flank, the
direction n' of the force and the direction u of that circle, the compliance between places i and j
is multiplied by k_i k_j, k = (n'·u)/(n·u). The near field has no preferred direction, but for the
image behind a corner of the part along the flank, Eq. (W3).

The sign of this error is known, but it is reported as an uncertainty, since it cancels errors of
other sources at some torques and positions only.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legvander

from flankload.analysis.error_rules import RemainingError, mean_stiffness
from flankload.bodies.free_corner import along_strengths
from flankload.contact.status import SiteCorner, on_corner
from flankload.elasticity.near_field import mode_values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.base.arrays import Flags, Floats
    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair


#: Sites are included whose marginal force exceeds this part of the largest one.
LEAST_MARGINAL_FORCE = 1e-3
#: The compliance of a site under its own force is at least this part of its whole compliance.
LEAST_OWN = 0.1
#: In three dimensions, the closed form is a half to the whole of the change beside solid elements
#: (a spur and a helical pair, cells and slices).
IN_THREE_DIMENSIONS = 2.0
#: Distance from the end of the flank, relative to its length, at which its own normal is evaluated.
SHORT = 1e-6


def tip_error(
    found: Sweep, pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]
) -> dict[str, RemainingError]:
    """Errors by inclined forces in the quantities of a sweep, which has its pairs.

    Returns
    -------
    dict
        By quantity; empty if no tip carries load or its circle is unknown.
    """
    none = np.zeros_like(found.site_force_N)
    turned, between = none.copy(), np.zeros((*none.shape, none.shape[1]))
    for z in (0, 1):
        if compliances[z].modes.nodes is None:
            on_body = _lost_displacement(found, pair, compliances[z], z)
            for whole, part in zip((turned, between), on_body, strict=True):
                whole += part / pair.slices.compliance_width_mm
    if not turned.any():
        return {}
    changes = _changes(found, turned, between)
    doubt = 1.0 if pair.slices.plane else IN_THREE_DIMENSIONS
    return {
        name: RemainingError(np.zeros_like(one), doubt * np.abs(one))
        for name, one in changes.items()
    }


def _changes(found: Sweep, lost: Floats, between: Floats) -> dict[str, Floats]:
    """Excess of each quantity if sites (P, S) are too compliant."""
    rotation, force = found.rotation_rad, found.site_force_N
    error, apart = _answer(found, lost, between)
    tiny = np.finfo(float).tiny
    grown = np.clip(apart / np.maximum(force, tiny), -1.0, 1.0)
    peak = np.where(on_corner(found.site_corner), 0.0, found.site_peak_N_per_mm)
    changes = {
        "transmission_error": error / np.abs(rotation).max(),
        "load_share": apart / np.maximum(force.sum(axis=1, keepdims=True), tiny),
        # the peak of a line contact is proportional to the root of its force
        "peak_pressure": 0.5 * grown * peak / max(float(peak.max()), tiny),
    }
    true = rotation - error
    for name, (with_error, without) in {
        "transmission_error_mean": (rotation.mean(), true.mean()),
        "transmission_error_peak_to_peak": (np.ptp(rotation), np.ptp(true)),
    }.items():
        if with_error:
            changes[name] = np.asarray((with_error - without) / abs(with_error))
    stiff = mean_stiffness(rotation)
    if stiff is not None:
        part = (stiff * error / rotation).mean() / stiff.mean()
        changes["stiffness_secant"] = changes["stiffness_tangent"] = np.asarray(part)
    return changes


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
        at = np.flatnonzero(
            (found.site_force_N[p] > 0) & (marginal > LEAST_MARGINAL_FORCE * marginal.max())
        )
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


@dataclass(frozen=True, eq=False)
class _Loads:
    """Loaded pairs of a sweep; n of all pairs."""

    found: Sweep

    @cached_property
    def loaded(self) -> Flags:
        """Flags of the loaded ones among all pairs."""
        return self.found.pairs.column("force") > 0

    @cached_property
    def at(self) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
        """Position and site (n,) of each."""
        pairs = self.found.pairs
        return pairs.position[self.loaded], pairs.sites[self.loaded]

    @cached_property
    def slices(self) -> NDArray[np.integer]:
        """Slice (n,) of each."""
        return self.found.pairs.slices[self.loaded]

    @property
    def corner(self) -> NDArray[np.int64]:
        """Corner (n,) of each, that of its slice."""
        return self.found.slices.corner[(*self.at, self.slices)]

    @property
    def line_load(self) -> Floats:
        """Line load (n,) of the slice of each, N/mm."""
        load = self.found.slices.force_N / np.diff(self.found.slices.edges_mm)
        return np.asarray(load[(*self.at, self.slices)])

    def column(self, name: str) -> Floats:
        """Column (n,) of the table of pairs."""
        return np.asarray(self.found.pairs.column(name)[self.loaded])

    def total(self, values: Floats) -> Floats:
        """Sums (P, S, …) of values (n, …) of the pairs of each site."""
        sums = np.zeros((*self.found.site_force_N.shape, *values.shape[1:]))
        np.add.at(sums, self.at, values)
        return sums

    def mean(self, values: Floats) -> Floats:
        """Means (P, S, …) of values (n, …), weighted by force; 0 without force."""
        more = [1] * (values.ndim - 1)
        force = self.column("force")
        whole = self.total(force)
        whole = np.where(whole > 0, whole, 1.0).reshape(*whole.shape, *more)
        return np.asarray(self.total(values * force.reshape(-1, *more)) / whole)


def _lost_displacement(
    found: Sweep, pair: BodyPair, compliance: BodyCompliance, z: int
) -> tuple[Floats, Floats]:
    """Loss of displacement (P, S) at each site by the inclination of all forces, mm, and compliance
    (P, S, S) between sites by the modes, mm/N; in the plane, times the width.
    """
    loads, body = _Loads(found), pair.bodies[z]
    angles = _angles(loads, pair, z)
    turn = _turn_of_force(loads, pair, compliance, z, angles)
    values = _modes(loads, pair, compliance, z)
    modes, turned = loads.mean(values), loads.mean(turn[:, None] * values)
    teeth = pair.pairing.site_teeth[z]
    block = compliance.block_of(teeth[:, None], teeth[None, :], body.teeth)
    between, less = (
        np.einsum("pia,ijab,pjb->pij", each, compliance.smooth[block], each)
        for each in (modes, turned)
    )
    lost = ((between - less) @ found.site_force_N[:, :, None])[..., 0]
    if not pair.slices.plane:
        return lost + loads.mean(_lost_image(loads, body, compliance, z, angles)), between
    s, width = loads.column(f"s_{z + 1}"), loads.total(loads.column("cell"))
    near = np.log(np.where(width > 0, width, 1.0))
    for psi, corner in zip(compliance.near.wedge, body.mode_range_mm, strict=True):
        away = np.maximum(loads.mean(np.abs(s - corner)), 0.5 * width)
        near += psi * np.log(np.where(width > 0, 2.0 * away, 1.0))
    lost -= (1.0 - loads.mean(turn) ** 2) * compliance.near.kernel * near * found.site_force_N
    return np.where(width > 0, lost, 0.0), between


def _modes(loads: _Loads, pair: BodyPair, compliance: BodyCompliance, z: int) -> Floats:
    """Modes of a body at each loaded pair (n, p), with those along the axis."""
    (low, high), tip = pair.bodies[z].mode_range_mm, compliance.modes.tip
    within = loads.column(f"s_{z + 1}").clip(low, tip.end_mm if tip else high)
    values = mode_values(within, (low, high), compliance.modes_along, tip=tip)
    if pair.slices.plane:
        return values
    axial = compliance.modes.axial
    first, last = axial.range_mm
    xi = (2.0 * pair.slices.z_mm[loads.slices] - first - last) / (last - first)
    along = legvander(xi, axial.degree)
    return np.asarray((values[:, :, None] * along[:, None, :]).reshape(values.shape[0], -1))


def _lost_image(
    loads: _Loads, body: Body, compliance: BodyCompliance, z: int, angles: tuple[Floats, Floats]
) -> Floats:
    """Loss of displacement (n,), mm, by the image behind a corner that its force turns over.

    Eq. (W3) with the line load of the slice, over the length of the flank; twice, since both the
    force and the displacement turn.
    """
    low, high = compliance.modes.range_mm
    away = np.maximum(high - loads.column(f"s_{z + 1}"), 0.5 * loads.column("cell"))
    strength = 2.0 * compliance.near.kernel * along_strengths(body)[1]
    lost = strength * np.sin(angles[1] - angles[0]) * np.log((high - low) / (2.0 * away))
    return np.where(loads.corner == SiteCorner.of_body(z), np.abs(lost) * loads.line_load, 0.0)


def _turn_of_force(
    loads: _Loads, pair: BodyPair, compliance: BodyCompliance, z: int, angles: tuple[Floats, Floats]
) -> Floats:
    """k = (n'·u)/(n·u) of each loaded pair (n,); 1 where the force has the normal of the body."""
    corner = loads.corner
    turned = corner == SiteCorner.of_body(1 - z)
    if compliance.turned is None and compliance.modes.tip is None:
        turned |= corner == SiteCorner.of_body(z)
    if pair.bodies[z].involute is None:
        return np.ones(turned.size)
    return np.where(turned, np.sin(angles[1]) / np.sin(angles[0]), 1.0)


def _angles(loads: _Loads, pair: BodyPair, z: int) -> tuple[Floats, Floats]:
    """Angles (n,) of the normal of the flank, and of the force, from the radius of the place."""
    body = pair.bodies[z]
    place, force = (
        np.stack([loads.column(f"{name}{axis}") for axis in "xy"], axis=1)
        for name in ("", "normal_")
    )
    place[:, 0] -= z * pair.pairing.center_distance_mm
    low, high = body.mode_range_mm
    s = np.minimum(loads.column(f"s_{z + 1}"), high - SHORT * (high - low))
    own = _from_radius(body.curve.normal(s), body.curve.point(s))
    return own, _from_radius((1 - 2 * z) * force, place)


def _from_radius(normal: Floats, place: Floats) -> Floats:
    """Angle (m,) of normals (m, 2) from the radius of their places, counter-clockwise."""
    across = place[:, 0] * normal[:, 1] - place[:, 1] * normal[:, 0]
    return np.arctan2(across, np.sum(place * normal, axis=1))
