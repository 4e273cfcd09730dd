"""How much an effect changes: the states of the same positions and torques with it and without."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Forces of no load at all are divided by this.
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class States:
    """Curves of one torque at P positions on S sites."""

    torque_Nm: float
    sites: NDArray[np.int64]
    rotation_rad: Floats
    load_share: Floats

    @classmethod
    def of(
        cls, torque_Nm: float, sites: NDArray[np.int64], rotation_rad: Floats, site_force_N: Floats
    ) -> States:
        """From the forces of the sites (P, S)."""
        total = np.maximum(site_force_N.sum(axis=1, keepdims=True), TINY)
        return cls(torque_Nm, sites, rotation_rad, site_force_N / total)

    def at(self, which: slice) -> States:
        """At some of the positions."""
        share = self.load_share[which]
        return replace(self, rotation_rad=self.rotation_rad[which], load_share=share)

    def share_on(self, sites: NDArray[np.int64]) -> Floats:
        """Load share (P, n) of more sites."""
        share = np.zeros((len(self.load_share), sites.size))
        share[:, np.searchsorted(sites, self.sites)] = self.load_share
        return share


@dataclass(frozen=True)
class Size:
    """What an effect changes: with it less without it.

    Attributes
    ----------
    rotation_mean : float or None
        Of the rotation, mean over the positions, over the mean wind-up of the scene as it stands
        (its rotation less that without torque); None where nothing winds up.
    rotation_largest : float or None
        Largest amount at a position, over the wind-up there.
    rotation_um : float
        Largest amount, as transmission error.
    load_share : float
        Largest amount of a pair's share of the load.
    torque_Nm : float
        Torque at which it is so: of several the one at which it is largest.
    """

    rotation_mean: float | None
    rotation_largest: float | None
    rotation_um: float
    load_share: float
    torque_Nm: float

    @property
    def largest(self) -> float:
        """What is compared with the tolerance: of rotation and share the greater."""
        return max(self.rotation_largest or 0.0, self.load_share)

    def as_dict(self) -> dict[str, float | None]:
        """Its numbers by name."""
        return asdict(self)

    def times(self, part: float) -> Size:
        """A part of it."""
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
    """Size of an effect, at the torque at which it is largest."""
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
    )
