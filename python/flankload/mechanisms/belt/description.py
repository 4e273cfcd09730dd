"""Rows of `flankload check` for a pulley and its belt, and their data sheet."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

from flankload.mechanisms.belt.belt import build_strip
from flankload.mechanisms.belt.belt_mesh import mesh_strip
from flankload.mechanisms.belt.drive import bodies_of, flank_elements, pulley_mesh
from flankload.mechanisms.data_sheet import DataSheet, SheetRow
from flankload.mechanisms.wrapped import slack_of, tight_tensions
from flankload.meshes.report import quality_rows

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.protocol import Rows
    from flankload.scene import Belt, Pulley, Scene


def rows_of_belt(scene: Scene) -> dict[str, Rows]:
    """Name and value of each row, by title."""
    strip = build_strip(*bodies_of(scene))
    mesh = mesh_strip(strip, flank_elements(scene, strip))
    slack, tight = slack_of(scene), tight_tensions(scene, strip.pitch_radius_mm)
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


def sheet_of_belt(scene: Scene) -> DataSheet:
    """Drawing data of a pulley and its belt."""
    pulley, belt = bodies_of(scene)
    strip = build_strip(pulley, belt)
    return DataSheet(
        ("pulley", "timing belt"),
        (tuple(_sheet_of_pulley(pulley, strip)), tuple(_sheet_of_strip(belt))),
        tuple(_sheet_of_wrap(scene, strip)),
    )


def _sheet_of_pulley(pulley: Pulley, strip: Strip) -> Iterator[SheetRow]:
    yield SheetRow("profile", "", pulley.profile)
    yield SheetRow("number of teeth", "z", f"{strip.pulley_teeth}")
    yield SheetRow("pitch", "p_b", f"{pulley.pitch_mm:g} mm")
    yield SheetRow("pitch diameter", "d", f"{2 * strip.pitch_radius_mm:.4f} mm")
    yield SheetRow("outer diameter", "d_0", f"{2 * strip.land_radius_mm:.4f} mm")
    if pulley.rigid:
        yield SheetRow("material", "", "rigid")
        return
    yield SheetRow("bore diameter, held", "", f"{pulley.bore_diameter_mm:g} mm")
    yield SheetRow("Young's modulus", "E", f"{pulley.young_modulus_MPa:g} MPa")
    yield SheetRow("Poisson's ratio", "ν", f"{pulley.poisson_ratio:g}")


def _sheet_of_strip(belt: Belt) -> Iterator[SheetRow]:
    yield SheetRow("pitch", "p_b", f"{belt.pitch_mm:g} mm")
    yield SheetRow("width", "b_s", f"{belt.width_mm:g} mm")
    yield SheetRow("tooth height", "h_t", f"{belt.tooth_height_mm:g} mm")
    yield SheetRow("tooth width at the land", "", f"{belt.tooth_width_mm:g} mm")
    if belt.flank_angle_deg is not None:
        yield SheetRow("flank angle to the centre line", "", f"{belt.flank_angle_deg:g}°")
    yield SheetRow("land to pitch line", "", f"{belt.land_distance_mm:g} mm")
    yield SheetRow("land to back", "", f"{belt.back_mm:g} mm")
    cord = belt.cord_stiffness_N_per_mm * belt.width_mm
    yield SheetRow("cord stiffness, tension over strain", "", f"{cord:g} N")
    yield SheetRow("Young's modulus", "E", f"{belt.young_modulus_MPa:g} MPa")
    yield SheetRow("Poisson's ratio", "ν", f"{belt.poisson_ratio:g}")


def _sheet_of_wrap(scene: Scene, strip: Strip) -> Iterator[SheetRow]:
    slack, tight = slack_of(scene), tight_tensions(scene, strip.pitch_radius_mm)
    clearance = 1000.0 * strip.clearance_rad * strip.pitch_radius_mm
    wrap = strip.wrapped_teeth * strip.pitch_rad
    yield SheetRow("teeth in mesh", "z_m", f"{strip.wrapped_teeth}")
    yield SheetRow("angle of wrap", "θ", f"{degrees(wrap):g}°")
    yield SheetRow("pitch difference", "Δp", f"{1000 * strip.pitch_difference_mm:g} µm")
    yield SheetRow("clearance of the flanks", "", f"{clearance:.4g} µm")
    yield SheetRow("tight tension", "F_1", ", ".join(f"{value:.4g} N" for value in tight))
    yield SheetRow("slack tension", "F_2", f"{slack:g} N")
    yield SheetRow(
        "effective tension", "F_u", ", ".join(f"{value - slack:.4g} N" for value in tight)
    )
