"""Check whether coast flanks that are not simulated would touch under load."""

from __future__ import annotations

from math import cos
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.contact.sweep import Sweep
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.geometry import PairGeometry
    from flankload.scene import Scene

#: Loaded teeth, and their coast flanks with them, bend back by this part of the rotation under
#: load: on the FZG type C pair under 30 to 900 N m, coast flanks that overlap by 0.14 of that
#: rotation before there is torque carry no load; 0.19 changes the transmission error by 0.5 %, 0.43
#: by 9 %.
LEAN = 0.8
#: Coast flanks that overlap by less are separated except for rounding, um.
ROUNDING_UM = 1e-3


def coast_overlap_um(pair: BodyPair, geometry: PairGeometry, found: Sweep) -> float:
    """Overlap of coast flanks after rotation and bending of the teeth; 0 if they cannot touch.

    `pair` includes the expansion of its bodies; `found` has its tangents.
    """
    coast = geometry.coast
    if coast is None or not _may_close(pair):
        return 0.0
    wind_up_rad = found.torque_Nmm * found.tangent_rad_per_Nmm
    bent_rad = LEAN * np.where(np.isfinite(wind_up_rad), wind_up_rad, 0.0)
    gap_rad = coast.gap_rad + found.rotation_rad - bent_rad
    known = np.isfinite(gap_rad)
    return -1000.0 * coast.base_radius_mm * float(np.min(gap_rad, where=known, initial=0.0))


def key_of_backlash(scene: Scene) -> str:
    """The key that most probably removes the backlash."""
    grown = scene.effects.temperature_rise_K
    if np.any(grown if grown is not None else 0.0):
        return "effects.temperature_rise_K"
    if scene.effects.speed_rpm:
        return "effects.speed_rpm"
    for key, body in (("body_1", scene.body_1), ("body_2", scene.body_2)):
        if any(error > 0.0 for error in body.pitch_errors_um):
            return f"{key}.pitch_errors_um"
    for key, body in (("body_1", scene.body_1), ("body_2", scene.body_2)):
        for name in ("topography_file", "profile_twist_um"):
            if getattr(body, name, None):
                return f"{key}.{name}"
    return "pair.center_offset_mm" if scene.pair.center_offset_mm else "pair.center_distance_mm"


def _may_close(pair: BodyPair) -> bool:
    """Whether anything can remove more than the backlash; keys that only remove metal never do."""
    if pair.effects.coast_flanks:
        return False
    bodies, mesh, fit = (pair.body_1, pair.body_2), pair.pairing.mesh, pair.pairing.fit
    if any(growth is not None for growth in pair.growth) or any(
        body.flank_turns_rad for body in bodies
    ):
        return True
    room = 0.0
    if mesh is not None:
        room = mesh.backlash_mm * cos(mesh.pressure_angle_rad)
    elif fit is not None:
        room = fit.normal_backlash_mm - 2.0 * fit.offset_mm
    added_mm = sum(max((0.0, *body.pitch_errors_um)) for body in bodies) / 1000.0
    surfaces = [body.axial.surface for body in bodies if body.axial is not None]
    added_mm += sum(surface.most_added_mm for surface in surfaces if surface is not None)
    return room <= added_mm
