"""Teeth with different compliances: period of a compliance, and errors of positions over one pitch.

A body that is meshed as a whole may have holes, a keyway or spokes, so that its compliance repeats
after several teeth or a whole turn only. Positions over one pitch then contain each tooth at some
positions only. The effect of other teeth at these positions follows from the known forces: the work
of forces F is F'KF/2, and a small change of the compliance K increases the rotation of body 1 under
the same torque M by F'(change of K)F/M, to the first order. On wheels with three and four windows,
whose own compliance varies by a quarter, this is within 4 % of a solution over all pitches.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import lcm
from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.adaptive_positions import HARMONICS, LEAST_HARMONIC
from flankload.analysis.error_rules import RemainingError
from flankload.base.rounding import round_down
from flankload.elasticity.near_field import mode_values, projected_near_field
from flankload.elasticity.nodal_loads import linear_shapes, shape_widths

if TYPE_CHECKING:
    from flankload.analysis.adaptive_positions import Window
    from flankload.base.arrays import Floats, Numbers
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair

#: Additional quantity if the positions close.
HARMONICS_KEY = "transmission_error_harmonics"
#: Teeth whose compliances differ by less than this part of the tolerance are alike; meshes that are
#: not the same at all teeth differ by less.
ALIKE = 0.25
#: Doubt of the first order, relative to the estimated change of a quantity, and relative to the
#: mean absolute change at all positions (for the peak to peak: the largest).
DOUBT, DOUBT_SIZE = 0.2, 0.05


def teeth_until_alike(compliance: BodyCompliance, teeth: int, part: float) -> int:
    """Number of teeth after which a compliance repeats around a body.

    Two teeth are alike if a uniform pressure on either of them causes the same displacements of
    that tooth and of the others, up to a part of the largest. The number is 1 if all teeth are
    alike, otherwise a divisor of the number of teeth; teeth without a flank are like any other.
    """
    f = len(compliance.flanks)
    if f < 2:
        return 1
    evenly = _of_even_pressure(compliance).reshape(f, f)
    moved = np.full((teeth, teeth), np.nan)
    moved[np.ix_(compliance.flanks, compliance.flanks)] = evenly
    allowed = part * float(np.abs(np.diag(evenly)).max())

    def repeats(group: int) -> bool:
        apart = np.abs(np.roll(moved, (group, group), axis=(0, 1)) - moved)
        return bool(np.nanmax(apart, initial=0.0) <= allowed)

    return next(g for g in range(1, teeth + 1) if teeth % g == 0 and repeats(g))


def _of_even_pressure(compliance: BodyCompliance) -> Floats:
    """Mean displacement (f * f,) of flanks under a uniformly distributed unit force."""
    low, high = compliance.modes.range_mm
    length, f = high - low, len(compliance.flanks)
    if compliance.modes.nodes is not None:
        evenly = shape_widths(compliance.modes.nodes) / length
        return np.asarray(evenly @ compliance.smooth @ evenly)
    moved = compliance.smooth[:, 0, 0].copy()
    near = projected_near_field(1, length, wedge=compliance.near.wedge)[0, 0]
    moved[np.arange(f) * (f + 1)] -= compliance.near.kernel * near / length**2
    return moved


@dataclass(frozen=True, eq=False)
class OtherTeeth:
    """Bodies with different teeth, and positions in a window that contain some of these."""

    pair: BodyPair
    compliances: tuple[BodyCompliance, BodyCompliance]
    window: Window

    @property
    def teeth(self) -> tuple[int, ...]:
        """Numbers of teeth of both bodies."""
        return tuple(body.teeth for body in self.pair.bodies)

    @property
    def pitches(self) -> int:
        """Pitches after which the same teeth meet again, for bodies with different teeth."""
        return lcm(*(self.teeth[z] for z in (0, 1) if len(self.compliances[z].flanks) > 1))

    def changes_rad(self, found: Sweep) -> Floats:
        """(K, P) Additional rotation of body 1 at each position, k windows later.

        NaN if a tooth without a flank would carry load, and after the period of the teeth.
        """
        number = np.arange(0, self.pitches, self.window.pitches)
        # change of the tooth number of each body at a site after one pitch
        steps, position = (-1, self.pair.body_2.outward), self.pair.position_rad
        total = np.zeros((number.size, position.size))
        for z, compliance in enumerate(self.compliances):
            if len(compliance.flanks) > 1:
                by_tooth = self._work(found, z)
                total += (by_tooth - by_tooth[0])[steps[z] * number % self.teeth[z]]
        pitch = (position - position[0]) / self.window.pitch_rad
        total[number[:, None] + round_down(pitch) >= self.pitches] = np.nan
        return total / (self.pair.face_width_mm * found.torque_Nmm)

    def _work(self, found: Sweep, z: int) -> Floats:
        """(teeth, P) F'KF (N² mm²/N) of the forces on body z, shifted by each number of teeth."""
        compliance, teeth = self.compliances[z], self.teeth[z]
        tooth, loads = _loads(found, compliance, self.pair.pairing.site_teeth[z], z)
        f, n = len(compliance.flanks), loads.shape[2]
        place = np.full(teeth, -1)
        place[list(compliance.flanks)] = np.arange(f)
        blocks = compliance.smooth.reshape(f, f, n, n)
        work = np.empty((teeth, len(tooth)))
        for k in range(teeth):
            at = place[(tooth + k) % teeth]
            moved = np.einsum("pijab,pjb->pia", blocks[at[:, :, None], at[:, None, :]], loads)
            work[k] = np.einsum("pia,pia->p", moved, loads)
            missing = ((at < 0) & loads.any(axis=2)).any(axis=1)
            work[k, missing] = np.nan
        return work


def _loads(
    found: Sweep, compliance: BodyCompliance, site_teeth: Numbers, z: int
) -> tuple[Numbers, Floats]:
    """Teeth (P, L) that carry load at each position, and their loads (P, L, n) as modes, N.

    Positions with fewer loaded teeth have entries without load.
    """
    pairs = found.pairs
    low, high = compliance.modes.range_mm
    end = high if compliance.modes.tip is None else compliance.modes.tip.end_mm
    s = np.clip(pairs.column(f"s_{z + 1}"), low, end)
    if compliance.modes.nodes is not None:
        values = linear_shapes(s, compliance.modes.nodes)
    else:
        values = mode_values(
            s,
            compliance.modes.range_mm,
            compliance.smooth.shape[1],
            closed=compliance.modes.closed,
            tip=compliance.modes.tip,
        )
    values *= pairs.column("force")[:, None]
    carries = found.site_force_N > 0
    column = np.cumsum(carries, axis=1) - 1
    most = max(1, int(carries.sum(axis=1).max()))
    tooth = np.zeros((len(carries), most), dtype=np.int64)
    p, s_loaded = np.nonzero(carries)
    tooth[p, column[p, s_loaded]] = site_teeth[s_loaded]
    loads = np.zeros((*tooth.shape, values.shape[1]))
    here = carries[pairs.position, pairs.sites]
    position, site = pairs.position[here], pairs.sites[here]
    np.add.at(loads, (position, column[position, site]), values[here])
    return tooth, loads


def of_other_teeth(found: Sweep, others: OtherTeeth) -> dict[str, RemainingError]:
    """Errors of positions that do not contain all teeth, in quantities of the whole period.

    The sweep has its pairs and a torque.
    """
    changes, rotation = others.changes_rad(found), found.rotation_rad
    known = ~np.isnan(changes)
    alone = _weights(others.pair.position_rad, others.window)
    weight = np.where(known, alone, 0.0)
    weight /= weight.sum()
    changes = np.where(known, changes, 0.0)
    spread = DOUBT_SIZE * float((weight * np.abs(changes)).sum())
    most = DOUBT_SIZE * float(np.abs(changes).max())
    now, whole = float(alone @ rotation), float((weight * (rotation + changes)).sum())
    span, all_spans = float(np.ptp(rotation)), float(np.ptp((rotation + changes)[known]))
    errors = {
        "transmission_error_mean": _relative_error(now, whole, spread),
        "transmission_error_peak_to_peak": _relative_error(span, all_spans, most),
    }
    for name, softness in (
        ("stiffness_secant", found.turned_rad),
        ("stiffness_tangent", found.tangent_rad_per_Nmm * found.torque_Nmm),
    ):
        other = softness + changes
        if (softness > 0).all() and (other > 0).all():
            now = float(alone @ (1.0 / softness))
            part = spread / float(alone @ softness)
            errors[name] = _relative_error(now, float((weight / other).sum()), part * now)
    if others.window.closed:
        mean = np.sum(weight * changes, axis=0) / weight.sum(axis=0)
        errors[HARMONICS_KEY] = _of_harmonics(others, rotation, rotation + mean, spread)
    return errors


def _relative_error(now: float, whole: float, spread: float) -> RemainingError:
    """Relative error of a number that has another value over the whole period."""
    return RemainingError.relative(now - whole, float(np.hypot(DOUBT * (now - whole), spread)), now)


def _weights(position_rad: Floats, window: Window) -> Floats:
    """Part of the window (P,) that each position represents."""
    if position_rad.size == 1:
        return np.ones(1)
    if window.closed:
        length = window.pitches * window.pitch_rad
        steps = np.diff(position_rad, append=position_rad[0] + length)
        both = steps + np.roll(steps, 1)
    else:
        steps = np.diff(position_rad)
        both = np.append(steps, 0.0) + np.append(0.0, steps)
    return np.asarray(both / both.sum())


def _of_harmonics(others: OtherTeeth, now: Floats, whole: Floats, spread: float) -> RemainingError:
    """Largest error of the harmonics of a pitch; those of all pitches are those of their mean."""
    weight = _weights(others.pair.position_rad, others.window)
    turn = 2 * np.pi * others.pair.position_rad / others.window.pitch_rad
    waves = 2.0 * weight * np.exp(-1j * np.outer(HARMONICS, turn))
    one, all_of = np.abs(waves @ now), np.abs(waves @ whole)
    scale = np.maximum(one, LEAST_HARMONIC * one.max())
    parts = [
        _relative_error(float(s), float(s + b - a), spread)
        for s, a, b in zip(scale, one, all_of, strict=True)
    ]
    return max(parts, key=lambda part: part.size)
