"""Thermal and centrifugal expansion of the bodies.

A temperature rise dT expands a body by the strain e = alpha dT in all directions. Its support (the
shaft in its bore, the housing around a ring) and the fixed surface expand by e_s in the plane;
axial expansion is free. If e_s = e, the body expands uniformly without stress, and its flanks are
scaled by 1 + e. The difference e_s - e and the centrifugal force are loads on the finite elements.
In three dimensions, the rotation of the section per length along the axis is divided by 1 + e,
about the middle of the face width, and the fixed surface moves along the axis as the body expands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from flankload.pairing.common_height import common_height

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.scene import Scene

#: Default values: steel.
EXPANSION_PER_K = 11.5e-6
DENSITY_KG_M3 = 7850.0
#: kg/m³ in N s²/mm⁴.
KG_M3 = 1e-12


@dataclass(frozen=True)
class BodyLoad:
    """Causes of the expansion of a body: strains alpha dT of body and support, speed, density."""

    strain: float = 0.0
    held_strain: float = 0.0
    speed_rad_per_s: float = 0.0
    density_Ns2_per_mm4: float = 0.0

    @property
    def needs_elements(self) -> bool:
        """Whether the expansion is not uniform."""
        return self.load_cases > 0

    @property
    def load_cases(self) -> int:
        """Number of load cases: one for each cause of non-uniform expansion."""
        return (self.strain != self.held_strain) + (self.speed_rad_per_s > 0.0)


def body_loads_of(scene: Scene, pairing: Pairing) -> tuple[BodyLoad | None, BodyLoad | None]:
    """Causes of the expansion of both bodies of a scene; None for a body that does not expand.

    A rigid body expands by its own temperature only. The speed of body 2 follows from the ratio.
    """
    asked = scene.effects
    rises = _of_both(asked.temperature_rise_K, 0.0)
    expansions = _of_both(asked.thermal_expansion_per_K, EXPANSION_PER_K)
    densities = _of_both(asked.density_kg_m3, DENSITY_KG_M3)
    speed = 2 * pi / 60 * (asked.speed_rpm or 0.0)
    speeds = (speed, speed * abs(pairing.ratio) if speed else 0.0)
    found = []
    for z, body in enumerate((scene.body_1, scene.body_2)):
        held = _of_both(asked.support_expansion_per_K, expansions[z])[z]
        strain = expansions[z] * rises[z]
        body_load = BodyLoad(
            strain=strain,
            held_strain=strain if body.rigid else held * rises[z],
            speed_rad_per_s=0.0 if body.rigid else speeds[z],
            density_Ns2_per_mm4=KG_M3 * densities[z],
        )
        grows = body_load.needs_elements or body_load.strain != 0.0
        found.append(body_load if grows else None)
    return found[0], found[1]


def _of_both(asked: float | tuple[float, ...] | None, default: float) -> tuple[float, float]:
    """One number per body."""
    if isinstance(asked, tuple):
        return asked[0], asked[1]
    return (default if asked is None else asked,) * 2


def body_load_notes(scene: Scene) -> tuple[str, ...]:
    """Notes on causes that do not expand rigid bodies."""
    asked = scene.effects
    left_out = [
        (asked.speed_rpm, "its speed does not stretch it"),
        (asked.support_expansion_per_K, "it expands freely, whatever supports it"),
    ]
    return tuple(
        f"{key}: rigid, so {what}"
        for key, body in (("body_1", scene.body_1), ("body_2", scene.body_2))
        for value, what in left_out
        if body.rigid and value is not None
    )


def expanded(body: Body, strain: float, axial_strain: float) -> Body:
    """The body with its curve and the range of its modes scaled by 1 + strain."""
    if strain == axial_strain == 0.0:
        return body
    curve, larger = body.curve, 1.0 + strain
    powers = larger ** (1.0 - np.arange(curve.coefficients.shape[2]))
    low, high = body.mode_range_mm
    active = body.active_range_mm
    return replace(
        body,
        active_range_mm=None if active is None else (larger * active[0], larger * active[1]),
        curve=replace(
            curve, breaks=larger * curve.breaks, coefficients=powers * curve.coefficients
        ),
        mode_range_mm=(larger * low, larger * high),
        axial=replace(
            body.axial,
            twist_rad_per_mm=body.axial.twist_rad_per_mm / (1.0 + axial_strain),
        ),
    )


def expanded_slices(
    slices: Slices, bodies: tuple[Body, Body], strains: tuple[float, float]
) -> Slices:
    """Slices after axial expansion of the helices of bodies of unchanged face widths."""
    one, two = (
        turns
        - shape.twist_rad_per_mm * (slices.z_mm - np.mean(shape.range_mm)) * strain / (1.0 + strain)
        for turns, shape, strain in zip(
            slices.turns_rad, (body.axial for body in bodies), strains, strict=True
        )
    )
    laid_on = slices.laid_on

    def expanded_on(edges_mm: Floats) -> Slices:
        assert laid_on is not None
        return expanded_slices(laid_on(edges_mm), bodies, strains)

    return replace(slices, turns_rad=(one, two), laid_on=laid_on and expanded_on)


def with_expanded_height(
    slices: Slices, bodies: tuple[Body, Body], strains: tuple[float, float]
) -> Slices:
    """Slices with the common height of conforming flanks of bodies that are `expanded`."""
    height = slices.conforming
    if height is None:
        return slices
    grown = common_height(
        *bodies, tilt=height.tilt, middle_z_mm=height.middle_z_mm, strains=strains
    )
    return replace(slices, conforming=grown)
