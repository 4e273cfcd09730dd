"""Positions and motion of the bodies of a result, for its kinematic quantities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.result.coast_side import CoastSide, coast_side

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair


@dataclass(frozen=True, eq=False)
class PairGeometry:
    """Kinematics of both bodies at P positions, and the geometry of their mesh if it is known.

    Attributes
    ----------
    center_distance_mm : float
        Distance of the axes: body 1 rotates about the origin, body 2 about a point on the x axis.
    speed_1, speed_2 : (P,) arrays
        Rotation of both bodies, counter-clockwise, per rad of position.
    contact_ratio : float or None
        Length of the path of contact divided by the base pitch.
    usable_contact_ratio : float or None
        Contact ratio of the part on which both flanks are involutes.
    path_pitches : (float, float) or None
        Ends of the path of contact in base pitches from the pitch point, in the sense of motion.
    coast : CoastSide or None
        Coast flanks.
    coast_unknown : str
        Reason if `coast` is None.
    """

    center_distance_mm: float
    speed_1: NDArray[np.float64]
    speed_2: NDArray[np.float64]
    contact_ratio: float | None = None
    usable_contact_ratio: float | None = None
    path_pitches: tuple[float, float] | None = None
    coast: CoastSide | None = None
    coast_unknown: str = ""


def pair_geometry(
    pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]
) -> PairGeometry:
    """Geometry of a pair; derived quantities are computed on first use.

    Parameters
    ----------
    pair : BodyPair
    compliances : two BodyCompliance
        They contain the displacement of the flanks from their nominal place.

    Returns
    -------
    PairGeometry
    """
    pairing, mesh = pair.pairing, pair.pairing.mesh
    speeds = pairing.speeds(pair.position_rad)
    coast, unknown = coast_side(pair, compliances)
    path = None
    if mesh is not None:
        path = (
            mesh.path_start_mm / mesh.base_pitch_mm,
            mesh.path_end_mm / mesh.base_pitch_mm,
        )
    return PairGeometry(
        center_distance_mm=pairing.center_distance_mm,
        speed_1=speeds[0],
        speed_2=speeds[1],
        contact_ratio=None if mesh is None else mesh.contact_ratio,
        usable_contact_ratio=None if mesh is None else mesh.usable_contact_ratio,
        path_pitches=path,
        coast=coast,
        coast_unknown=unknown,
    )
