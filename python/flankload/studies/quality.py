"""Deviations of flanks as normal distributions, by their tolerance class of ISO 1328-1."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from math import cos, pi, sin, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import SceneError
from flankload.scene.gear import Gear, Ring
from flankload.scene.iso_1328 import FlankTolerances, iso_1328
from flankload.scene.refusal import refuse
from flankload.scene.tree import number_at

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene import Scene


#: A tolerance is this many standard deviations: it holds for 99.7 % of the values.
DEVIATIONS = 3.0
#: Keys that a class describes.
KEYS = ("pitch_errors_um", "helix_slope_um", "tooth_helix_slope_um")


@dataclass(frozen=True)
class Quality:
    """Tolerance class of a body, until its distribution is known from a scene."""

    tolerance_class: Any


@dataclass(frozen=True, eq=False)
class JointNormal:
    """Normal distribution of a number or of the k entries of a list, as `is_list` says.

    The entries are `mean` (k,) + `factor` (k, m) u, with independent standard normal numbers u
    (m,): their covariance is factor factorᵀ.
    """

    mean: Floats
    factor: Floats
    is_list: bool

    @cached_property
    def numbers(self) -> int:
        """Number of uniform numbers that a draw needs."""
        return int(self.factor.shape[1])

    def quantiles(self, probabilities: Floats) -> list[Any]:
        """Values (n) at points (n, m) of the unit cube."""
        from scipy.special import ndtri

        # row by row: the bits of a draw do not depend on the number of draws
        found = [(self.mean + (self.factor * u).sum(axis=1)).tolist() for u in ndtri(probabilities)]
        return found if self.is_list else [one for (one,) in found]


def of_quality(scene: Scene, name: str, quality: Quality) -> JointNormal:
    """Distribution of a key by the tolerance class of its body; its mean is the value of the scene.

    The name is `body_1.` or `body_2.` and one of `KEYS`. Raises SceneError if the key has no
    tolerance, or the body is outside the ranges of the standard.
    """
    found = re.fullmatch(r"(body_[12])\.(\w+)", name)
    place = f"variables.{name}"
    if found is None or found[2] not in KEYS:
        keys = ", ".join(f"body_N.{key}" for key in KEYS)
        refuse(place, f"one of the paths {keys} for the distribution 'iso_1328'", f"'{name}'")
    body, key = getattr(scene, found[1]), found[2]
    if not isinstance(body, Gear | Ring):
        refuse(place, "a gear or a ring for the distribution 'iso_1328'", f"a {body.kind}")
    try:
        limits = iso_1328(
            quality.tolerance_class,
            teeth=body.teeth,
            module_mm=body.module_mm,
            face_width_mm=getattr(body, "face_width_mm", None) or scene.pair.face_width_mm,
            helix_angle_deg=getattr(body, "helix_angle_deg", 0.0),
        )
    except SceneError as error:
        refuse(f"{place}.{error.key}", error.expected, error.found)
    if key == "pitch_errors_um":
        transverse = pi * body.module_mm / cos(body.helix_rad)
        factor = pitch_factor(limits, body.teeth) * (body.base_pitch_mm / transverse)
    else:
        factor = np.eye(1 if key == "helix_slope_um" else body.teeth)
        factor *= limits.helix_slope_um / DEVIATIONS
    if key == "helix_slope_um":
        return JointNormal(np.array([number_at(scene, name)]), factor, is_list=False)
    return JointNormal(np.array(getattr(body, key) or np.zeros(body.teeth)), factor, is_list=True)


def pitch_factor(limits: FlankTolerances, teeth: int) -> Floats:
    """Index deviations (z, 2 + z) of z teeth in um per standard normal number.

    They lie along the arc of the reference circle. An eccentricity of normally distributed
    components, e_x and e_y, moves tooth i by e_x cos(2 pi i / z) + e_y sin(2 pi i / z); each tooth
    has an independent deviation in addition, and the mean of all teeth is 0. The standard
    deviations s_e of the components and s of the teeth follow from those of the index deviation and
    of the single pitch deviation, the difference of neighbouring teeth:

        s_e² + (1 - 1/z) s² = (F_pT / 6)²,    4 sin²(pi / z) s_e² + 2 s² = (f_pT / 3)².

    F_pT limits a range, that is index deviations to both sides of half its size. With few teeth
    the eccentricity alone reaches f_pT; then s = 0.
    """
    index = (0.5 * limits.total_pitch_um / DEVIATIONS) ** 2
    single = (limits.single_pitch_um / DEVIATIONS) ** 2
    chord, rest = 4.0 * sin(pi / teeth) ** 2, 1.0 - 1.0 / teeth
    of_teeth = max(0.0, (single - chord * index) / (2.0 - chord * rest))
    of_axis = (single - 2.0 * of_teeth) / chord
    angles = 2.0 * pi * np.arange(teeth) / teeth
    axis = sqrt(of_axis) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.hstack([axis, sqrt(of_teeth) * (np.eye(teeth) - 1.0 / teeth)])
