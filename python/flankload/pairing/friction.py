"""Friction at the sites of a pairing: coefficients along flank 1, and the driving body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.scene import Scene

SCENE_KEY = "effects.friction_coefficient"

#: Number of steps between two rows of coefficients for the conversion from roll position to arc
#: length, which is quadratic.
ROLL_STEPS = 32


@dataclass(frozen=True)
class Friction:
    """Coulomb friction at S sites.

    `coefficients` (n, S) are at ascending arc lengths (n,) on flank 1, linear in between and
    constant beyond. `sense` is 1 if body 1 drives and turns in the sense of its torque, -1 if it is
    driven against its torque.
    """

    places_mm: NDArray[np.float64]
    coefficients: NDArray[np.float64]
    sense: int = 1

    @property
    def driver(self) -> str:
        """The driving body."""
        return "body_1" if self.sense > 0 else "body_2"

    def speeds(self, pairing: Pairing, position_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Speeds (2, P) of both bodies in their actual direction, rad per rad of the position."""
        return self.sense * np.array(pairing.speeds(position_rad))


def friction_of(scene: Scene, body_1: Body, pairing: Pairing) -> Friction | None:
    """Friction of a scene at the sites of its pairing; None without friction.

    Raises
    ------
    SceneError
        If the length of a list is not the number of teeth, or if the scene has a table over the
        roll position, but the flanks are not involutes.
    """
    if not scene.has_friction:
        return None
    asked = scene.effects.friction_coefficient
    sense = 1 if scene.positions.driver == "body_1" else -1
    ones = np.ones(pairing.sites.size)
    if not isinstance(asked, tuple):
        return Friction(np.zeros(1), (asked or 0.0) * ones[None], sense)
    if isinstance(asked[0], tuple):
        rows = np.array(asked, dtype=float)
        places, values = _along_flank(rows, body_1, pairing)
        return Friction(places, values[:, None] * ones, sense)
    # entry k: the k-th tooth that comes into contact, as for pitch errors; tooth k of a spline
    entries = pairing.sites if pairing.whole_circle else -pairing.sites
    by_tooth = np.array(coefficients_by_tooth(scene, body_1))
    return Friction(np.zeros(1), by_tooth[entries % body_1.teeth][None], sense)


def coefficients_by_tooth(scene: Scene, body_1: Body) -> tuple[float, ...]:
    """One coefficient per tooth of body 1, checked; empty if the scene has no such list."""
    asked = scene.effects.friction_coefficient
    if not isinstance(asked, tuple) or isinstance(asked[0], tuple):
        return ()
    if len(asked) != body_1.teeth:
        raise SceneError(
            key=SCENE_KEY,
            expected=f"one coefficient per tooth of body_1: {body_1.teeth}",
            found=f"{len(asked)} entries",
        )
    return tuple(float(value) for value in asked if not isinstance(value, tuple))


def _along_flank(
    rows: NDArray[np.float64], body: Body, pairing: Pairing
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Arc lengths (n,) and coefficients (n,) from rows of roll position and coefficient (k, 2)."""
    if pairing.gear_geometry is None or body.involute is None:
        raise SceneError(
            key=SCENE_KEY,
            expected="a number, or one per tooth of body_1: only pairs of involutes have a roll "
            "position",
            found="a table over the roll position",
        )
    steps = np.arange(ROLL_STEPS * (len(rows) - 1) + 1) / ROLL_STEPS
    roll = np.interp(steps, np.arange(len(rows)), rows[:, 0])
    base = body.involute.base_radius_mm
    pitch_radius = pairing.center_distance_mm * pairing.ratio / (1.0 + pairing.ratio)
    at_pitch_point = np.sqrt(max(0.0, pitch_radius**2 - base**2))
    radius = np.hypot(base, np.maximum(at_pitch_point + roll, 0.0))
    s = _arc_lengths(body, radius)
    # rows beyond the flank have the arc length of its end
    kept = np.append(True, np.diff(s) > 0.0)
    return s[kept], np.interp(steps, np.arange(len(rows)), rows[:, 1])[kept]


def _arc_lengths(body: Body, radius: NDArray[np.float64]) -> NDArray[np.float64]:
    """Arc lengths on the flank at distances from the axis; limited to the ends of the flank."""
    curve = body.curve
    s = np.linspace(body.mode_range_mm[0], curve.length_mm, 4001)
    distance = np.maximum.accumulate(np.hypot(*curve.point(s).T))
    return np.asarray(np.interp(radius, distance, s))


def friction_notes(friction: Friction | None, pairing: Pairing, slices: Slices) -> Iterator[str]:
    """Remarks on the friction of a pair for the user."""
    height = slices.conforming
    leans = height is not None and height.tilt.any()
    if friction is not None and pairing.center_distance_mm <= 0.0 and not leans:
        yield (
            "on a common axis both bodies turn together and no flank slides: friction has no "
            "effect (pair.center_offset_mm separates the axes, pair.misalignment_mrad tilts one)"
        )
