"""Rows of `flankload check` for a sprocket and its chain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.chain.drive import build_drive

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Rows
    from flankload.scene import Scene


def rows_of_chain(scene: Scene) -> dict[str, Rows]:
    """Name and value of each row, by title."""
    sprocket, chain, angle = build_drive(scene)
    count = angle / sprocket.pitch_rad
    ball = 0.5 * sprocket.roller_diameter_mm
    slack = scene.load.slack_tension_N or 0.0
    tight = np.array(scene.torques_Nmm) / sprocket.pitch_radius_mm + slack
    limits = ", ".join(f"{limit:.4g} N" for limit in sprocket.jump_tension(tight, angle))
    worn = f", worn {chain.link_mm:.4f} mm" if chain.elongation else ""
    large = scene.effects.large_displacement
    key = f"effects.large_displacement {'= true' if large else 'absent'}"
    looser = 1000 * sprocket.seat_radius_mm
    return {
        "body_1: sprocket": [
            ("teeth", f"{sprocket.teeth}"),
            ("pitch diameter", f"{2 * sprocket.pitch_radius_mm:.4f} mm"),
            ("tip diameter", f"{2 * sprocket.tip_radius_mm:.4f} mm"),
            (
                "roller seat radius",
                f"{sprocket.seat_radius_mm + ball:.4f} mm, {looser:.1f} um more than the roller's",
            ),
            ("seating angle", f"{2 * np.degrees(sprocket.seat_half_angle_rad):.2f} deg"),
            ("flank radius", f"{sprocket.flank_radius_mm - ball:.4f} mm"),
            ("tension ratio q", f"{sprocket.tension_ratio:.4f} per roller on the flanks"),
        ],
        "body_2: chain": [
            ("pitch", f"{chain.pitch_mm:g} mm{worn}"),
            ("wrap", f"{np.degrees(angle):g} deg, {count:.4g} pitches"),
            ("free strands", f"{chain.span_mm:g} mm"),
        ],
        "load": [
            ("slack tension", f"{slack:g} N"),
            ("chain jumps below about", limits),
        ],
        "effects": [
            ("large displacements of the rollers", f"{'yes' if large else 'no'} ({key})"),
        ],
    }
