"""Structured sector mesh of a ring by inversion of the mesh of an external tooth.

The conformal map w = R²/z turns internal teeth into external ones and maps circles about the axis
to such circles. The mesh is made for the image of the flank, and its nodes are mapped back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import SectorMesh
from flankload.bodies.involute.sector_mesh import inverted_element, tooth_mesh
from flankload.errors import SceneError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from flankload.base.arrays import Floats
    from flankload.bodies.profile.tooth_profile import ToothProfile
    from flankload.flank import FlankCurve


@dataclass(frozen=True)
class InvertedCurve:
    """Image of a flank under w = R²/z, parametrised by the arc length of the original flank.

    Attributes
    ----------
    original : FlankCurve
        The flank, with its tooth centred on the +x axis.
    radius_mm : float
        Radius R of the inversion.
    """

    original: FlankCurve
    radius_mm: float

    @property
    def length_mm(self) -> float:
        """Arc length of the flank, mm."""
        return self.original.length_mm

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the intervals."""
        return self.original.labels

    def range_of(self, *labels: str) -> tuple[float, float]:
        """Range of arc length that contains all intervals with the labels."""
        return self.original.range_of(*labels)

    def point(self, s: ArrayLike) -> Floats:
        """Points (m, 2) at arc lengths s (m,), mm."""
        return inverted(self.original.point(s), self.radius_mm)

    def tangent(self, s: ArrayLike) -> Floats:
        """Unit tangents (m, 2) towards the tip at arc lengths s (m,)."""
        place, along = (_complex(v) for v in (self.original.point(s), self.original.tangent(s)))
        image = -along / place**2
        return _plane(image / np.abs(image))


@dataclass(frozen=True)
class InvertedTooth:
    """Image of a ring's tooth under the inversion; attributes as for `ToothProfile`."""

    curve: InvertedCurve
    teeth: int
    mode_range_mm: tuple[float, float]
    root_half_angle_rad: float
    root_radius_mm: float
    tip_radius_mm: float


def inverted(places: Floats, radius: float) -> Floats:
    """R²/z for points (m, 2) as complex numbers; the inversion is its own inverse."""
    return _plane(radius**2 / _complex(places))


def _complex(places: Floats) -> NDArray[np.complex128]:
    return np.asarray(places[:, 0] + 1j * places[:, 1])


def _plane(numbers: NDArray[np.complex128]) -> Floats:
    return np.stack([numbers.real, numbers.imag], axis=1)


def ring_mesh(
    profile: ToothProfile, outer_radius_mm: float, lengths_mm: tuple[float, float | None], key: str
) -> SectorMesh:
    """Mesh one sector of a ring, checked; lengths as in `tooth_mesh`."""
    half_pitch = pi / profile.teeth
    involute = profile.involute
    # with this radius, the inversion preserves lengths in the middle of the tooth
    radius = sqrt(involute.root_radius_mm * involute.tip_radius_mm)
    tooth = InvertedTooth(
        curve=InvertedCurve(profile.curve.rotated(-half_pitch), radius),
        teeth=profile.teeth,
        mode_range_mm=profile.mode_range_mm,
        root_half_angle_rad=half_pitch - profile.root_half_angle_rad,
        root_radius_mm=radius**2 / involute.root_radius_mm,
        tip_radius_mm=radius**2 / involute.tip_radius_mm,
    )
    image = tooth_mesh(tooth, radius**2 / outer_radius_mm, lengths_mm)
    mesh = replace(
        image,
        nodes=turned(inverted(image.nodes, radius), half_pitch),
        left_nodes=image.right_nodes,
        right_nodes=image.left_nodes,
    )
    place, found = inverted_element(mesh)
    if found:
        in_rim = place > involute.root_radius_mm
        raise SceneError(
            key=f"{key}.{'outer' if in_rim else 'tip'}_diameter_mm",
            expected="a tooth and rim that can be meshed in blocks",
            found=f"{found} (outside of the rim {2 * outer_radius_mm:g} mm)",
        )
    return mesh
