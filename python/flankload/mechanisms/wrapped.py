"""Common parts of belts and chains, which are wrapped around a wheel with teeth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.mechanisms.effect_size import States as EffectStates
from flankload.mechanisms.premises import Torque, broken_by_turn, largest_turn

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from flankload.mechanisms.premises import Broken
    from flankload.scene import Scene

    Floats = NDArray[np.float64]


def positions_of(scene: Scene, pitch_rad: float) -> tuple[Floats, int | None]:
    """(P,) Angles of the wheel, and the number of pitches they cover; None for single angles."""
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float)), None
    pitches = 1 if wanted.pitches == "hunting" else int(wanted.pitches)
    return pitch_rad * np.arange(wanted.count * pitches) / wanted.count, pitches


class Sites:
    """Teeth or rollers on the wheel at P positions, with common numbers.

    Parameters
    ----------
    first, count : sequences of P int
        Number of the first one, and how many there are, at each position.

    Attributes
    ----------
    numbers : (S,) array
    """

    def __init__(self, first: Sequence[int], count: Sequence[int]) -> None:
        self._first = np.asarray(first)
        self.numbers = np.arange(self._first.min(), (self._first + count).max())

    def spread(self, values: Sequence[Floats], nothing: float = np.nan) -> Floats:
        """(P, S) Values of each position, from its first site on; `nothing` elsewhere."""
        found = np.full((len(values), self.numbers.size), nothing)
        for row, first, own in zip(found, self._first - self.numbers[0], values, strict=True):
            part = row[first : first + own.size]
            part[:] = own[: part.size]
        return found

    def effect_states(
        self, torque_Nm: float, rotation_rad: Sequence[float], force_N: Sequence[Floats]
    ) -> EffectStates:
        """States under a torque, for the size of an effect."""
        force = self.spread(force_N, nothing=0.0)
        return EffectStates.of(torque_Nm, self.numbers, np.array(rotation_rad), force)


class WrappedMechanism(ABC):
    """Stages that are the same for belts and chains."""

    @abstractmethod
    def stiffness(self, assembly: Any, states: Sequence[Any]) -> Floats:
        """(P,) Tangent stiffness at the positions, N m/rad; NaN if nothing rotates."""

    def sweeps(self, scene: Scene) -> int:
        """Number of sweeps: all positions, and the few positions of the estimate."""
        return 1

    def broken_by_geometry(self, assembly: Any) -> Iterator[Broken]:
        """None: the geometry violates no premise."""
        yield from ()

    def broken_by_load(
        self, scene: Scene, assembly: Any, states: Any, number: int
    ) -> Iterator[Broken]:
        """Premises that a torque violates: small displacements."""
        stiffness = self.stiffness(assembly, states.found[number])
        with np.errstate(divide="ignore", invalid="ignore"):
            turned_rad = largest_turn(scene.torques_Nm[number] / stiffness)
        yield from broken_by_turn(turned_rad, assembly.pitch_rad, Torque(scene, number))
