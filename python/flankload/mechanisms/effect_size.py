"""Size of an effect: difference between states with it and without it at the same positions."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers

#: Least divisor of forces, for states without any load.
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class States:
    """Curves of one torque at P positions on S sites; K_Hbeta, which the plane does not have."""

    torque_Nm: float
    sites: Numbers
    rotation_rad: Floats
    load_share: Floats
    face_load_factor: float | None = None

    @classmethod
    def of(
        cls,
        torque_Nm: float,
        sites: Numbers,
        rotation_rad: Floats,
        site_force_N: Floats,
        face_load_factor: float | None = None,
    ) -> States:
        """States from the forces of the sites (P, S)."""
        total = np.maximum(site_force_N.sum(axis=1, keepdims=True), TINY)
        return cls(torque_Nm, sites, rotation_rad, site_force_N / total, face_load_factor)

    def share_on(self, sites: Numbers) -> Floats:
        """Load share (P, n) on a larger set of sites."""
        share = np.zeros((len(self.load_share), sites.size))
        share[:, np.searchsorted(sites, self.sites)] = self.load_share
        return share


@dataclass(frozen=True)
class Size:
    """Size of an effect: results with the effect minus results without it.

    Attributes
    ----------
    rotation_mean : float or None
        Mean change of the rotation over the positions, divided by the mean wind-up of the unchanged
        scene (its rotation minus the rotation without torque); None if the bodies do not wind up.
    rotation_largest : float or None
        Largest absolute change of the rotation at a position, divided by the wind-up there.
    rotation_um : float
        Largest absolute change of the rotation, as transmission error.
    load_share : float
        Largest absolute change of the load share of a pair.
    torque_Nm : float
        Torque to which the numbers belong: the one at which the effect is largest.
    face_load_factor : float or None
        Change of K_Hbeta, which is 1 in the plane; None if neither side is three-dimensional.
    """

    rotation_mean: float | None
    rotation_largest: float | None
    rotation_um: float
    load_share: float
    torque_Nm: float
    face_load_factor: float | None = None

    @property
    def largest(self) -> float:
        """The larger one of rotation and load share, which is compared with the tolerance."""
        return max(self.rotation_largest or 0.0, self.load_share)

    def as_dict(self) -> dict[str, float | None]:
        """Numbers by name."""
        return asdict(self)

    def times(self, part: float) -> Size:
        """The size multiplied by a factor."""
        mean, largest = self.rotation_mean, self.rotation_largest
        return replace(
            self,
            rotation_mean=None if mean is None else part * mean,
            rotation_largest=None if largest is None else part * largest,
            rotation_um=part * self.rotation_um,
            load_share=part * self.load_share,
        )


def size_of(
    with_it: Sequence[States],
    without: Sequence[States],
    *,
    base: Sequence[States],
    unloaded_rad: Floats,
    reference_radius_mm: float,
) -> Size:
    """Size of an effect at the torque at which it is largest.

    States are one for each torque, at the same positions; `base` is the unchanged scene,
    `unloaded_rad` (P,) its rotation without torque.
    """
    sizes = [
        _size(one, other, scene.rotation_rad - unloaded_rad, reference_radius_mm)
        for one, other, scene in zip(with_it, without, base, strict=True)
    ]
    return max(sizes, key=lambda size: (size.largest, size.rotation_um))


def _size(one: States, other: States, wind_up_rad: Floats, reference_radius_mm: float) -> Size:
    change = one.rotation_rad - other.rotation_rad
    winds_up = one.torque_Nm > 0 and float(wind_up_rad.min()) > 0
    sites = np.union1d(one.sites, other.sites)
    share = one.share_on(sites) - other.share_on(sites)
    return Size(
        rotation_mean=float(change.mean() / wind_up_rad.mean()) if winds_up else None,
        rotation_largest=float(np.abs(change / wind_up_rad).max()) if winds_up else None,
        rotation_um=1000.0 * reference_radius_mm * float(np.abs(change).max()),
        load_share=float(np.abs(share).max()),
        torque_Nm=one.torque_Nm,
        face_load_factor=_less(one.face_load_factor, other.face_load_factor),
    )


def _less(one: float | None, other: float | None) -> float | None:
    """Difference of two face load factors."""
    if one is None and other is None:
        return None
    return (1.0 if one is None else one) - (1.0 if other is None else other)
