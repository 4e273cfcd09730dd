"""Thermal and centrifugal expansion of the bodies.

A temperature rise dT expands a body by the strain e = alpha dT in all directions. The support that
holds it (the shaft in its bore, the housing around a ring) expands by e_s in its plane together
with the fixed surface; axial expansion is free. If e_s = e, the body expands uniformly without
stress: its flanks are scaled by 1 + e. The difference e_s - e and the centrifugal force are loads
on the finite elements. In three dimensions a helix of another length remains: its section turns by
1/(1 + e) as much per length, about the middle of the face width.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.bodies.axial_shape import AxialShape
    from flankload.bodies.body import Body
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.scene import Scene

#: Values of steel, used if a scene gives none.
EXPANSION_PER_K = 11.5e-6
DENSITY_KG_M3 = 7850.0
#: kg/m³ in N s²/mm⁴.
KG_M3 = 1e-12


@dataclass(frozen=True)
class Growth:
    """Causes of the expansion of a body: speed, density, strains alpha dT of body and support."""

    strain: float = 0.0
    held_strain: float = 0.0
    speed_rad_per_s: float = 0.0
    density_Ns2_per_mm4: float = 0.0

    @property
    def needs_elements(self) -> bool:
        """Whether it is more than a uniform expansion."""
        return self.load_cases > 0

    @property
    def load_cases(self) -> int:
        """Number of load cases: one for each cause beyond a uniform expansion."""
        return (self.strain != self.held_strain) + (self.speed_rad_per_s > 0.0)


def growth_of(scene: Scene, pairing: Pairing) -> tuple[Growth | None, Growth | None]:
    """Causes of the expansion of both bodies of a scene; None for a body that does not expand.

    A rigid body only expands by its own temperature. Body 2 turns faster or slower by the ratio.
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
        growth = Growth(
            strain=strain,
            held_strain=strain if body.rigid else held * rises[z],
            speed_rad_per_s=0.0 if body.rigid else speeds[z],
            density_Ns2_per_mm4=KG_M3 * densities[z],
        )
        grows = growth.needs_elements or growth.strain != 0.0
        found.append(growth if grows else None)
    return found[0], found[1]


def _of_both(asked: float | tuple[float, ...] | None, default: float) -> tuple[float, float]:
    """One number per body."""
    if isinstance(asked, tuple):
        return asked[0], asked[1]
    return (default if asked is None else asked,) * 2


def growth_notes(scene: Scene) -> tuple[str, ...]:
    """Notes on what the expansion of a rigid body does not include."""
    asked = scene.effects
    left_out = [
        (asked.speed_rpm, "its speed does not stretch it"),
        (asked.support_expansion_per_K, "it grows by its own expansion, whatever holds it"),
    ]
    return tuple(
        f"{key}: rigid, so {what}"
        for key, body in (("body_1", scene.body_1), ("body_2", scene.body_2))
        for value, what in left_out
        if body.rigid and value is not None
    )


def grown(body: Body, strain: float) -> Body:
    """The body scaled by 1 + strain: its curve and the range of its modes.

    Mesh, radii and notes are those of the unscaled body.
    """
    if strain == 0.0:
        return body
    curve, larger, axial = body.curve, 1.0 + strain, body.axial
    if axial is not None:
        axial = replace(axial, twist_rad_per_mm=axial.twist_rad_per_mm / larger)
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
        axial=axial,
    )


def grown_slices(
    slices: Slices, shapes: tuple[AxialShape, AxialShape], strains: tuple[float, float]
) -> Slices:
    """Slices of bodies whose helices have grown along the axis; the face widths remain.

    Slices and shapes are those of the bodies before.
    """
    one, two = (
        turns
        - shape.twist_rad_per_mm * (slices.z_mm - np.mean(shape.range_mm)) * strain / (1.0 + strain)
        for turns, shape, strain in zip(slices.turns_rad, shapes, strains, strict=True)
    )
    return replace(slices, turns_rad=(one, two))
