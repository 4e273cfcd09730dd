"""Quantities of a planetary stage: load sharing of its planets, forces, orbits, torques."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import gcd
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import InputError
from flankload.result.drives import Drive
from flankload.result.engagement import rows_of_positions
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flankload.base.arrays import Floats
    from flankload.result.planet_bending import PlanetBending
    from flankload.result.result import Result

#: Kinds of mesh of a planet, and the index of the first one.
MESHES = ("sun", "ring")
#: Largest deviation of equally spaced planets, rad: rounding errors.
EQUALLY_SPACED = 1e-9
#: Members that can float.
MEMBERS = ("sun", "ring", "carrier")
#: Smaller orbits than this part of the transmission error are rounding errors, which are not drawn.
LEAST_ORBIT = 1e-9
#: Largest order of the mesh frequency in the summary.
HIGHEST_ORDER = 12


def components(array: str, words: str) -> tuple[property, property]:
    """Components x and y of the last axis of an array; the words have their name."""

    def of(k: int, name: str) -> property:
        def read(loads: StageLoads) -> Floats:
            return np.asarray(getattr(loads, array)[..., k])

        read.__doc__ = words.format(name)
        return property(read)

    return of(0, "x"), of(1, "y")


@dataclass(frozen=True, eq=False, repr=False)
class StageLoads(Drive):
    """Loads of a planetary stage at P positions, n planets, in the frame of its carrier.

    Attributes
    ----------
    teeth : (int, int, int)
        Tooth numbers of sun, planet and ring.
    center_distance_mm : float
    planet_angles_rad : (n,) array
        Polar angles of the planets.
    phases : (2, n) array
        Phases of the meshes with the sun and with the ring at position zero, in pitches.
    order : int or None
        Only multiples of this order of the mesh frequency survive; None if planets differ.
    orbit_orders : tuple of int
        Orders of the orbit of the sun that survive; negative ones run clockwise.
    mesh_load_factor : (P,) array
        K_gamma: number of planets times the largest share.
    ring_torque_Nm, carrier_torque_Nm : (P,) arrays
        Torque of the planets on the ring, clockwise, and torque on the carrier, counter-clockwise.
    transmission_error_output_urad : (P,) array
        Rotation of the carrier behind its position without load, with the ring at rest, urad.
    sun_orbit_um, ring_orbit_um, carrier_orbit_um : (P, 2) arrays
        Displacements of sun, ring and carrier from the middle.
    ring_deflection_um : (P, z) array
        Radial displacement of the outside of the ring behind each of its z spaces, outwards, from
        the space that planet 1 meets at position zero on, counter-clockwise; of a ring that floats
        beyond its orbit, 0 of a clamped one; with a width its mean, along the helix.
    planet_force_N : (P, n, 2) array
        Force of the sun on each planet.
    pin_force_N : (P, n, 2) array
        Force of each planet on its pin.
    sun_mesh_sliding_loss_Nm, ring_mesh_sliding_loss_Nm : (P, n) arrays
        Loss by sliding of the mesh of each planet with the sun and with the ring, per rad of the
        sun relative to the carrier and per unit of the coefficient of friction: force times sliding
        speed, to first order.
    planet_bending : PlanetBending or None
        Root stress of the planets under the loads of both flanks, if requested.
    meshes : sequence of 2n Result
        Results of the meshes with the sun, then those with the ring.
    """

    teeth: tuple[int, ...]
    center_distance_mm: float
    planet_angles_rad: Floats
    phases: Floats
    order: int | None
    orbit_orders: tuple[int, ...]
    mesh_load_factor: Floats = field(metadata={"P": "1"})
    ring_torque_Nm: Floats = field(metadata={"P": "N m"})
    carrier_torque_Nm: Floats = field(metadata={"P": "N m"})
    transmission_error_output_urad: Floats = field(metadata={"P": "urad"})
    sun_orbit_um: Floats
    ring_orbit_um: Floats
    carrier_orbit_um: Floats
    ring_deflection_um: Floats
    planet_force_N: Floats
    pin_force_N: Floats
    sun_mesh_sliding_loss_Nm: Floats = field(metadata={"PS": "N m"})
    ring_mesh_sliding_loss_Nm: Floats = field(metadata={"PS": "N m"})
    planet_bending: PlanetBending | None
    meshes: Sequence[Result]

    name = "stage"
    key = "stage"
    words_for_sites = ("planet", "planets")
    over_torque = ("torque_sweep", "mesh_load_factor")
    has_pressures = True
    pairs_advance = False
    sites_stay = True
    site_word = "planet"
    drawn_bodies = None

    @classmethod
    def units(cls, axes: str) -> dict[str, str]:
        """Units of arrays: also of the components of orbits and forces."""
        more = {
            "P": dict.fromkeys((f"{body}_orbit_{k}_um" for body in MEMBERS for k in "xy"), "um"),
            "PS": dict.fromkeys(
                (f"{of}_force_{k}_N" for of in ("planet", "pin") for k in "xy"), "N"
            ),
        }
        return super().units(axes) | more[axes]

    sun_orbit_x_um, sun_orbit_y_um = components(
        "sun_orbit_um", "(P,) Displacement of the sun along {} in the frame of the carrier."
    )
    ring_orbit_x_um, ring_orbit_y_um = components(
        "ring_orbit_um", "(P,) Displacement of the ring along {} in the frame of the carrier."
    )
    carrier_orbit_x_um, carrier_orbit_y_um = components(
        "carrier_orbit_um", "(P,) Displacement of a floating carrier along {} in its frame at rest."
    )
    planet_force_x_N, planet_force_y_N = components(
        "planet_force_N",
        "(P, n) Force of the sun on each planet along {} in the frame of the carrier.",
    )
    pin_force_x_N, pin_force_y_N = components(
        "pin_force_N",
        "(P, n) Force of each planet on its pin along {} in the frame of the carrier.",
    )

    @property
    def count(self) -> int:
        """Number of planets."""
        return self.planet_angles_rad.size

    @property
    def marked_orders(self) -> range:
        """Orders that survive without errors, if planets are equally spaced and some vanish."""
        n = self.count
        places = self.planet_angles_rad - self.planet_angles_rad[0]
        order = n // gcd(n, self.teeth[0])
        if order == 1 or np.abs(n * places - 2 * np.pi * np.arange(n)).max() > EQUALLY_SPACED:
            return range(0)
        return range(order, HIGHEST_ORDER + 1, order)

    def mesh(self, planet: int, kind: str) -> Result:
        """Result of one mesh, planets from 1.

        Raises
        ------
        InputError
            If there is no such mesh.
        """
        if kind not in MESHES:
            raise InputError(f"kind: expected 'sun' or 'ring', found {kind!r}")
        if planet not in range(1, self.count + 1):
            raise InputError(f"planet: expected a number from 1 to {self.count}, found {planet!r}")
        return self.meshes[MESHES.index(kind) * self.count + planet - 1]

    def as_dict(self) -> dict[str, Any]:
        """The stage in the form of the JSON result."""
        found = super().as_dict()
        if self.planet_bending is not None:
            found["planet_bending"] = self.planet_bending.as_dict()
        return found

    def drawn_force(self, result: Result, p: int, s: int) -> tuple[float, float, float]:
        """Force of the sun on a planet, at their pitch point."""
        sun, planet, _ = self.teeth
        x, y = self.planet_force_N[p, s]
        pitch_mm = self.center_distance_mm * sun / (sun + planet)
        return float(self.planet_angles_rad[s]), pitch_mm, float(np.arctan2(y, x))

    def rows(self, result: Result) -> list[str]:
        """A row per position with the shares of all planets."""
        n = self.count
        sun = bool(self.sun_orbit_um.any())
        heads = ["K_gamma", *(f"planet {j + 1}" for j in range(n)), *["sun x", "sun y"] * sun]
        units = ["", *["share %"] * n, *["um", "um"] * sun]

        def cells(p: int) -> Iterable[str]:
            yield f"{self.mesh_load_factor[p]:.4f}"
            yield from (f"{100 * share:.2f}" for share in result.load_share[p])
            if sun:
                yield from (f"{value:.3f}" for value in self.sun_orbit_um[p])

        return rows_of_positions(result, heads, units, cells)

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        several = result.position_rad.size > 1
        names = ("transmission_error", "planet_load_share") * several
        least_um = LEAST_ORBIT * np.abs(result.transmission_error_um).max()
        orbit = ("sun_orbit",) * bool(several and np.abs(self.sun_orbit_um).max() > least_um)
        return ("planetary_stage", *names, *orbit)

    def summary(self, result: Result) -> dict[str, Any]:
        """Entries of the summary."""
        pin = np.hypot(*np.moveaxis(self.pin_force_N, -1, 0))
        orbit = np.hypot(*self.sun_orbit_um.T)
        over = over_positions(result)
        amplitudes = over.harmonics(
            result.transmission_error_um, every=result.period_pitches, count=HIGHEST_ORDER
        )
        survive = None
        if self.order is not None:
            survive = list(range(self.order, HIGHEST_ORDER + 1, self.order))
        return {
            "mesh_load_factor_max": float(self.mesh_load_factor.max()),
            "mesh_load_factor_mean": over.mean(self.mesh_load_factor),
            "pin_force_max_N": float(pin.max()),
            "sun_orbit_max_um": float(orbit.max()),
            "ring_deflection_max_um": float(np.abs(self.ring_deflection_um).max()),
            "ring_torque_mean_Nm": over.mean(self.ring_torque_Nm),
            "carrier_torque_mean_Nm": over.mean(self.carrier_torque_Nm),
            "sliding_loss_mean_Nm": over.mean(
                (self.sun_mesh_sliding_loss_Nm + self.ring_mesh_sliding_loss_Nm).sum(axis=1)
            ),
            "transmission_error_orders_um": amplitudes,
            "surviving_orders": survive,
            "surviving_orbit_orders": list(self.orbit_orders),
            **(
                {}
                if self.planet_bending is None
                else {"planet_root_stress": self.planet_bending.summary()}
            ),
        }

    def words(self) -> str:
        """Text of a report."""
        text = f"K_gamma {self.mesh_load_factor.max():.4f} at most, torque on the ring "
        text += f"{self.ring_torque_Nm.mean():.5g} N m, on the carrier "
        text += f"{self.carrier_torque_Nm.mean():.5g} N m"
        if self.order is not None:
            orders = (
                "all orders survive"
                if self.order == 1
                else (f"only multiples of order {self.order} survive in the transmission error")
            )
            text += f"; {orders}"
        if self.planet_bending is not None:
            text += f"; {self.planet_bending.words()}"
        return text
