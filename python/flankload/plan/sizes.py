"""How much an effect changes: two sweeps of the same positions and torques, with it and without."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

#: A pair that carries less of the load is not looked at where it is open on the other side.
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class States:
    """What a size is taken from: curves of one torque at P positions on S sites.

    Attributes
    ----------
    torque_Nm : float
    sites : (S,) array
        Pair numbers.
    rotation_rad : (P,) array
    load_share : (P, S) array
        Force over the sum of the forces at a position.
    """

    torque_Nm: float
    sites: NDArray[np.int64]
    rotation_rad: NDArray[np.float64]
    load_share: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        torque_Nm: float,
        sites: NDArray[np.int64],
        rotation_rad: NDArray[np.float64],
        site_force_N: NDArray[np.float64],
    ) -> States:
        """From the forces of the sites (P, S)."""
        total = np.maximum(site_force_N.sum(axis=1, keepdims=True), TINY)
        return cls(torque_Nm, sites, rotation_rad, site_force_N / total)


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
        """What is held against the tolerance: of rotation and share the greater."""
        return max(self.rotation_largest or 0.0, self.load_share)

    def as_dict(self) -> dict[str, float | None]:
        """Its numbers by name."""
        return asdict(self)


def size_of(
    with_it: Sequence[States],
    without: Sequence[States],
    *,
    base: Sequence[States],
    unloaded_rad: NDArray[np.float64],
    reference_radius_mm: float,
) -> Size:
    """Size of an effect, at the torque at which it is largest.

    Parameters
    ----------
    with_it, without, base : sequences of States
        One for each torque, at the same positions; the scene as it stands is `base`.
    unloaded_rad : (P,) array
        Rotation of the scene as it stands without torque.
    reference_radius_mm : float

    Returns
    -------
    Size
    """
    sizes = [
        _size(one, other, scene.rotation_rad - unloaded_rad, reference_radius_mm)
        for one, other, scene in zip(with_it, without, base, strict=True)
    ]
    return max(sizes, key=lambda size: (size.largest, size.rotation_um))


def scaled(size: Size, part: float) -> Size:
    """A part of a size."""
    mean, largest = size.rotation_mean, size.rotation_largest
    return replace(
        size,
        rotation_mean=None if mean is None else part * mean,
        rotation_largest=None if largest is None else part * largest,
        rotation_um=part * size.rotation_um,
        load_share=part * size.load_share,
    )


def _size(
    one: States, other: States, wind_up_rad: NDArray[np.float64], reference_radius_mm: float
) -> Size:
    change = one.rotation_rad - other.rotation_rad
    winds_up = one.torque_Nm > 0 and float(wind_up_rad.min()) > 0
    sites = np.union1d(one.sites, other.sites)
    share = _on(sites, one) - _on(sites, other)
    return Size(
        rotation_mean=float(change.mean() / wind_up_rad.mean()) if winds_up else None,
        rotation_largest=float(np.abs(change / wind_up_rad).max()) if winds_up else None,
        rotation_um=1000.0 * reference_radius_mm * float(np.abs(change).max()),
        load_share=float(np.abs(share).max()),
        torque_Nm=one.torque_Nm,
    )


def _on(sites: NDArray[np.int64], states: States) -> NDArray[np.float64]:
    """Shares (P, S) on these sites."""
    share = np.zeros((len(states.load_share), sites.size))
    share[:, np.searchsorted(sites, states.sites)] = states.load_share
    return share
