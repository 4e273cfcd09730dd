"""Motion of a follower on its cam: the follower's angle at each angle of the cam.

The follower's axis is O1 = (0, 0), the cam's axis O2 = (centre distance, 0). The follower turns
counter-clockwise onto the cam and stops at the first contact. Candidates are the points of the
profile at which roller or flat would be tangent; no other point is reached before the first one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import Roller
from flankload.errors import SceneError
from flankload.pairing.interference import along

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body, Flat
    from flankload.flank import FlankCurve


#: Samples in each interval of the profile, between which zeros are searched.
SAMPLES = 4
MOST_STEPS = 40
#: Number of positions that are processed at once, to limit memory.
BLOCK = 256
#: Least lever arm of the force about the follower's axis, over the distance of the contact from
#: there; with less, the force for a torque is too large.
LEAST_LEVER = 0.1
#: Largest radius of a roller over the radius of a hollow of the cam.
LARGEST_ROLLER_RATIO = 0.98


@dataclass(frozen=True)
class ProfilePoints:
    """Points (m,) of a profile: arc lengths, mm, and vectors (m, 2) in its frame.

    `point` is relative to the axis of the profile or to another origin; `curvature`, 1/mm, is
    positive where the profile is convex.
    """

    s: Floats
    point: Floats
    tangent: Floats
    normal: Floats
    curvature: Floats

    def shifted(self, shift: Floats) -> ProfilePoints:
        """The same points relative to another origin: `shift` (m, 2) or (2,) is added."""
        return ProfilePoints(self.s, self.point + shift, self.tangent, self.normal, self.curvature)

    def repeated(self, count: int) -> ProfilePoints:
        """All points, repeated `count` times."""
        return ProfilePoints(*(np.concatenate([part] * count) for part in vars(self).values()))


def profile_points(curve: FlankCurve, s: Floats) -> ProfilePoints:
    """Points of a curve at arc lengths s (m,)."""
    return ProfilePoints(s, curve.point(s), curve.tangent(s), curve.normal(s), curve.curvature(s))


@dataclass(frozen=True)
class CamMotion:
    """A follower on its cam.

    The curve of the cam is closed, in its own frame; the head is in the frame of the follower;
    `sense` is 1 if the cam turns counter-clockwise, -1 if clockwise.
    """

    cam: FlankCurve
    head: Roller | Flat
    center_distance_mm: float
    sense: int

    def cam_turns(self, position_rad: Floats) -> Floats:
        """Angles (P,) of the cam's frame, whose angle 0 points from O2 to O1 at position 0."""
        return np.pi + self.sense * np.asarray(position_rad, dtype=float)

    def contacts(self, position_rad: Floats) -> CamContacts:
        """Angles and contact points at positions (P,), the angles by which the cam has turned.

        Raises
        ------
        SceneError
            If the follower misses the cam at a position, or meets it with an end of its flat.
        """
        position = np.atleast_1d(np.asarray(position_rad, dtype=float))
        turn_2 = self.cam_turns(position)
        parts = [
            self._contacts_of(turn_2[k : k + BLOCK], position[k : k + BLOCK])
            for k in range(0, position.size, BLOCK)
        ]
        s, turn_1 = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
        return CamContacts(self, position, turn_1, turn_2, s)

    def _contacts_of(self, turn_2: Floats, position: Floats) -> tuple[Floats, Floats]:
        s, turn_1 = first_contact(turn_2.size, *self._tangent_places(turn_2))
        if isinstance(self.head, Roller):
            _refuse_where(
                np.isnan(turn_1),
                position,
                "body_1.arm_mm",
                "arm and roller that reach the cam",
                lambda k: "none",
            )
            return s, turn_1
        ends = [self._end_places(turn_2, end) for end in self.head.ends_mm]
        _, at_end = first_contact(
            turn_2.size, *(np.concatenate([one, two]) for one, two in zip(*ends, strict=True))
        )
        first = np.fmin(turn_1, at_end)
        _refuse_where(
            np.isnan(first), position, "body_1.flat_to_mm", "a flat that reaches the cam",
            lambda k: "none",
        )  # fmt: skip
        _refuse_where(
            np.isnan(turn_1) | (at_end < turn_1),
            position,
            "body_1.flat_to_mm",
            "a flat that reaches over every place of contact",
            lambda k: "a contact beyond its ends",
        )
        return s, turn_1

    @cached_property
    def samples(self) -> ProfilePoints:
        """Points all around the cam, in its frame."""
        return profile_points(self.cam, along(self.cam, SAMPLES))

    def shift(self, turn_2: Floats) -> Floats:
        """Vector from O1 to O2 (P, 2) in the frame of the cam, mm."""
        return self.center_distance_mm * np.stack([np.cos(turn_2), -np.sin(turn_2)], axis=1)

    def _zeros(
        self, turn_2: Floats, residual: Callable[[ProfilePoints], tuple[Floats, Floats]]
    ) -> tuple[NDArray[np.int64], ProfilePoints]:
        """Positions, and points relative to O1, at which a function changes its sign."""
        shift = self.shift(turn_2)
        k, s = zeros_on(self.cam, self.samples, shift, residual)
        return k, profile_points(self.cam, s).shifted(shift[k])

    def _tangent_places(self, turn_2: Floats) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Positions, arc lengths and follower angles of all points of tangency."""
        head = self.head
        if isinstance(head, Roller):
            radius, arm = head.radius_mm, head.arm_mm

            def from_arm(at: ProfilePoints) -> tuple[Floats, Floats]:
                centre = at.point + radius * at.normal
                bend = 1 + radius * at.curvature
                return dot(centre, centre) - arm**2, 2 * bend * dot(centre, at.tangent)

            k, at = self._zeros(turn_2, from_arm)
            return k, at.s, polar(at.point + radius * at.normal, turn_2[k])
        offset, (low, high) = head.offset_mm, head.ends_mm

        def from_line(at: ProfilePoints) -> tuple[Floats, Floats]:
            return -dot(at.normal, at.point) - offset, -at.curvature * dot(at.point, at.tangent)

        k, at = self._zeros(turn_2, from_line)
        # the flat and the cam's tangent have opposite directions
        place = -dot(at.point, at.tangent)
        there = (place >= low) & (place <= high)
        return k[there], at.s[there], polar(-at.tangent, turn_2[k])[there]

    def _end_places(self, turn_2: Floats, end: float) -> tuple[NDArray[np.int64], Floats, Floats]:
        """The same for all points at which an end of the flat is on the cam."""
        assert not isinstance(self.head, Roller)
        offset = self.head.offset_mm

        def from_end(at: ProfilePoints) -> tuple[Floats, Floats]:
            return dot(at.point, at.point) - end**2 - offset**2, 2 * dot(at.point, at.tangent)

        k, at = self._zeros(turn_2, from_end)
        return k, at.s, wrapped(polar(at.point, turn_2[k]) - np.arctan2(offset, end))


@dataclass(frozen=True)
class CamContacts:
    """Angles and contact points of a follower at P positions.

    `turn_1`, `turn_2` (P,) are the angles of both frames, rad; `arc_length_mm` (P,) gives the
    contact points on the cam.
    """

    motion: CamMotion
    position_rad: Floats
    turn_1: Floats
    turn_2: Floats
    arc_length_mm: Floats

    def contact(self) -> tuple[Floats, Floats]:
        """Contact points (P, 2) from O1, and the cam's normals there, in the common frame."""
        at = profile_points(self.motion.cam, self.arc_length_mm)
        point = at.point + self.motion.shift(self.turn_2)
        return turned(point, self.turn_2), turned(at.normal, self.turn_2)

    def rate(self) -> Floats:
        """Rotation (P,) of the follower per rad of the cam, from equal normal velocities."""
        point, normal = self.contact()
        centre = np.array([self.motion.center_distance_mm, 0.0])
        return self.motion.sense * cross(point - centre, normal) / cross(point, normal)

    def levers(self) -> Floats:
        """Lever arms (P,) of the force about the follower's axis, mm; positive: clockwise."""
        point, normal = self.contact()
        return -cross(point, normal)

    def check(self) -> None:
        """Raise a SceneError if the lever arm is too short, or the arm touches the cam."""
        head = self.motion.head
        point, normal = self.contact()
        lever, radius = self.levers(), np.hypot(*point.T)
        if isinstance(head, Roller):
            angle = wrapped(np.arctan2(-normal[:, 1], -normal[:, 0]) - self.turn_1)
            _refuse_where(
                angle > head.angles_rad[1],
                self.position_rad,
                "body_1.arm_width_mm",
                "an arm that leaves the roller free where it touches",
                lambda k: f"contact {np.degrees(np.pi - angle[k]):.2f} deg from the arm's middle",
            )
        _refuse_where(
            lever < LEAST_LEVER * radius,
            self.position_rad,
            "pair.center_distance_mm",
            f"a force line that stays off the follower's axis by {LEAST_LEVER:g} of the distance "
            "of the contact",
            lambda k: f"{lever[k]:.4f} mm off at a contact {radius[k]:.4f} mm from that axis",
        )


def cam_motion(follower: Body, cam: Body, center_distance_mm: float) -> CamMotion:
    """Combine a follower and its cam.

    Raises a SceneError if the cam extends to the follower's hub, or if the roller does not fit into
    a hollow.
    """
    head = follower.touches
    assert head is not None
    motion = CamMotion(cam.curve, head, center_distance_mm, -1 if cam.turns_clockwise else 1)
    reach = float(np.hypot(*motion.samples.point.T).max())
    hub = float(np.hypot(*follower.outline.T).min())
    if center_distance_mm <= reach + hub:
        raise SceneError(
            key="pair.center_distance_mm",
            expected=f"more than the cam's largest radius {reach:.4f} and the follower's hub "
            f"{hub:g} together",
            found=f"{center_distance_mm:g}",
        )
    hollow = float(motion.samples.curvature.min())
    if isinstance(head, Roller) and -hollow * head.radius_mm > LARGEST_ROLLER_RATIO:
        raise SceneError(
            key="body_1.roller_radius_mm",
            expected=f"less than the least concave radius of the cam, {-1 / hollow:.4f}",
            found=f"{head.radius_mm:g}",
        )
    return motion


def _refuse_where(
    wrong: NDArray[np.bool_],
    position: Floats,
    key: str,
    expected: str,
    found: Callable[[int], str],
) -> None:
    if wrong.any():
        k = int(np.argmax(wrong))
        raise SceneError(
            key=key,
            expected=expected,
            found=f"{found(k)} at a cam angle of {np.degrees(position[k]):.3f} deg",
        )


# --- zeros of functions on a closed profile, at many positions at once ----------------------------
def zeros_on(
    curve: FlankCurve,
    samples: ProfilePoints,
    shift: Floats,
    residual: Callable[[ProfilePoints], tuple[Floats, Floats]],
) -> tuple[NDArray[np.int64], Floats]:
    """Points of a closed curve at which a function changes its sign, at each of P positions.

    `samples` are all around the curve, the last one equals the first; `shift` (P, 2) is added to
    the points at each position. `residual` returns values (m,) at Places (m,), and their
    derivatives by arc length. Returns positions (k,) and arc lengths (k,), accurate to rounding.
    """
    count, n = len(shift), samples.s.size
    value, _ = residual(samples.repeated(count).shifted(np.repeat(shift, n, axis=0)))
    value = value.reshape(count, n)
    value[:, -1] = value[:, 0]
    position, i = np.nonzero((value[:, :-1] < 0) != (value[:, 1:] < 0))
    low, high, below = samples.s[i], samples.s[i + 1], value[position, i] < 0
    s = 0.5 * (low + high)
    for _ in range(MOST_STEPS):
        # Newton's method in an interval that encloses the zero, with bisection as the fallback
        found, slope = residual(profile_points(curve, s).shifted(shift[position]))
        left = (found < 0) == below
        low, high = np.where(left, s, low), np.where(left, high, s)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = s - found / slope
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        done = np.abs(new - s).max(initial=0.0) <= 1e-15 * curve.length_mm
        s = new
        if done:
            break
    return position, s


def first_contact(
    count: int, position: NDArray[np.int64], s: Floats, turn: Floats
) -> tuple[Floats, Floats]:
    """Arc length and angle at the least angle of each of `count` positions; NaN if none."""
    order = np.lexsort((turn, position))
    known, first = np.unique(position[order], return_index=True)
    found = np.full((2, count), np.nan)
    found[:, known] = s[order][first], turn[order][first]
    return found[0], found[1]


def wrapped(angle: Floats) -> Floats:
    """Angles in (-pi, pi]."""
    return np.asarray(np.pi - (np.pi - angle) % (2 * np.pi))


def polar(vectors: Floats, turn: Floats) -> Floats:
    """Polar angles in (-pi, pi] of vectors (m, 2) of a frame that is rotated by `turn`."""
    return wrapped(np.arctan2(vectors[:, 1], vectors[:, 0]) + turn)


def dot(a: Floats, b: Floats) -> Floats:
    """Scalar products (m,) of vectors (m, 2)."""
    return np.asarray((a * b).sum(axis=1))


def cross(a: Floats, b: Floats) -> Floats:
    """z components (m,) of the vector products of vectors (m, 2)."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
