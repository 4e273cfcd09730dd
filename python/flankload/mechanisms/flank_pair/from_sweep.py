"""Conversion of the core's states to a result in common units and directions."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import pi, sin, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rotation import turned
from flankload.base.torque import in_newton_metres, stiffness_Nm_per_rad
from flankload.bodies.profile_deviation import profile_deviation
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.status import on_corner
from flankload.mechanisms.flank_pair.notes import notes_of_result, notes_of_sweep
from flankload.result.friction import FrictionResult, friction_result
from flankload.result.harmonics import over_positions
from flankload.result.optional_results import CoastContact, ShaftLoads
from flankload.result.pairs import PairDrawing, PairTable, PairTables
from flankload.result.result import Result
from flankload.result.root_stress import root_reading
from flankload.result.slices import SliceLoads

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.bodies.profile_deviation import ProfileDeviation
    from flankload.contact.pair_table import PackedPairs
    from flankload.contact.sweep import CoastSweep, Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.flank_pair.stages import Compliances
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.common_height import CommonHeight
    from flankload.pairing.gear_pair import GearGeometry
    from flankload.pairing.slices import Slices
    from flankload.result.geometry import PairGeometry
    from flankload.scene import Scene


def result_of(
    scene: Scene,
    pair: BodyPair,
    compliances: Compliances,
    found: Sweep,
    *,
    estimate: Mapping[str, object] | None,
    geometry: PairGeometry | None = None,
    notes: tuple[str, ...] = (),
) -> Result:
    """Result of one torque; its `cost` contains the part of this torque.

    `estimate` are error estimates as the result shows them; `geometry` is shared by the results of
    several torques; `notes` are further warnings.
    """
    circle = pair.pairing.whole_circle
    loaded = (found.site_force_N > 0).any(axis=0)
    if found.coast is not None:
        loaded |= (found.coast.site_force_N > 0).any(axis=0)
    carries = np.flatnonzero(loaded | (pair.pairing.sites == 0) | circle)
    pair_notes = (*pair.notes, *([pair.flank_distance_note] if pair.flank_distance_note else []))
    result = Result(
        name=scene.name,
        torque_Nm=in_newton_metres(found.torque_Nmm),
        sites=pair.pairing.sites[carries],
        position_rad=pair.position_rad,
        rotation_rad=found.rotation_rad,
        reference_radius_mm=pair.body_1.reference_radius_mm,
        site_force_N=found.site_force_N[:, carries],
        peak_pressure_MPa=found.site_peak_N_per_mm[:, carries] / pair.slices.compliance_width_mm,
        stiffness_tangent_Nm_per_rad=stiffness_Nm_per_rad(found.tangent_rad_per_Nmm),
        status=found.status,
        pair_tables=pair_tables(pair, found.pairs),
        corner_contact=on_corner(found.site_corner[:, carries]),
        pitch_rad=pair.pairing.pitch_rad,
        period_rad=pair.period_rad,
        closed=pair.closed,
        whole_circle=circle,
        face_width_mm=pair.face_width_mm,
        estimate=estimate,
        cost=cost_of(found, compliances),
        warnings=(*pair_notes, *notes, *notes_of_sweep(pair, compliances, found)),
        drawing=_drawing(pair),
        geometry=None if geometry is None else replace(geometry, speed_rpm=scene.effects.speed_rpm),
        root_readings=(
            root_reading(pair, compliances, 0, carries),
            root_reading(pair, compliances, 1, carries),
        ),
        follower_angle_rad=None
        if pair.pairing.motion is None
        else pair.pairing.turns(pair.position_rad)[0],
        unloaded_rotation_rad=None if found.unloaded is None else found.unloaded.rotation_rad,
    )
    return _with_parts(result, pair, found, carries)


def _with_parts(result: Result, pair: BodyPair, found: Sweep, carries: NDArray[np.int64]) -> Result:
    """A result with the optional parts: slices, coast flanks, friction."""
    if not pair.slices.plane:
        loads = _slice_loads(pair, found, over_positions(result).weights)
        shafts = shaft_loads(pair, pair.slices, found)
        result = replace(result, slices=loads.at_sites(carries), shafts=shafts)
    if found.coast is not None:
        result = replace(result, coast=_coast(pair, found.coast, carries))
    result = replace(result, warnings=(*result.warnings, *notes_of_result(result, pair)))
    if pair.friction is None:
        return result
    return replace(result, friction=_friction(pair, found, carries, result))


def _slice_loads(pair: BodyPair, found: Sweep, weights: Floats) -> SliceLoads:
    """Loads of the slices; forces are normal to the flanks; `weights` are those of positions."""
    slices, coast = pair.slices, found.coast
    radius = pair.body_1.base_radius_mm or abs(pair.body_1.normal_lever_mm)
    tangent = pair.body_1.axial.twist_rad_per_mm * radius
    return SliceLoads(
        z_mm=slices.z_mm,
        width_mm=slices.width_mm,
        force_N=found.slices.force_N,
        peak_pressure_MPa=found.slices.peak_MPa,
        tangent_helix_base=tangent,
        cosine_helix_base=1.0 / sqrt(1.0 + tangent**2),
        line_load_length_mm=slices.line_load_mm,
        weights=weights,
        coast_force_N=None if coast is None else coast.site_force_N.sum(axis=1),
        directions=None
        if slices.conforming is None
        else turned(
            slices.conforming.middle_normal,
            pair.pairing.turns(pair.position_rad)[0][:, None] + pair.pairing.site_angles_rad[0],
        ),
    )


def cost_of(found: Sweep, compliances: Sequence[BodyCompliance]) -> dict[str, object]:
    """Work of the states of one torque, without tangents and estimate."""
    counters = found.counters.sum(axis=0, dtype=np.int64).tolist()
    return {
        "positions": found.status.size,
        "of_this_torque": dict(zip(CORE_COUNTERS, counters, strict=True)),
        "fe_degrees_of_freedom": [c.job.degrees_of_freedom for c in compliances],
        "largest_backward_error": float(np.max(found.certificate[:, 0], initial=0.0)),
        "largest_condition": float(np.max(found.certificate[:, 1], initial=0.0)),
    }


def _coast(pair: BodyPair, found: CoastSweep, carries: NDArray[np.int64]) -> CoastContact:
    """Contact on the coast flanks of some pair numbers."""
    return CoastContact(
        force_N=found.site_force_N[:, carries],
        peak_pressure_MPa=found.site_peak_N_per_mm[:, carries] / pair.slices.compliance_width_mm,
        corner_contact=on_corner(found.site_corner[:, carries]),
        pair_tables=pair_tables(pair, found.pairs),
    )


def pair_tables(pair: BodyPair, pairs: PackedPairs) -> PairTables:
    """Tables of the contact pairs at all positions, made on demand."""
    return PairTables(len(pairs.count), partial(_pair_table, pair, pairs))


def _pair_table(pair: BodyPair, pairs: PackedPairs, p: int) -> PairTable:
    """Contact pairs at position p."""
    column, number, slices = pairs.columns_at(p), pairs.slices_at(p), pair.slices
    half_width = pair.effects.lumped_contact and not pair.pairing.whole_circle
    return PairTable(
        site=pair.pairing.sites[pairs.at(p)[0]],
        radius_mm=column["radius"],
        x_mm=column["x"],
        y_mm=column["y"],
        normal_x=column["normal_x"],
        normal_y=column["normal_y"],
        sliding_mm_per_rad=column.get("sliding"),
        friction_force_N=column["friction"] * column["force"] if "friction" in column else None,
        half_width_mm=column["cell"] * (2.0 / pi) if half_width else None,
        # the contact line of a slice and its normal are inclined by the base helix angle
        **contact_columns(column, slices, number, np.hypot(1.0, _slope(pair, column))),
    )


def contact_columns(
    column: Mapping[str, Floats],
    slices: Slices,
    number: NDArray[np.integer],
    inclined: Floats | float,
) -> dict[str, Floats]:
    """Columns of a table of contact pairs that no frame changes.

    `number`: of the slice of each pair; `inclined`: length of its contact line over the width.
    """
    found = {
        "arc_length_1_mm": column["s_1"],
        "arc_length_2_mm": column["s_2"],
        "force_N": column["force"],
        "pressure_MPa": column["force"] / (column["cell"] * (slices.width_mm[number] * inclined)),
        "gap_um": 1000.0 * column["gap"],
        "cell_mm": column["cell"],
    }
    return found if slices.plane else found | {"z_mm": slices.z_mm[number]}


def _friction(
    pair: BodyPair, found: Sweep, carries: NDArray[np.int64], result: Result
) -> FrictionResult:
    """Quantities of friction."""
    assert pair.friction is not None
    names = ("x", "y", "normal_x", "normal_y", "force", "sliding", "friction")
    n_sites = pair.pairing.sites.size
    parts = [(found.pairs, 0)]
    if found.coast is not None:
        parts.append((found.coast.pairs, n_sites))
        n_sites *= 2
    whole = over_positions(result)

    def over_period(values: NDArray[np.float64]) -> float | None:
        return whole.mean(values) * result.period_rad if whole.covers_period else None

    columns = {name: np.concatenate([pairs.column(name) for pairs, _ in parts]) for name in names}
    columns |= {
        "position": np.concatenate([pairs.position for pairs, _ in parts]),
        "site": np.concatenate([pairs.sites + first for pairs, first in parts]),
        "in_section": 1.0 / np.hypot(1.0, _slope(pair, columns)),
    }
    if not pair.slices.plane:
        places = [pairs.slices for pairs, _ in parts]
        columns["z"] = pair.slices.from_middle_mm[np.concatenate(places)]
    height, speeds = pair.slices.conforming, pair.friction.speeds(pair.pairing, pair.position_rad)
    if height is not None:
        columns |= _along_axis(pair, height, columns, speeds[0])
    summed = friction_result(
        columns,
        n_sites=n_sites,
        n_working=pair.pairing.sites.size,
        center_distance_mm=pair.pairing.center_distance_mm,
        speeds=speeds,
        driver=pair.friction.driver,
        torque_1_Nm=result.torque_Nm,
        over_period=over_period,
        tilt=None if height is None else height.tilt,
    )
    return replace(summed, site_friction_N=summed.site_friction_N[:, carries])


def _along_axis(
    pair: BodyPair, height: CommonHeight, columns: Mapping[str, NDArray[Any]], speed: Floats
) -> dict[str, Floats]:
    """Axial sliding speed of the pairs of a spline, and the part of friction in its direction.

    Body 2 turns about an axis with the slope t: (v2 - v1) is w (t_x y - t_y x) along z.
    """
    assert pair.friction is not None
    (slope_x, slope_y), sliding = height.tilt, columns["sliding"]
    x = columns["x"] - pair.pairing.center_distance_mm
    axial = speed[columns["position"]] * (slope_x * columns["y"] - slope_y * x)
    # equal along the flank: splines have no roll position
    coefficients = pair.friction.coefficients[0][columns["site"] % pair.pairing.sites.size]
    fastest = np.hypot(sliding, axial)
    part = np.divide(axial, fastest, out=np.zeros_like(axial), where=fastest > 0)
    return {"axial_sliding": axial, "axial_friction": coefficients * part}


def shaft_loads(pair: BodyPair, slices: Slices, found: Sweep) -> ShaftLoads | None:
    """Tilt of the teeth and forces on the bearings at all positions; None without a shaft."""
    shafts = [body.axial.shaft for body in pair.bodies]
    if shafts == [None, None]:
        return None
    count = len(found.status)
    tilt, bearings = np.zeros(count), [np.zeros((count, 0, 3)), np.zeros((count, 0, 3))]
    for z, (shaft, sign) in enumerate(zip(shafts, (-1.0, 1.0), strict=True)):
        if shaft is None:
            continue
        axis = np.array([z * pair.pairing.center_distance_mm, 0.0, shaft.z_mm])
        bearings[z] = np.zeros((count, len(shaft.bearing_loads), 3))
        for p in range(count):
            points, normal, friction = _contacts(pair, slices, found.pairs, p)
            if not normal.any():
                continue
            force = sign * (normal + friction)
            if found.coast is not None:
                also, pressed, rubbed = _contacts(pair, slices, found.coast.pairs, p)
                points = np.concatenate([points, also])
                # on coast flanks, the force of friction is along the normal rotated by +90 degrees
                force = np.concatenate([force, sign * (pressed - rubbed)])
            wrench = np.concatenate([force.sum(axis=0), np.cross(points - axis, force).sum(axis=0)])
            turned = (shaft.compliance @ wrench)[3:]
            across = normal[:, :2].sum(axis=0)
            across /= np.linalg.norm(across)
            tilt[p] += sign * (across[0] * turned[1] - across[1] * turned[0])
            bearings[z][p] = shaft.bearing_loads @ wrench
    return ShaftLoads(1000.0 * tilt, bearings[0], bearings[1])


def _contacts(
    pair: BodyPair, slices: Slices, pairs: PackedPairs, p: int
) -> tuple[Floats, Floats, Floats]:
    """Contact points (n, 3) at position p, with normal and friction forces on body 2."""
    column = pairs.columns_at(p)
    across, up = column["normal_x"], column["normal_y"]
    # n = (cos b n_t, -twist l cos b) with the lever l of the transverse normal
    slope = _slope(pair, column)
    normals = np.column_stack([across, up, slope]) / np.hypot(1.0, slope)[:, np.newaxis]
    force = column["force"][:, np.newaxis]
    friction = np.zeros_like(normals)
    if "friction" in column:  # along the normal rotated by -90 degrees
        along = np.column_stack([-up, across, np.zeros_like(up)])
        friction = column["friction"][:, np.newaxis] * force * along
    z_mm = slices.z_mm[pairs.slices_at(p)]
    return np.column_stack([column["x"], column["y"], z_mm]), force * normals, friction


def _slope(pair: BodyPair, column: Mapping[str, Floats]) -> Floats:
    """Axial component of each outward normal of body 1, relative to the transverse one."""
    lever = column["x"] * column["normal_y"] - column["y"] * column["normal_x"]
    return np.asarray(-pair.body_1.axial.twist_rad_per_mm * lever)


def _drawing(pair: BodyPair) -> PairDrawing:
    turn_1, turn_2 = pair.pairing.turns(pair.position_rad)
    profiles = (profile_deviation(pair.body_1), profile_deviation(pair.body_2))
    return PairDrawing(
        outline_1=pair.body_1.outline,
        outline_2=pair.body_2.outline,
        teeth_1=pair.body_1.teeth,
        teeth_2=pair.body_2.teeth,
        center_distance_mm=pair.pairing.center_distance_mm,
        angle_1=turn_1,
        angle_2=turn_2,
        bore_radius_1_mm=pair.body_1.bore_radius_mm,
        bore_radius_2_mm=pair.body_2.bore_radius_mm,
        profiles=profiles,
        cam_turns_clockwise=pair.body_2.turns_clockwise if pair.pairing.motion else None,
        active_roll_mm=_active_roll_mm(pair.pairing.gear_geometry, pair.pairing.ratio, profiles),
        axial=(pair.body_1.axial, pair.body_2.axial),
        tilted=pair.slices.conforming is not None and bool(pair.slices.conforming.tilt.any()),
    )


def _active_roll_mm(
    mesh: GearGeometry | None,
    ratio: float,
    profiles: tuple[ProfileDeviation | None, ProfileDeviation | None],
) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
    """Roll lengths of the active profiles, which end at a tip or tip rounding."""
    if mesh is None:
        return None, None
    # both base circles touch the line of action; a length that increases on body 1 decreases on
    # body 2, or increases if body 2 is an internal gear
    sense = 1 if ratio > 0 else -1
    whole = mesh.pitch_radius_2_mm + sense * mesh.pitch_radius_1_mm
    whole *= sin(mesh.pressure_angle_rad)
    one, two = (profile.roll_length_mm for profile in profiles if profile is not None)
    end_1, end_2 = float(one[-1]), float(two[-1 if sense > 0 else 0])
    active_2 = sorted((end_2, whole - sense * end_1))
    return (sense * (whole - end_2), end_1), (active_2[0], active_2[1])
