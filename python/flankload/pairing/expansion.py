"""How bodies grow before they touch: by heat, and by the speed with which they turn.

A temperature rise dT stretches a body by e = alpha dT in all directions; what holds it (the shaft
in its bore, the housing around a ring) stretches by e_s in its plane and takes the held surface
along. Both may grow along the axis as they like. Where e_s = e the body grows as a whole and no
stress is left: its flanks stand on a figure larger by 1 + e. What e_s differs by, and the pull of
rotation, are loads of the finite elements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.bodies.body import Body
    from flankload.pairing.pairing import Pairing
    from flankload.scene import Scene

#: Of steel, where a scene names no other.
EXPANSION_PER_K = 11.5e-6
DENSITY_KG_M3 = 7850.0
#: kg/m³ in N s²/mm⁴.
KG_M3 = 1e-12


@dataclass(frozen=True)
class Growth:
    """What makes a body grow.

    Attributes
    ----------
    strain : float
        alpha dT of the body.
    held_strain : float
        The same of what holds it.
    speed_rad_per_s : float
    density_Ns2_per_mm4 : float
    """

    strain: float = 0.0
    held_strain: float = 0.0
    speed_rad_per_s: float = 0.0
    density_Ns2_per_mm4: float = 0.0

    @property
    def needs_elements(self) -> bool:
        """Whether it is more than growth as a whole."""
        return self.load_cases > 0

    @property
    def load_cases(self) -> int:
        """One for each cause that is more than growth as a whole."""
        return (self.strain != self.held_strain) + (self.speed_rad_per_s > 0.0)


def growth_of(scene: Scene, pairing: Pairing) -> tuple[Growth | None, Growth | None]:
    """What makes the bodies of a scene grow.

    Parameters
    ----------
    scene : Scene
    pairing : Pairing
        Body 2 turns faster or slower by its ratio.

    Returns
    -------
    two Growth or None
        None for a body that does not grow. A rigid body grows by its own temperature alone.
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
    """A number for each body."""
    if isinstance(asked, tuple):
        return asked[0], asked[1]
    return (default if asked is None else asked,) * 2


def growth_notes(scene: Scene) -> tuple[str, ...]:
    """What a rigid body leaves out of its growth."""
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
    """The body, larger by 1 + strain: its curve and the range of its modes.

    Parameters
    ----------
    body : Body
    strain : float

    Returns
    -------
    Body
        Mesh, radii and notes stay those of the body as it was made.
    """
    if strain == 0.0:
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
    )
