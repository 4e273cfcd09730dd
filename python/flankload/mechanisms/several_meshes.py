"""Several gear meshes in one contact problem: positions and premises of such drives."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from flankload.contact.status import on_corner
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.premises import DEFLECTION, PRESSURE
from flankload.mechanisms.premises import Torque, broken_by_turn, largest_turn

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats
    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.mechanisms.premises import Broken
    from flankload.scene import Scene

#: Largest number of positions of a scene.
MOST_POSITIONS = 100_000


class SeveralMeshes(Protocol):
    """Bodies in several gear meshes before their elements are solved; the first has the torque."""

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies."""

    @property
    def pairing(self) -> Any:
        """Meshes with the tooth pitch of body 1, `pitch_rad`."""


def positions_of_meshes(scene: Scene, teeth: int, period: int) -> tuple[Floats, int | None]:
    """(P,) Angles of the sun relative to the carrier, and the pitches that they cover."""
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float)), None
    pitches = period if wanted.pitches == "hunting" else int(wanted.pitches)
    if wanted.count * pitches > MOST_POSITIONS:
        raise SceneError(
            key="positions.pitches",
            expected=f"at most {MOST_POSITIONS // wanted.count}, so that there are at most "
            f"{MOST_POSITIONS} positions",
            found=f"{pitches} pitches of {wanted.count} positions",
        )
    return 2 * pi / teeth * np.arange(wanted.count * pitches) / wanted.count, pitches


def broken_by_torque(
    scene: Scene, assembly: SeveralMeshes, found: Sweep, number: int, width_mm: float
) -> Iterator[Broken]:
    """Premises that a torque violates: small deflections, small strains.

    `found` are the states of all meshes together, `width_mm` the width of their compliances.
    """
    torque = Torque(scene, number)
    turned_rad = largest_turn(found.torque_Nmm * found.tangent_rad_per_Nmm)
    yield from broken_by_turn(turned_rad, assembly.pairing.pitch_rad, torque)
    first = assembly.bodies[0]
    deflection = turned_rad * first.reference_radius_mm / scene.body_1.module_mm  # type: ignore[union-attr]
    if deflection > DEFLECTION.limit:
        yield torque.broken(DEFLECTION, f"{deflection:.3g} of a module")
    modulus = min(body.material.young_modulus_MPa for body in assembly.bodies)
    smooth = ~on_corner(found.site_corner)
    peaks = found.site_peak_N_per_mm / width_mm
    largest = float(np.max(peaks, initial=0.0, where=smooth)) / modulus
    if largest > PRESSURE.limit:
        yield torque.broken(PRESSURE, f"{largest:.3g} of Young's modulus")
