"""Two cylinders pressed together, through the whole core."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np

from flankload.contact.flank_contact import FlankContact, Level
from flankload.contact.sweep import sweep
from flankload.elasticity.compliance import BodyCompliance, FlankModes, NearField
from flankload.flank import CurvePiece, FlankCurve, fit_flank_curve
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.pairing import Pairing, Period
from flankload.pairing.slices import plane_slice
from flankload.scene.discretization import Grid
from tests.support.paths import REFERENCE_SOLUTIONS

CASE = json.loads((REFERENCE_SOLUTIONS / "closed_form.json").read_text())["hertz_cylinders"]
RADIUS_1, RADIUS_2 = CASE["R1_mm"], CASE["R2_mm"]
LEVER, DISTANCE = 36.0, 90.0


def arc(centre: tuple[float, float], radius: float, start: float, end: float):
    """A circular flank; the material lies on the right of increasing arc length."""

    def place(u):
        direction = np.stack([np.cos(u), np.sin(u)], axis=-1)
        normal = np.stack([-np.sin(u), np.cos(u)], axis=-1)
        return np.asarray(centre) + radius * direction, radius * normal, -radius * direction

    return fit_flank_curve([CurvePiece("flank", place, start, end, False)])


def cylinders(one: FlankCurve, two: FlankCurve):
    """Bodies with one flank each."""
    return tuple(SimpleNamespace(curve=c, teeth=1, active_range_mm=None) for c in (one, two))


def one_site(center_distance_mm: float) -> Pairing:
    """One site on two bodies that turn at the same rate."""
    none = np.zeros(1)
    return Pairing(
        center_distance_mm=center_distance_mm,
        turns_at_zero_rad=(0.0, 0.0),
        ratio=1.0,
        period=Period(1.0),
        sites=np.zeros(1, int),
        site_teeth=(np.zeros(1, int), np.zeros(1, int)),
        site_angles_rad=(none, none),
        site_deviations_mm=(none, none),
        gear_geometry=None,
        warnings=(),
    )


def contact(force_N_per_mm: float, grid: Grid, level: Level = "pairs"):
    """Two half-plane cylinders pressed together at (LEVER, 0) along y."""
    # body 1 pushes up (+y) at (LEVER, 0); its centre is below. Clockwise on the top: t towards +x.
    one = arc((LEVER, -RADIUS_1), RADIUS_1, np.pi / 2 + 0.3, np.pi / 2 - 0.3)
    # body 2 in its own frame about O2 = (DISTANCE, 0): centre above, its tip side towards O1.
    two = arc((LEVER - DISTANCE, RADIUS_2), RADIUS_2, -np.pi / 2 + 0.2, -np.pi / 2 - 0.2)
    kernel = 2 * (1 - CASE["poisson_ratio"] ** 2) / (np.pi * CASE["young_modulus_MPa"])
    half_plane = BodyCompliance(np.zeros((1, 1, 1)), NearField(kernel), FlankModes((0.0, 1.0)))
    (found,) = sweep(
        FlankContact(
            GearMesh(cylinders(one, two), one_site(DISTANCE), plane_slice(1.0)),
            (half_plane, half_plane),
            grid,
            level,
        ),
        np.zeros(1),
        [force_N_per_mm * LEVER],
    )
    return found
