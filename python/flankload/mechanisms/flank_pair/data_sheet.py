"""Drawing data of bodies that touch on flanks, computed from the bodies, not from the keys.

Symbols after ISO 21771; modules, angles and profile shifts follow from the radii and the tooth
thickness of the flanks that are solved.
"""

from __future__ import annotations

from math import atan, cos, degrees, hypot, pi, tan
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.involute import involute_function
from flankload.bodies.body import Roller, SectorMesh
from flankload.bodies.profile.tooth_thickness import measurements
from flankload.bodies.profile_deviation import profile_deviation
from flankload.mechanisms.data_sheet import DataSheet, PathPoint, SheetRow
from flankload.mechanisms.flank_pair.assembly import build_bodies

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.bodies import Body
    from flankload.bodies.profile.involute import Involute
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.gear_pair import GearGeometry
    from flankload.pairing.spline_fit import SplineFit
    from flankload.scene import BodySpec, Scene

#: Least helix angle of helical teeth, rad.
LEAST_HELIX = 1e-9
#: Least difference of the flank's profile shift from that of the scene if there is an allowance.
ALLOWANCE = 1e-6
#: Least deviation from the involute above roundoff, um.
LEAST_DEVIATION_UM = 1e-6


def data_sheet(scene: Scene) -> DataSheet:
    """Drawing data of both bodies; raises a SceneError if they cannot be made or paired."""
    pair = build_bodies(scene)
    one, two = pair.bodies
    gears = pair.pairing.gear_geometry
    path = () if gears is None else _path(pair, gears)
    return DataSheet(
        kinds=(one.kind.replace("_", " "), two.kind.replace("_", " ")),
        bodies=(
            (*_rows_of_profile(one, scene.body_1), *_active(path, 0), *_rows_of_body(one, scene)),
            (*_rows_of_profile(two, scene.body_2), *_active(path, 1), *_rows_of_body(two, scene)),
        ),
        pair=tuple(_rows_of_pair(scene, pair)),
        path=path,
    )


def _mm(value: float) -> str:
    return f"{round(value, 4) + 0.0:.4f} mm"


def _deg(value_rad: float) -> str:
    return f"{degrees(value_rad):.4f}°"


# --- bodies ---------------------------------------------------------------------------------------
def rows_of_profile_and_body(body: Body, spec: BodySpec, scene: Scene) -> Iterator[SheetRow]:
    """Rows of a body without its active profile."""
    yield from _rows_of_profile(body, spec)
    yield from _rows_of_body(body, scene)


def _rows_of_profile(body: Body, spec: BodySpec) -> Iterator[SheetRow]:
    if body.involute is not None:
        yield from _rows_of_involute(body, body.involute, spec)
        yield from _rows_of_flank(body, spec)
    elif body.curve.closed:
        radii = np.hypot(*body.outline.T)
        yield SheetRow("least radius of the profile", "", _mm(radii.min()))
        yield SheetRow("largest radius of the profile", "", _mm(radii.max()))
        yield SheetRow("length of the profile", "", _mm(body.curve.length_mm))
    else:
        if body.kind != "follower":
            yield SheetRow("number of teeth", "z", f"{body.teeth}")
        yield SheetRow("reference radius", "", _mm(body.reference_radius_mm))


def _active(path: tuple[PathPoint, ...], z: int) -> Iterator[SheetRow]:
    """Ends of the active profile: contact moves from root to tip on body 1, reversed on body 2."""
    if path:
        root, tip = (path[0], path[-1]) if z == 0 else (path[-1], path[0])
        yield SheetRow("active tip diameter", "d_Na", _mm(tip.diameters_mm[z]))
        yield SheetRow("active root diameter", "d_Nf", _mm(root.diameters_mm[z]))


def _rows_of_body(body: Body, scene: Scene) -> Iterator[SheetRow]:
    """Rows of a body of any profile: width, fixing, material."""
    yield from _rows_of_touch(body)
    if body.pitch_errors_um:
        errors = body.pitch_errors_um
        text = f"{min(errors):g} to {max(errors):g} µm"
        yield SheetRow("pitch errors of the teeth", "f_pt", text)
    width = body.axial.width_in(scene.pair.face_width_mm)
    yield SheetRow("face width", "b", f"{width:g} mm")
    yield from _rows_along_axis(body)
    if not body.rigid:
        inside = body.bore_radius_mm < np.hypot(*body.outline.T).max()
        around = "diameter of the bore" if inside else "outer diameter"
        free = isinstance(body.mesh, SectorMesh) and body.mesh.has_free_bore
        held = "held in the mean" if free else "held"
        yield SheetRow(f"{around}, {held}", "", _mm(2 * body.bore_radius_mm))
    if body.imported is not None:
        yield SheetRow("compliance", "", body.imported.description)
    if body.rigid:
        yield SheetRow("material", "", "rigid")
        return
    yield SheetRow("Young's modulus", "E", f"{body.material.young_modulus_MPa:g} MPa")
    yield SheetRow("Poisson's ratio", "ν", f"{body.material.poisson_ratio:g}")


def _rows_of_touch(body: Body) -> Iterator[SheetRow]:
    """Rows of a follower's roller or flat."""
    if body.touches is None:
        return
    if isinstance(body.touches, Roller):
        yield SheetRow("length of the arm", "", _mm(body.touches.arm_mm))
        yield SheetRow("radius of the roller", "", _mm(body.touches.radius_mm))
    else:
        start, end = body.touches.ends_mm
        yield SheetRow("offset of the flat", "", _mm(body.touches.offset_mm))
        yield SheetRow("flat from the foot of the axis", "", f"{start:.4f} to {end:.4f} mm")


def _helix_rad(body: Body) -> float:
    """Helix angle on the reference cylinder, positive: right hand."""
    if body.involute is None:
        return 0.0
    return atan(body.axial.twist_rad_per_mm * body.involute.reference_radius_mm)


def _rows_of_involute(body: Body, involute: Involute, spec: BodySpec) -> Iterator[SheetRow]:
    reference, base = involute.reference_radius_mm, involute.base_radius_mm
    helix = _helix_rad(body)
    transverse = float(np.arccos(base / reference))
    normal = atan(tan(transverse) * cos(helix))
    module = 2 * reference / body.teeth
    yield SheetRow("number of teeth", "z", f"{body.teeth}")
    if abs(helix) > LEAST_HELIX:
        yield SheetRow("normal module", "m_n", f"{module * cos(helix):.6g} mm")
        yield SheetRow("transverse module", "m_t", f"{module:.6g} mm")
        yield SheetRow("normal pressure angle", "α_n", _deg(normal))
        yield SheetRow("transverse pressure angle", "α_t", _deg(transverse))
        hand = "right" if helix > 0 else "left"
        yield SheetRow("helix angle", "β", f"{_deg(abs(helix))} {hand}")
    else:
        yield SheetRow("normal module", "m_n", f"{module:.6g} mm")
        yield SheetRow("normal pressure angle", "α_n", _deg(normal))
        yield SheetRow("helix angle", "β", "0° (spur)")
    # half the angle at the base circle: (pi/2 + 2 x tan(alpha_n))/z + inv(alpha_t)
    half = involute.base_half_angle_rad - involute_function(transverse)
    shift = (half * body.teeth - 0.5 * pi) / (2 * tan(normal))
    nominal = getattr(spec.flank_keys[1], "profile_shift", None)
    if nominal is not None and abs(shift - nominal) > ALLOWANCE:
        yield SheetRow("profile shift coefficient", "x", f"{nominal:.4f}")
        yield SheetRow("generating profile shift coefficient", "x_E", f"{shift:.4f}")
    else:
        yield SheetRow("profile shift coefficient", "x", f"{round(shift, 6) + 0.0:.4f}")
    for name, symbol, radius in (
        ("reference diameter", "d", reference),
        ("base diameter", "d_b", base),
        ("tip diameter", "d_a", involute.tip_radius_mm),
        ("root diameter", "d_f", involute.root_radius_mm),
        ("root form diameter", "d_Ff", involute.form_radius_mm),
    ):
        yield SheetRow(name, symbol, _mm(2 * radius))
    tip = 2 * involute.tip_radius_mm * involute.tooth_half_angle_at(involute.tip_radius_mm)
    thickness = 2 * reference * involute.tooth_half_angle_at(reference)
    yield SheetRow("transverse tooth thickness", "s_t", _mm(thickness))
    yield SheetRow("tooth thickness at the tip", "s_a", _mm(tip))
    named = getattr(spec.flank_keys[1], "span_teeth", None)
    found = measurements(involute, body.teeth, helix, named)
    if found.span_mm is not None:
        text = f"{found.span_mm:.4f} mm over k = {found.span_teeth} teeth"
        yield SheetRow("span measurement", "W_k", text)


def _rows_of_flank(body: Body, spec: BodySpec) -> Iterator[SheetRow]:
    """Profile modifications: amounts as in the scene, diameters as on the flank."""
    profile = profile_deviation(body)
    if profile is None:
        return
    keys = spec.flank_keys[1]
    relief, crowning = (
        getattr(keys, key, None) for key in ("tip_relief_um", "profile_crowning_um")
    )
    if relief:
        shape = getattr(keys, "tip_relief_shape", "")
        yield SheetRow("tip relief", "C_αa", f"{relief:g} µm, {shape}")
    root = getattr(keys, "root_relief_um", None)
    if root:
        start = getattr(keys, "root_relief_start_diameter_mm", None)
        at = "" if start is None else f" from diameter {start:g} mm"
        yield SheetRow("root relief", "C_αf", f"{root:g} µm{at}")
    if crowning:
        yield SheetRow("profile crowning", "C_α", f"{crowning:g} µm")
    for name, roll in profile.marks:
        if name not in ("form", "tip"):
            diameter = 2 * hypot(profile.base_radius_mm, roll)
            symbol = "d_Ca" if name == "relief" else "d_Fa"
            yield SheetRow(f"start of the {name}", symbol, _mm(diameter))
    largest = float(-profile.deviation_um.min())
    if keys is None and largest > LEAST_DEVIATION_UM:
        yield SheetRow("largest deviation from the involute", "", f"{largest:.2f} µm")


def _rows_along_axis(body: Body) -> Iterator[SheetRow]:
    """Lead modifications."""
    lead = body.axial.lead
    if lead.crowning_mm:
        yield SheetRow("lead crowning", "C_β", f"{1000 * lead.crowning_mm:g} µm")
    if lead.slope_mm:
        yield SheetRow("helix slope modification", "C_Hβ", f"{1000 * lead.slope_mm:g} µm")
    if any(lead.end_relief_mm):
        parts = (
            f"{1000 * amount:g} µm over {length:g} mm"
            for amount, length in zip(lead.end_relief_mm, lead.end_relief_length_mm, strict=True)
        )
        yield SheetRow("end relief", "C_βI, C_βII", " / ".join(parts))
    if body.axial.surface is not None:
        yield SheetRow("flank topography", "", "varies over height and width")


# --- pair -----------------------------------------------------------------------------------------
def _rows_of_pair(scene: Scene, pair: BodyPair) -> Iterator[SheetRow]:
    gears, fit = pair.pairing.gear_geometry, pair.pairing.fit
    apart = f"{scene.pair.axes_apart_mm:.8g} mm"
    if fit is not None:
        yield SheetRow("offset of the axes", "", apart)
        yield from _spline_rows(fit)
    else:
        yield SheetRow("centre distance", "a", apart)
    if gears is not None:
        yield from _gear_rows(pair, gears)
    yield SheetRow("common face width", "b", f"{scene.pair.face_width_mm:g} mm")
    for name, symbol, value in (
        ("misalignment in the plane of the axes", "f_Σδ", scene.pair.inclination_um_per_mm),
        ("misalignment across that plane", "f_Σβ", scene.pair.deviation_um_per_mm),
    ):
        if value:
            yield SheetRow(name, symbol, f"{value:g} µm/mm")


def rows_of_mesh(gears: GearGeometry, which: str) -> tuple[SheetRow, SheetRow]:
    """Rows of one gear mesh among several; `which` one, in words."""
    angle = _deg(gears.pressure_angle_rad)
    return (
        SheetRow(f"working pressure angle {which}", "α_wt", angle),
        SheetRow(f"contact ratio {which}", "ε_α", f"{gears.contact_ratio:.4f}"),
    )


def _gear_rows(pair: BodyPair, gears: GearGeometry) -> Iterator[SheetRow]:
    one, two = pair.bodies
    yield SheetRow("gear ratio", "u", f"{two.teeth}/{one.teeth} = {two.teeth / one.teeth:.4f}")
    yield SheetRow("working transverse pressure angle", "α_wt", _deg(gears.pressure_angle_rad))
    diameters = f"{2 * gears.pitch_radius_1_mm:.4f} / {2 * gears.pitch_radius_2_mm:.4f} mm"
    yield SheetRow("working pitch diameters", "d_w1 / d_w2", diameters)
    yield SheetRow("transverse base pitch", "p_bt", _mm(gears.base_pitch_mm))
    yield SheetRow("transverse contact ratio", "ε_α", f"{gears.contact_ratio:.4f}")
    if gears.usable_contact_ratio < gears.contact_ratio:
        text = f"{gears.usable_contact_ratio:.4f}"
        yield SheetRow("part of it with both flanks involutes", "", text)
    if gears.overlap_ratio:
        yield SheetRow("overlap ratio", "ε_β", f"{gears.overlap_ratio:.4f}")
        yield SheetRow("total contact ratio", "ε_γ", f"{gears.total_contact_ratio:.4f}")
    yield SheetRow("backlash on the working pitch circles", "j_wt", _mm(gears.backlash_mm))
    yield SheetRow("normal backlash", "j_bn", _mm(gears.normal_backlash_mm))


def _spline_rows(fit: SplineFit) -> Iterator[SheetRow]:
    low, high = fit.active_radii_mm
    yield SheetRow("pressure angle", "α", _deg(fit.pressure_angle_rad))
    yield SheetRow("pitch diameter", "D", _mm(2 * fit.pitch_radius_mm))
    yield SheetRow("active flank between", "", f"{2 * low:.4f} and {2 * high:.4f} mm")
    yield SheetRow("backlash on the pitch circle", "j_t", _mm(fit.backlash_mm))
    yield SheetRow("normal backlash", "j_bn", _mm(fit.normal_backlash_mm))


def _path(pair: BodyPair, gears: GearGeometry) -> tuple[PathPoint, ...]:
    """Points A to E of the path of contact, in the order in which a pair passes them."""
    pitch, angle = gears.base_pitch_mm, gears.pressure_angle_rad
    start, end = gears.path_start_mm, gears.path_end_mm
    # a length that increases on body 1 decreases on body 2, or increases on an internal gear
    sense = pair.body_2.outward
    radii = [radius * cos(angle) for radius in (gears.pitch_radius_1_mm, gears.pitch_radius_2_mm)]

    def point(name: str, along: float) -> PathPoint:
        one = radii[0] * tan(angle) + along
        two = radii[1] * tan(angle) - sense * along
        return PathPoint(
            name,
            along,
            (2 * hypot(radii[0], one), 2 * hypot(radii[1], two)),
            (degrees(one / radii[0]), degrees(two / radii[1])),
        )

    return (
        point("A", start),
        point("B", end - pitch),
        point("C", 0.0),
        point("D", start + pitch),
        point("E", end),
    )
