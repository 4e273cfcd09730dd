"""Premises of the model that flank pairs can violate.

Geometry is checked before finite elements are solved, loads after the sweep.
"""

from __future__ import annotations

from math import cos
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE
from flankload.contact.status import on_corner
from flankload.errors import ContactError, NoContactState
from flankload.mechanisms.flank_pair.rims import held_rim
from flankload.mechanisms.premises import (
    Broken,
    Premise,
    Torque,
    broken_by_turn,
    largest_turn,
    require_premises,
)
from flankload.scene.axial import MISALIGNMENTS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.geometry import PairGeometry
    from flankload.scene import Scene


#: Fractions of a torque without a solution, tried until one has a solution.
TORQUE_RATIOS = tuple(0.25**k for k in range(1, 9))
#: Ratio of the bending of loaded teeth, which moves their coast flanks, to the rotation under load.
#: On the FZG type C pair under 30 to 900 N m, an overlap of coast flanks without torque of 0.14 of
#: that rotation carries no load; 0.19 changes the transmission error by 0.5 %, 0.43 by 9 %.
BENDING_RATIO = 0.8
#: Least overlap of coast flanks above roundoff, um.
GAP_TOLERANCE_UM = 1e-3


#: Below it, a tip corner carries all the load at some positions, with unbounded pressure. Helical
#: teeth have contact in another section of the width there: their overlap ratio counts as well.
CONTACT_RATIO = Premise("contact_ratio", 1.0, "a contact ratio of at least 1")
#: Overlapping coast flanks carry load.
BACKLASH = Premise(
    "backlash",
    0.0,
    "coast flanks that stay apart, since they carry nothing without effects.coast_flank = true",
)
#: Finite elements with large displacements differ by 1.1 % at 0.031 of a pitch, 0.1 of a module,
#: and by 1.9 % at twice as much.
DEFLECTION = Premise("deflection", 0.1, "flank deflections of at most 0.1 of a module")
#: Far above this limit strains are not small; metals yield at 0.01 of the modulus, polymers at 0.1.
PRESSURE = Premise(
    "pressure", 0.5, "pressures of at most 0.5 of Young's modulus, that of the softer body"
)


# --- before elements are solved -------------------------------------------------------------------
def broken_by_geometry(pair: BodyPair) -> Iterator[Broken]:
    """Premises that are violated at any load."""
    yield from broken_rims(pair.names, pair.bodies)
    mesh = pair.pairing.gear_geometry
    if mesh is None or mesh.total_contact_ratio >= CONTACT_RATIO.limit - TIE:
        return
    parts, width = "", ""
    if mesh.overlap_ratio:
        parts = f" ({mesh.contact_ratio:.4g} transverse + {mesh.overlap_ratio:.4g} overlap)"
        width = " and this face width"
    yield Broken(
        CONTACT_RATIO,
        "pair.center_distance_mm",
        f"{mesh.total_contact_ratio:.4g}{parts} on {pair.pairing.center_distance_mm:g} mm with "
        f"these tip diameters{width}",
    )


def broken_rims(names: Sequence[str], bodies: Sequence[Body]) -> Iterator[Broken]:
    """Rims that are too thin to be held."""
    for name, body in zip(names, bodies, strict=True):
        rim = held_rim(body)
        if rim is not None and rim.ratio < rim.least:
            wanted = f'a held rim of at least {rim.least:g} {rim.unit}, or {rim.support} = "torque"'
            amount = f"{rim.ratio:.2f} {rim.unit} ({rim.thickness_mm:.3g} mm)"
            yield Broken(Premise("rim", rim.least, wanted), f"{name}.{rim.held_at}", amount)


# --- after the sweep ------------------------------------------------------------------------------
def broken_by_load(
    scene: Scene,
    pair: BodyPair,
    geometry: PairGeometry,
    found: Sweep,
    number: int,
    *,
    part: float = 1.0,
) -> Iterator[Broken]:
    """Premises that a torque violates, by its index, or the part of it that loads the sweep.

    `pair` includes the expansion of its bodies; `geometry` is that at the positions of the sweep.
    """
    torque = Torque(scene, number, part)
    turned_rad = largest_turn(found.torque_Nmm * found.tangent_rad_per_Nmm)
    deflection_mm = turned_rad * pair.body_1.reference_radius_mm
    involute = pair.body_1.involute
    if involute is not None:
        module = 2.0 * involute.reference_radius_mm / pair.body_1.teeth
        if deflection_mm > DEFLECTION.limit * module:
            amount = f"{deflection_mm / module:.3g} of a module ({deflection_mm:.3g} mm)"
            yield torque.broken(DEFLECTION, amount)
    yield from broken_by_turn(turned_rad, pair.pairing.pitch_rad, torque)
    elastic = (body for body in pair.bodies if not body.rigid)
    softer = [body.material.young_modulus_MPa for body in elastic]
    # slices have pressures, cells force per length
    width_mm = pair.slices.compliance_width_mm
    pressure = _peak_off_corners(found) / width_mm
    if softer and pressure > PRESSURE.limit * min(softer):
        amount = f"{pressure / min(softer):.3g} of {min(softer):g} MPa"
        yield torque.broken(PRESSURE, amount)
    # without torque there is no contact force: the working flanks define the rotation
    overlap_um = coast_overlap_um(pair, geometry, found) if found.torque_Nmm > 0.0 else 0.0
    if overlap_um > GAP_TOLERANCE_UM:
        yield Broken(
            BACKLASH,
            _key_of_backlash(scene, pair),
            f"about {overlap_um:.3g} um of overlap {torque.under}",
        )


def blame_load(
    scene: Scene,
    pair: BodyPair,
    geometry: PairGeometry,
    error: ContactError,
    run: Callable[[float], tuple[Sweep, ...]],
) -> None:
    """Raise a PremiseError if a part of a torque without solution already violates a premise.

    `error` is the reason for the missing solution: a proof that no state exists is not examined.
    `run` sweeps under one torque, N mm.
    """
    if isinstance(error, NoContactState) and error.proven:
        return
    torque_Nmm = max(scene.torques_Nmm)
    number = scene.torques_Nmm.index(torque_Nmm)
    for part in TORQUE_RATIOS:
        try:
            (found,) = run(part * torque_Nmm)
        except ContactError:
            continue
        require_premises(scene, broken_by_load(scene, pair, geometry, found, number, part=part))
        return


def _peak_off_corners(found: Sweep) -> float:
    """Largest pressure times face width, N/mm, of slices without it; without sharp corners."""
    sites = [(found.site_peak_N_per_mm, found.site_corner)]
    if found.coast is not None:
        sites.append((found.coast.site_peak_N_per_mm, found.coast.site_corner))
    return max(float(np.max(peak, where=~on_corner(corner), initial=0.0)) for peak, corner in sites)


# --- coast flanks that are not simulated ----------------------------------------------------------
def coast_overlap_um(pair: BodyPair, geometry: PairGeometry, found: Sweep) -> float:
    """Overlap of coast flanks after rotation and bending of the teeth; 0 if they cannot touch.

    `pair` includes the expansion of its bodies; `found` has its tangents.
    """
    coast = geometry.coast
    if coast is None or not _may_close(pair):
        return 0.0
    wind_up_rad = found.torque_Nmm * found.tangent_rad_per_Nmm
    bent_rad = BENDING_RATIO * np.where(np.isfinite(wind_up_rad), wind_up_rad, 0.0)
    gap_rad = coast.gap_rad + found.rotation_rad - bent_rad
    known = np.isfinite(gap_rad)
    overlap_mm = -coast.base_radius_mm * float(np.min(gap_rad, where=known, initial=0.0))
    mesh = pair.pairing.gear_geometry
    rounding_mm = 0.0 if mesh is None else mesh.overlap_by_rounding_mm
    return 1000.0 * max(0.0, overlap_mm - rounding_mm)


def _key_of_backlash(scene: Scene, pair: BodyPair) -> str:
    """The key that most probably removes the backlash."""
    grown = scene.effects.temperature_rise_K
    if np.any(grown if grown is not None else 0.0):
        return "effects.temperature_rise_K"
    if scene.effects.speed_rpm:
        return "effects.speed_rpm"
    bodies = (("body_1", scene.body_1), ("body_2", scene.body_2))
    for key, body in bodies:
        if any(error > 0.0 for error in body.pitch_errors_um):
            return f"{key}.pitch_errors_um"
    for key, body in bodies:
        for name in ("topography_file", "profile_twist_um"):
            if getattr(body, name, None):
                return f"{key}.{name}"
    mesh, angles = pair.pairing.gear_geometry, MISALIGNMENTS[:2]
    if mesh is not None and (mesh.backlash_mm >= 0.0 or mesh.overlap_by_rounding_mm):
        most = max(angles, key=lambda name: abs(getattr(scene.pair, name)))
        if getattr(scene.pair, most):
            return f"pair.{most}"
    return "pair.center_offset_mm" if scene.pair.center_offset_mm else "pair.center_distance_mm"


def _may_close(pair: BodyPair) -> bool:
    """Whether anything can remove the whole backlash; keys that only remove metal cannot."""
    if pair.effects.coast_flanks:
        return False
    bodies, mesh, fit = pair.bodies, pair.pairing.gear_geometry, pair.pairing.fit
    if any(job.body_load is not None for job in pair.jobs) or any(
        body.flank_turns_rad for body in bodies
    ):
        return True
    clearance = 0.0
    if mesh is not None:
        clearance = mesh.backlash_mm * cos(mesh.pressure_angle_rad)
    elif fit is not None:
        clearance = fit.normal_backlash_mm - 2.0 * fit.offset_mm
    added_mm = sum(max((0.0, *body.pitch_errors_um)) for body in bodies) / 1000.0
    surfaces = (body.axial.surface for body in bodies)
    added_mm += sum(surface.most_added_mm for surface in surfaces if surface is not None)
    return clearance <= added_mm
