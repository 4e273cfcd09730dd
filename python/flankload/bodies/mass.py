"""Mass and moment of inertia of a body with equal teeth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.bodies.body import Body

#: kg/m3 over kg/mm3, and kg m2 over kg mm2.
OF_MM3, OF_MM2 = 1e-9, 1e-6


def mass_of(body: Body, density_kg_m3: float, width_mm: float) -> tuple[float, float]:
    """Mass, kg, and moment of inertia about the axis, kg m2.

    Between the toothed contour and the circle of the bore, or of the outside of a ring.
    """
    first, second = body.outline[:-1], body.outline[1:]
    # triangles with a corner on the axis
    twice = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    squares = (first**2 + first * second + second**2).sum(axis=1)
    circle = body.bore_radius_mm
    area = body.teeth * twice.sum() / 2.0 - np.pi * circle**2
    polar = body.teeth * (twice * squares).sum() / 12.0 - 0.5 * np.pi * circle**4
    mass = density_kg_m3 * OF_MM3 * width_mm
    return float(mass * abs(area)), float(mass * OF_MM2 * abs(polar))
