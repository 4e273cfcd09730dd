"""Rows of `flankload check` for a pulley and its belt."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.belt.belt import build_strip
from flankload.mechanisms.belt.belt_mesh import mesh_strip
from flankload.mechanisms.belt.drive import bodies_of, flank_elements, pulley_mesh
from flankload.meshes.report import quality_rows

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Rows
    from flankload.scene import Scene


def rows_of_belt(scene: Scene) -> dict[str, Rows]:
    """Name and value of each row, by title."""
    strip = build_strip(*bodies_of(scene))
    mesh = mesh_strip(strip, flank_elements(scene, strip))
    slack = scene.load.slack_tension_N or 0.0
    tight = np.array(scene.torques_Nmm) / strip.pitch_radius_mm + slack
    mean = 0.5 * (tight.max() + slack)
    said = f"{strip.prestress_N_per_mm * strip.width_mm:g} N (half of both tensions: {mean:.4g} N)"
    clearance = 1000.0 * strip.clearance_rad * strip.pitch_radius_mm
    effects = scene.effects
    return {
        "body_1: pulley": [
            ("teeth", f"{strip.pulley_teeth}"),
            ("pitch diameter", f"{2 * strip.pitch_radius_mm:.4f} mm"),
            ("outer diameter", f"{2 * strip.land_radius_mm:.4f} mm"),
            *_rows_of_pulley(scene),
        ],
        "body_2: belt": [
            ("teeth on the pulley", f"{strip.wrapped_teeth}"),
            ("wrap", f"{degrees(strip.wrapped_teeth * strip.pitch_rad):g} deg"),
            ("pitch difference", f"{1000 * strip.pitch_difference_mm:g} um"),
            ("clearance of flanks", f"{clearance:.4g} um"),
            ("prestress", said),
            ("elements", f"{len(mesh.cells[0][1])}"),
        ],
        "load": [
            ("slack tension", f"{slack:g} N"),
            ("tight tension", ", ".join(f"{value:.4g} N" for value in tight)),
        ],
        "effects": [
            ("friction on the lands", f"{effects.land_friction:g}"),
            ("lands may lift", "yes" if effects.land_lift else "no"),
        ],
    }


def _rows_of_pulley(scene: Scene) -> Rows:
    if scene.body_1.rigid:
        return [("mesh", "none: rigid")]
    mesh = pulley_mesh(scene)
    pulley, sector = mesh.pulley, mesh.sector
    return [
        ("bore diameter", f"{2 * pulley.bore_radius_mm:.4f} mm, fixed"),
        ("depth of the grooves", f"{pulley.depth_mm:.4f} mm"),
        ("Young's modulus", f"{pulley.material.young_modulus_MPa:g} MPa, plane {pulley.plane}"),
        ("mesh of a sector", f"{len(sector.nodes)} nodes, {len(sector.cells[0][1])} quad9"),
        *quality_rows(sector.nodes, sector.cells),
    ]
