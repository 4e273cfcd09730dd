"""Two crowned cylinders pressed together over slices, and Hertz's ellipse for them."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from flankload.bodies.axial_shape import PLANE_SHAPE
from flankload.contact.flank_contact import FlankContact, Level
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import AxialModes, BodyCompliance, FlankModes, NearField
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.slices import Slices
from flankload.scene.discretization import Grid
from tests.support.pressed_cylinders import arc, one_site

E, NU = 206000.0, 0.3
#: Strength of the logarithm of a half-space of steel, mm²/N.
KERNEL = 2.0 * (1.0 - NU**2) / (np.pi * E)
#: A turn of body 1 is a shift: circles about its axis are straight over the contact.
LEVER, DISTANCE = 1000.0, 2000.0
CELLS = Grid(10.0, 30.0)


def axial(
    low: float, high: float, *, twist: float = 0.0, end: tuple[float, float] = (0.0, 0.0)
) -> AxialModes:
    """A body with one mode along its axis."""
    return AxialModes((low, high), degree=0, twist=twist, cos_base_helix=1.0, end=end)


def cut(
    edges: np.ndarray, bodies: tuple[AxialModes, AxialModes], gap: np.ndarray | None = None
) -> Slices:
    """Slices of two bodies with a gap (J,) between them."""
    z = 0.5 * (edges[1:] + edges[:-1])
    none = np.zeros_like(z)
    removed = (none if gap is None else gap, none)
    turns = (bodies[0].twist * z, bodies[1].twist * z)
    return Slices(edges, turns, removed, line_load_mm=1.0)


@dataclass(frozen=True)
class Ellipse:
    """Largest pressure, MPa, approach and half-axes, mm, of an elliptic contact."""

    pressure: float
    approach: float
    small: float
    large: float


def hertz_ellipse(force: float, radius: float, crown_radius: float) -> Ellipse:
    """A cylinder on a plane, crowned along its axis (K. L. Johnson, Contact Mechanics, 4.26)."""
    stiff = 2.0 / (np.pi * 2.0 * KERNEL)
    ratio = crown_radius / radius

    def unmatched(k: float) -> float:
        first, second = ellipk(1.0 - k * k), ellipe(1.0 - k * k)
        return float((second / k**2 - first) / (first - second) - ratio)

    k = brentq(unmatched, 1e-4, 0.9999)
    first, second = ellipk(1.0 - k * k), ellipe(1.0 - k * k)
    of_pressure = 3.0 * force / (2.0 * np.pi * k * stiff)
    cube = of_pressure * k / (1.0 - k * k) * (first - second) * 2.0 * crown_radius
    large = float(np.cbrt(cube))
    small = k * large
    pressure = 3.0 * force / (2.0 * np.pi * small * large)
    return Ellipse(pressure, pressure / stiff * small * first, small, large)


def press(
    force: float,
    radius: float,
    edges: np.ndarray,
    gap: np.ndarray,
    *,
    level: Level = "lumped",
    grid: Grid = CELLS,
) -> Sweep:
    """A cylinder pressed on a flat by a force, with a gap over the slices."""
    one = arc((LEVER, -1e5), 1e5, np.pi / 2 + 4e-5, np.pi / 2 - 4e-5)
    two = arc((LEVER - DISTANCE, radius), radius, -np.pi / 2 + 0.4, -np.pi / 2 - 0.4)
    bodies = [
        SimpleNamespace(curve=c, teeth=1, active_range_mm=None, axial=PLANE_SHAPE)
        for c in (one, two)
    ]
    ends = axial(float(edges[0]), float(edges[-1]))
    modes = FlankModes((0.0, 1.0), axial=ends)
    half_space = BodyCompliance(np.zeros((1, 1, 1)), NearField(KERNEL), modes)
    (found,) = sweep(
        FlankContact(
            GearMesh((bodies[0], bodies[1]), one_site(DISTANCE), cut(edges, (ends, ends), gap)),
            (half_space, half_space),
            grid,
            level,
        ),
        np.zeros(1),
        [force * LEVER],
    )
    return found
