"""Premises of the model that flank pairs can break.

Geometry breaks them before elements are solved, a load breaks them after the sweep.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import ContactError, NoContactState
from flankload.mechanisms.flank_pair.backlash import ROUNDING_UM, coast_overlap_um, key_of_backlash
from flankload.mechanisms.premises import (
    Broken,
    Premise,
    Torque,
    broken_by_turn,
    held,
    largest_turn,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from flankload.contact.sweep import Sweep
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.gear_pair import Mesh
    from flankload.result.geometry import PairGeometry
    from flankload.scene import Scene

    Floats = NDArray[np.float64]

#: Parts of a torque without an answer that are tried, until one of them has one.
PARTS = tuple(0.25**k for k in range(1, 9))
#: A contact ratio less by that is 1.
ROUNDING = 1e-9


#: With less there are positions at which a tip corner alone carries, whose pressure has no limit.
CONTACT_RATIO = Premise("contact_ratio", 1.0, "a contact ratio of at least 1")
#: Coast flanks that overlap carry, too.
BACKLASH = Premise(
    "backlash",
    0.0,
    "coast flanks that stay apart, since they carry nothing without effects.coast_flank = true",
)
#: Finite elements that follow the deformed shape differ by 1.1 % at 0.031 of a pitch, 0.1 of a
#: module, and by 1.9 % at twice as much.
DEFLECTION = Premise("deflection", 0.1, "flanks that give way by at most 0.1 of a module")
#: Far beyond it strains are not small; metals yield at a hundredth, polymers at a tenth.
PRESSURE = Premise(
    "pressure", 0.5, "pressures of at most 0.5 of Young's modulus, that of the softer body"
)


# --- before elements are solved -------------------------------------------------------------------
def broken_by_geometry(pair: BodyPair) -> Iterator[Broken]:
    """What is broken whatever the load is.

    Parameters
    ----------
    pair : BodyPair

    Yields
    ------
    Broken
    """
    mesh = pair.pairing.mesh
    if mesh is None or _contact_ratio(mesh) >= CONTACT_RATIO.limit - ROUNDING:
        return
    yield Broken(
        CONTACT_RATIO,
        "pair.center_distance_mm",
        f"{_contact_ratio(mesh):.4g} on {pair.pairing.center_distance_mm:g} mm with these tip "
        "diameters",
    )


def _contact_ratio(mesh: Mesh) -> float:
    """The contact ratio that counts."""
    return mesh.contact_ratio


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
    """What a torque breaks.

    Parameters
    ----------
    scene : Scene
    pair : BodyPair
        As its bodies have grown.
    geometry : PairGeometry
        At the positions of the sweep.
    found : Sweep
    number : int
        Of the torque.
    part : float
        Part of that torque of which the sweep is.

    Yields
    ------
    Broken
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
    elastic = (body for body in (pair.body_1, pair.body_2) if not body.rigid)
    softer = [body.material.young_modulus_MPa for body in elastic]
    pressure = _peak_off_corners(found) / scene.pair.face_width_mm
    if softer and pressure > PRESSURE.limit * min(softer):
        amount = f"{pressure / min(softer):.3g} of {min(softer):g} MPa"
        yield torque.broken(PRESSURE, amount)
    # without torque nothing carries: the rotation is that of the working flanks by definition
    overlap_um = coast_overlap_um(pair, geometry, found) if found.torque_Nmm > 0.0 else 0.0
    if overlap_um > ROUNDING_UM:
        yield Broken(
            BACKLASH,
            key_of_backlash(scene),
            f"about {overlap_um:.3g} um of overlap {torque.under}",
        )


def blame_load(
    scene: Scene,
    pair: BodyPair,
    geometry: PairGeometry,
    error: ContactError,
    run: Callable[[float], tuple[Sweep, ...]],
) -> None:
    """Refuse a scene whose torque has no answer where a part of it breaks a premise already.

    Parameters
    ----------
    scene, pair, geometry
        As of `broken_by_load`.
    error : ContactError
        Why there is none; a proof that there is no state has another reason.
    run : callable
        Sweeps under one torque, N mm.

    Raises
    ------
    PremiseError
    """
    if isinstance(error, NoContactState) and error.proven:
        return
    torque_Nmm = max(scene.torques_Nmm)
    number = scene.torques_Nmm.index(torque_Nmm)
    for part in PARTS:
        try:
            (found,) = run(part * torque_Nmm)
        except ContactError:
            continue
        held(scene, tuple(broken_by_load(scene, pair, geometry, found, number, part=part)))
        return


def _peak_off_corners(found: Sweep) -> float:
    """Largest pressure times face width, N/mm; on sharp corners it means nothing."""
    sites = [(found.site_peak_N_per_mm, found.site_corner)]
    if found.coast is not None:
        sites.append((found.coast.site_peak_N_per_mm, found.coast.site_corner))
    return max(float(np.max(peak, where=corner <= 0, initial=0.0)) for peak, corner in sites)
