"""Rows of `flankload check` for a sprocket and its chain, and their data sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.chain.drive import build_drive
from flankload.mechanisms.data_sheet import DataSheet, SheetRow
from flankload.mechanisms.wrapped import slack_of, tight_tensions

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.mechanisms.chain.sprocket import Sprocket
    from flankload.mechanisms.chain.wrap import Chain
    from flankload.mechanisms.protocol import Rows
    from flankload.scene import Scene


def rows_of_chain(scene: Scene) -> dict[str, Rows]:
    """Name and value of each row, by title."""
    sprocket, chain, angle = build_drive(scene)
    count = angle / sprocket.pitch_rad
    ball = 0.5 * sprocket.roller_diameter_mm
    slack, tight = slack_of(scene), tight_tensions(scene, sprocket.pitch_radius_mm)
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


def sheet_of_chain(scene: Scene) -> DataSheet:
    """Drawing data of a sprocket and its chain."""
    sprocket, chain, angle = build_drive(scene)
    slack, tight = slack_of(scene), tight_tensions(scene, sprocket.pitch_radius_mm)
    limits = sprocket.jump_tension(tight, angle)
    return DataSheet(
        ("sprocket", "roller chain"),
        (tuple(_sheet_of_sprocket(sprocket)), tuple(_sheet_of_links(chain, sprocket))),
        (
            SheetRow("angle of wrap", "", f"{np.degrees(angle):g}°"),
            SheetRow("pitches in the wrap", "", f"{angle / sprocket.pitch_rad:.4g}"),
            SheetRow("tight tension", "F_1", ", ".join(f"{value:.4g} N" for value in tight)),
            SheetRow("slack tension", "F_2", f"{slack:g} N"),
            SheetRow("chain jumps below", "", ", ".join(f"{limit:.4g} N" for limit in limits)),
        ),
    )


def _sheet_of_sprocket(sprocket: Sprocket) -> Iterator[SheetRow]:
    ball = 0.5 * sprocket.roller_diameter_mm
    root = 2 * (sprocket.pitch_radius_mm - ball)
    yield SheetRow("number of teeth", "z", f"{sprocket.teeth}")
    yield SheetRow("pitch", "p", f"{sprocket.pitch_mm:g} mm")
    yield SheetRow("pitch diameter", "d", f"{2 * sprocket.pitch_radius_mm:.4f} mm")
    yield SheetRow("tip diameter", "d_a", f"{2 * sprocket.tip_radius_mm:.4f} mm")
    yield SheetRow("root diameter", "d_f", f"{root:.4f} mm")
    yield SheetRow("roller seating radius", "r_i", f"{sprocket.seat_radius_mm + ball:.4f} mm")
    yield SheetRow("tooth flank radius", "r_e", f"{sprocket.flank_radius_mm - ball:.4f} mm")
    seat = 2 * np.degrees(sprocket.seat_half_angle_rad)
    yield SheetRow("roller seating angle", "α", f"{seat:.2f}°")
    yield SheetRow("tension ratio of neighbouring links", "q", f"{sprocket.tension_ratio:.4f}")
    yield SheetRow("material", "", "rigid; the contact stiffness is that of the chain")


def _sheet_of_links(chain: Chain, sprocket: Sprocket) -> Iterator[SheetRow]:
    yield SheetRow("pitch", "p", f"{chain.pitch_mm:g} mm")
    if chain.elongation:
        yield SheetRow("pitch, worn", "", f"{chain.link_mm:.4f} mm")
        yield SheetRow("elongation by wear", "", f"{100 * chain.elongation:g} %")
    yield SheetRow("roller diameter", "d_1", f"{sprocket.roller_diameter_mm:g} mm")
    yield SheetRow("link stiffness, tension over strain", "", f"{chain.link_stiffness_N:g} N")
    contact = chain.contact_stiffness_N_per_mm
    yield SheetRow("contact stiffness of a roller", "", f"{contact:g} N/mm")
    yield SheetRow("free strands", "", f"{chain.span_mm:g} mm")
