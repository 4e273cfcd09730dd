"""Results of friction: forces along the flanks, losses, torque on body 2."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flankload.base.arrays import Floats
from flankload.base.card import Card
from flankload.base.torque import in_newton_metres

#: Arrays over the positions, with their units.
ALONG_POSITIONS = {"torque_2_Nm": "N m", "loss_J_per_rad": "J/rad"}


@dataclass(frozen=True, eq=False, repr=False)
class FrictionResult(Card):
    """Friction at P positions on S sites, for one torque.

    Attributes
    ----------
    driver : str
        "body_1" or "body_2".
    speed_1, speed_2 : (P,) arrays
        Speeds of both bodies, rad per rad of the position, negative if opposite to increasing
        position.
    torque_2_Nm : (P,) array
        Moment about the axis of body 2 of all forces on it, including friction, at the places of
        the contact pairs on flank 1; positive in the sense of rotation of body 2 for increasing
        position.
    loss_J_per_rad : (P,) array
        Work of friction per rad of the position: sum of friction force multiplied by sliding speed.
    site_friction_N : (P, S) array
        Friction force of each flank pair on body 1, in the direction of increasing arc length of
        its flank (towards the tip of a gear).
    loss_work_J, work_1_J, work_2_J : float or None
        Absolute work of friction, of the torque on body 1 and of `torque_2_Nm` over one period;
        None if the positions do not cover the period. The last two differ by the first, except for
        the residual of the pairing on circles (less than 0.1 % of the work, with or without
        friction).
    tilting_moment_Nm : (P,) array or None
        Moment of the friction forces on body 1 about the middle of the face width, at right angles
        to that of the normal forces; positive if more of the force towards the tip acts at larger
        z. Of a spline the magnitude of `tilting_moments_Nm`. None in the plane.
    axial_force_N : (P,) array or None
        Axial friction force on the shaft of a spline in three dimensions, positive along z.
    tilting_moments_Nm : (P, 2) array or None
        Moment of the friction forces on the hub of a spline in three dimensions about x and y,
        about the middle of its axis.
    """

    driver: str
    speed_1: Floats
    speed_2: Floats
    torque_2_Nm: Floats
    loss_J_per_rad: Floats
    site_friction_N: Floats
    loss_work_J: float | None
    work_1_J: float | None
    work_2_J: float | None
    tilting_moment_Nm: Floats | None = None
    axial_force_N: Floats | None = None
    tilting_moments_Nm: Floats | None = None

    @property
    def efficiency(self) -> float | None:
        """Work of the driven body divided by that of the driver, over one period.

        From the work of body 1 and the loss, since the residual of the pairing in `work_2_J` would
        appear as a loss. None without a whole period or without torque.
        """
        work, loss = self.work_1_J, self.loss_work_J
        if not work or loss is None:
            return None
        return (work - loss) / work if self.driver == "body_1" else work / (work + loss)

    def as_dict(self) -> dict[str, Any]:
        """Friction in the form of the files."""
        works = ("loss_work_J", "work_1_J", "work_2_J", "efficiency")
        keys = ("driver", *ALONG_POSITIONS, "site_friction_N", *works)
        some = ("tilting_moment_Nm", "axial_force_N", "tilting_moments_Nm")
        present = [key for key in some if getattr(self, key) is not None]
        return {key: getattr(self, key) for key in (*keys, *present)}


def friction_result(
    pairs: Mapping[str, NDArray[Any]],
    *,
    n_sites: int,
    n_working: int,
    center_distance_mm: float,
    speeds: Floats,
    driver: str,
    torque_1_Nm: float,
    over_period: Callable[[Floats], float | None],
    tilt: Floats | None = None,
) -> FrictionResult:
    """Sum over the pairs of all positions.

    Parameters
    ----------
    pairs : mapping
        Columns x, y, normal_x, normal_y, force, sliding, friction of N pairs, mm, N, and numbers
        of each pair's position and site; `in_section` is the part of a normal force that lies in
        the transverse section. In three dimensions z, from the middle of the face width. Of
        splines there axial_sliding and axial_friction as well, as sliding and friction along z.
    n_sites, n_working : int
        Number of sites; from n_working on they are those of coast flanks.
    speeds : (2, P) array
        As in `FrictionResult`.
    over_period : callable
        Integral of a quantity (P,) over one period, None if it is unknown.
    tilt : (2,) array or None
        For splines in three dimensions: displacement of the hub's axis per length along z.
    """
    n, position = speeds.shape[1], pairs["position"]
    force, friction = pairs["force"], pairs["force"] * pairs["friction"]
    # on body 2: n F - mu sigma t F, where t is n rotated backward, on coast flanks forward
    turned = np.where(pairs["site"] < n_working, friction, -friction)
    across = force * pairs["in_section"]
    force_x = pairs["normal_x"] * across - pairs["normal_y"] * turned
    force_y = pairs["normal_y"] * across + pairs["normal_x"] * turned
    moment = (pairs["x"] - center_distance_mm) * force_y - pairs["y"] * force_x
    sense = 1.0 if driver == "body_1" else -1.0
    cell = position * n_sites + pairs["site"]
    site_friction = np.bincount(cell, friction, minlength=n * n_sites).astype(np.float64)

    def over_positions(values: Floats) -> Floats:
        return in_newton_metres(np.bincount(position, values, minlength=n).astype(np.float64))

    losses, tilting, axial, moments = friction * pairs["sliding"], None, None, None
    if "z" in pairs:
        tilting = over_positions(friction * pairs["z"])
    if tilt is not None:
        along = force * pairs["axial_friction"]
        losses = losses + along * pairs["axial_sliding"]
        x, y, z = pairs["x"] - center_distance_mm, pairs["y"], pairs["z"]
        # the axis of body 2 leans
        moment = moment + tilt[0] * -(y * along + z * force_y) + tilt[1] * (z * force_x + x * along)
        friction_x, friction_y = -pairs["normal_y"] * turned, pairs["normal_x"] * turned
        about_x, about_y = -y * along - z * friction_y, z * friction_x + x * along
        moments = np.stack([over_positions(about_x), over_positions(about_y)], axis=1)
        tilting = np.hypot(*moments.T)
        axial = np.bincount(position, along, minlength=n).astype(np.float64)
    torque_2 = over_positions(moment) * sense * np.sign(speeds[1])
    loss = over_positions(losses)
    return FrictionResult(
        driver=driver,
        speed_1=speeds[0],
        speed_2=speeds[1],
        torque_2_Nm=torque_2,
        loss_J_per_rad=loss,
        site_friction_N=site_friction.reshape(n, n_sites),
        loss_work_J=over_period(loss),
        work_1_J=over_period(torque_1_Nm * np.abs(speeds[0])),
        work_2_J=over_period(torque_2 * np.abs(speeds[1])),
        tilting_moment_Nm=tilting,
        axial_force_N=axial,
        tilting_moments_Nm=moments,
    )
