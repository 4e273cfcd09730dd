"""Natural frequencies of a planetary stage: rigid bodies between the stiffnesses of its contacts.

Degrees of freedom are the displacements x, y (mm) and the rotation (rad, counter-clockwise) of each
body in the frame of the carrier: the sun, the planets, the ring, then the carrier. The stiffness is
constant, the mean over a tooth pitch; gyroscopic forces are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from flankload.base.rotation import directions
from flankload.base.text_table import text_table

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats

#: N s2/mm per kg, and N mm s2 per kg m2.
OF_MASS, OF_INERTIA = 1e-3, 1e3
#: Eigenvalues below this part of the largest one are 0: the rounding errors of differences.
VANISHES = 1e-9
#: Least share of its kind in the kinetic energy of a mode that other orders do not excite.
PURE = 0.99

#: Relative difference of equal frequencies: that of a stiffness by differences.
EQUAL = 1e-5
#: Largest order of the mesh frequency that is considered.
HIGHEST_ORDER = 24
#: Bodies in the energies of a mode.
MEMBERS = ("sun", "planets", "ring", "carrier")
BODIES = ("sun", "a planet", "ring", "carrier")

Kind = Literal["rotational", "translational", "planet"]
KINDS: tuple[Kind, ...] = ("rotational", "translational", "planet")


class Inertia(NamedTuple):
    """Mass, kg, and moment of inertia about the axis, kg m2."""

    mass_kg: float
    moment_kg_m2: float


class Support(NamedTuple):
    """Stiffness against displacement, N/mm, and rotation, N mm/rad; 0: free, inf: held."""

    radial: float = inf
    rotation: float = inf


@dataclass(frozen=True, eq=False)
class Mode:
    """A natural mode of a stage.

    Attributes
    ----------
    frequency_Hz : float
        0 of a motion without resistance.
    kind : str
        "rotational": all planets move alike, sun, ring and carrier turn; "translational": these
        move in the plane; "planet": only planets move.
    share : float
        Part of the kinetic energy in motions of this kind: 1 if the planets are equal and equally
        spaced.
    energy : (4,) array
        Parts of the kinetic energy in the sun, the planets, the ring and the carrier.
    shape : (3 n + 9,) array
        Displacements, mm, and rotations, rad, with the generalised mass 1 N s2/mm.
    """

    frequency_Hz: float
    kind: Kind
    share: float
    energy: Floats
    shape: Floats

    def orders(self, sun_teeth: int, highest: int) -> tuple[int, ...]:
        """Orders of the mesh frequency that excite the mode, up to a highest.

        With n equal planets, order l excites planet j with the phase 2 pi j l z_s/n: rotational
        modes if l z_s is a multiple of n, translational ones if it is one more or less, planet
        modes otherwise. A mode of mixed kind is excited by all orders.
        """
        n = (self.shape.size - 9) // 3
        every = range(1, highest + 1)
        if self.share < PURE:
            return tuple(every)
        return tuple(order for order in every if _kind_of(order * sun_teeth % n, n) == self.kind)


@dataclass(frozen=True, eq=False)
class StageSystem:
    """Bodies and stiffnesses of a stage of n planets.

    Attributes
    ----------
    angles_rad : (n,) array
        Polar angles of the planets.
    center_distance_mm : float
    contacts : (3 n + 6, 3 n + 6) array
        Stiffness of the contacts between sun, planets and ring, N/mm, N/rad, N mm/rad.
    pins_N_per_mm : (float, float) or None
        Radial and tangential stiffness of a pin; None if it is rigid.
    inertias : four Inertia
        Inertias of the sun, a planet, the ring and the carrier.
    supports : three Support
        Supports of sun, ring and carrier.
    """

    angles_rad: Floats
    center_distance_mm: float
    contacts: Floats
    pins_N_per_mm: tuple[float, float] | None
    inertias: tuple[Inertia, Inertia, Inertia, Inertia]
    supports: tuple[Support, Support, Support]

    @property
    def count(self) -> int:
        """Number of planets."""
        return self.angles_rad.size

    def modes(self) -> tuple[Mode, ...]:
        """All modes, by ascending frequency."""
        motions, stiffness, masses = self._motions(), self._stiffness(), self._masses()
        lower = np.linalg.cholesky(motions.T @ (masses[:, None] * motions))
        half = np.linalg.solve(lower, motions.T @ stiffness @ motions)
        values, vectors = np.linalg.eigh(np.linalg.solve(lower, half.T))
        values = np.where(values > VANISHES * values[-1], values, 0.0)
        shapes = motions @ np.linalg.solve(lower.T, vectors)
        frequencies = np.sqrt(values) / (2.0 * np.pi)
        return tuple(
            self._mode(float(frequency), shape, masses)
            for frequency, shape in zip(frequencies, shapes.T, strict=True)
        )

    def _pin_rows(self) -> Floats:
        """(n, 2, 3 n + 9) Displacement of each planet from its pin, radial and tangential."""
        n = self.count
        rows = np.zeros((n, 2, 3 * n + 9))
        for j, angle in enumerate(self.angles_rad):
            axes = directions(np.array([angle, angle + 0.5 * np.pi]))
            rows[j, :, 3 + 3 * j : 5 + 3 * j] = axes
            rows[j, :, -3:-1] = -axes
            rows[j, 1, -1] = -self.center_distance_mm
        return rows

    def _motions(self) -> Floats:
        """(3 n + 9, q) Columns of the possible motions."""
        n = self.count
        every = np.eye(3 * n + 9)
        central = {0: self.supports[0], 1 + n: self.supports[1], 2 + n: self.supports[2]}
        held = [
            3 * body + k
            for body, support in central.items()
            for k, stiffness in enumerate((support.radial, support.radial, support.rotation))
            if not isfinite(stiffness)
        ]
        if self.pins_N_per_mm is None:
            for j, angle in enumerate(self.angles_rad):
                across = directions(np.array([angle + 0.5 * np.pi]))[0]
                every[3 + 3 * j : 5 + 3 * j, -3:-1] = np.eye(2)
                every[3 + 3 * j : 5 + 3 * j, -1] = self.center_distance_mm * across
                held += [3 + 3 * j, 4 + 3 * j]
        return np.delete(every, held, axis=1)

    def _stiffness(self) -> Floats:
        """Stiffness of contacts, pins and supports."""
        n = self.count
        found = np.zeros((3 * n + 9, 3 * n + 9))
        found[: 3 * n + 6, : 3 * n + 6] = 0.5 * (self.contacts + self.contacts.T)
        if self.pins_N_per_mm is not None:
            rows = self._pin_rows()
            found += np.einsum("jka,k,jkb->ab", rows, self.pins_N_per_mm, rows)
        for body, support in zip((0, 1 + n, 2 + n), self.supports, strict=True):
            values = np.array([support.radial, support.radial, support.rotation])
            own = 3 * body + np.arange(3)
            found[own, own] += np.where(np.isfinite(values), values, 0.0)
        return found

    def _masses(self) -> Floats:
        """(3 n + 9,) Masses and moments of inertia."""
        sun, planet, ring, carrier = (
            np.array([OF_MASS * mass, OF_MASS * mass, OF_INERTIA * moment])
            for mass, moment in self.inertias
        )
        return np.concatenate([sun, np.tile(planet, self.count), ring, carrier])

    def _mode(self, frequency_Hz: float, shape: Floats, masses: Floats) -> Mode:
        """A mode with its kind."""
        n = self.count
        energy = masses * shape**2
        bodies = energy.reshape(n + 3, 3)
        kinds = dict.fromkeys(KINDS, 0.0)
        for central in (0, n + 1, n + 2):
            kinds["translational"] += float(bodies[central, :2].sum())
            kinds["rotational"] += float(bodies[central, 2])
        planets = shape.reshape(n + 3, 3)[1 : n + 1]
        axes = np.stack([directions(self.angles_rad + at) for at in (0.0, 0.5 * np.pi)], axis=1)
        polar = np.column_stack([np.einsum("jkx,jx->jk", axes, planets[:, :2]), planets[:, 2]])
        parts = np.abs(np.fft.fft(polar, axis=0)) ** 2 / n @ masses[3:6]
        for k, part in enumerate(parts):
            kinds[_kind_of(k, n)] += float(part)
        total = sum(kinds.values())
        kind = max(KINDS, key=lambda one: kinds[one])
        share = np.add.reduceat(bodies.sum(axis=1), [0, 1, n + 1, n + 2]) / total
        return Mode(frequency_Hz, kind, kinds[kind] / total, share, shape)


def _kind_of(k: int, count: int) -> Kind:
    """Kind of the motions in which planet j follows planet 0 by the angle 2 pi j k/count."""
    if k == 0:
        return "rotational"
    return "translational" if k in (1, count - 1) else "planet"


@dataclass(frozen=True, eq=False)
class StageModes:
    """Modes of a stage about its state under a torque.

    Attributes
    ----------
    torque_Nm : float
    sun_teeth : int
    inertias : four Inertia
        Inertias of the sun, a planet, the ring and the carrier.
    modes : tuple of Mode
        By ascending frequency.
    """

    torque_Nm: float
    sun_teeth: int
    inertias: tuple[Inertia, Inertia, Inertia, Inertia]
    modes: tuple[Mode, ...]

    @property
    def frequencies_Hz(self) -> Floats:
        """(q,) Natural frequencies, ascending."""
        return np.array([mode.frequency_Hz for mode in self.modes])

    def speed_rpm(self, mode: Mode, order: int) -> float:
        """Speed of the sun relative to the carrier at which an order has a mode's frequency."""
        return 60.0 * mode.frequency_Hz / (order * self.sun_teeth)

    def inertia_rows(self) -> list[tuple[str, str]]:
        """Mass and moment of inertia of each body that moves."""
        return [
            (name, f"{mass:.4g} kg, {moment:.4g} kg m2")
            for name, (mass, moment), moves in zip(BODIES, self.inertias, self._moving, strict=True)
            if moves
        ]

    def rows(self) -> list[str]:
        """A row for each frequency: kind, parts of the energy, orders that excite it."""
        moving = self._moving
        heads = [name for name, moves in zip(MEMBERS, moving, strict=True) if moves]
        table = [["frequency", "kind", *heads, "sun at its first order", "excited by orders"]]
        table += [["Hz", "", *["energy %"] * len(heads), "rpm", ""]]
        for mode, times in self._joined():
            orders = mode.orders(self.sun_teeth, HIGHEST_ORDER)
            name = mode.kind if mode.share >= PURE else f"{mode.kind} ({100 * mode.share:.0f} %)"
            more = f" x{times}" if times > 1 else ""
            speed = f"{self.speed_rpm(mode, orders[0]):.0f}" if orders else "-"
            parts = [f"{100 * part:.1f}" for part in mode.energy[moving]]
            some = ", ".join(map(str, orders[:4])) + ", ..." if orders else "none"
            table.append([f"{mode.frequency_Hz:.1f}", name + more, *parts, speed, some])
        return text_table(table)

    @property
    def _moving(self) -> Flags:
        """(4,) Whether the sun, the planets, the ring and the carrier move in any mode."""
        return np.max([mode.energy for mode in self.modes], axis=0) > 0.0

    def _joined(self) -> list[tuple[Mode, int]]:
        """Modes of one kind and one frequency as one, with their number."""
        found: list[tuple[Mode, int]] = []
        for mode in self.modes:
            last, times = found[-1] if found else (None, 0)
            apart = inf if last is None else mode.frequency_Hz - last.frequency_Hz
            if last is not None and last.kind == mode.kind and apart <= EQUAL * mode.frequency_Hz:
                found[-1] = last, times + 1
            else:
                found.append((mode, 1))
        return found
