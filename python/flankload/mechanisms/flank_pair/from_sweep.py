"""Conversion of the core's states to a result in common units and directions."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import pi, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.profile_deviation import profile_deviation
from flankload.contact.core_call import CORE_COUNTERS
from flankload.mechanisms.flank_pair.notes import notes_of_result, notes_of_sweep
from flankload.mechanisms.flank_pair.shaft_loads import shaft_loads
from flankload.pairing.common_height import turned
from flankload.result.friction import FrictionResult, friction_result
from flankload.result.harmonics import over_positions
from flankload.result.pairs import PairDrawing, PairTable, PairTables
from flankload.result.parts import CoastContact
from flankload.result.result import Result
from flankload.result.root_stress import root_reading
from flankload.result.slices import SliceLoads

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from flankload.bodies.profile_deviation import ProfileDeviation
    from flankload.contact.pair_table import PackedPairs
    from flankload.contact.sweep import CoastSweep, Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.gear_pair import Mesh
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.result.geometry import PairGeometry


def result_of(
    found: Sweep,
    pair: BodyPair,
    compliances: tuple[BodyCompliance, BodyCompliance],
    *,
    name: str,
    face_width_mm: float,
    estimate: Mapping[str, object] | None,
    geometry: PairGeometry | None = None,
    notes: tuple[str, ...] = (),
) -> Result:
    """Make the result of one torque; its `cost` contains the part of this torque.

    Parameters
    ----------
    found : Sweep
        States from the core.
    pair : BodyPair
    compliances : two BodyCompliance
    name : str
        Name of the scene.
    face_width_mm : float
    estimate : mapping or None
        Error estimates, as the result shows them.
    geometry : PairGeometry, optional
        Geometry of the pair, shared by the results of several torques.
    notes : tuple of str
        Further warnings.

    Returns
    -------
    Result
    """
    circle = pair.pairing.whole_circle
    loaded = (found.site_force_N > 0).any(axis=0)
    if found.coast is not None:
        loaded |= (found.coast.site_force_N > 0).any(axis=0)
    carries = np.flatnonzero(loaded | (pair.pairing.sites == 0) | circle)
    # slices cover the common width, and their peaks are pressures
    width, peak_width = face_width_mm, face_width_mm
    if pair.slices is not None:
        width, peak_width = float(pair.slices.width_mm.sum()), 1.0
    standing = (*pair.notes, *([pair.standing_note] if pair.standing_note else []))
    result = Result(
        name=name,
        torque_Nm=found.torque_Nmm / 1000.0,
        sites=pair.pairing.sites[carries],
        position_rad=pair.position_rad,
        rotation_rad=found.rotation_rad,
        reference_radius_mm=pair.body_1.reference_radius_mm,
        site_force_N=found.site_force_N[:, carries],
        peak_pressure_MPa=found.site_peak_N_per_mm[:, carries] / peak_width,
        stiffness_tangent_Nm_per_rad=_stiffness(found.tangent_rad_per_Nmm),
        status=found.status,
        pair_tables=_pair_tables(pair, found, width),
        corner_contact=found.site_corner[:, carries] > 0,
        pitch_rad=pair.pairing.pitch_rad,
        period_rad=pair.period_rad,
        closed=pair.closed,
        whole_circle=circle,
        face_width_mm=width,
        estimate=estimate,
        cost=_cost(found, compliances),
        warnings=(*standing, *notes, *notes_of_sweep(pair, compliances, found, width)),
        drawing=_drawing(pair),
        geometry=geometry,
        root_readings=(
            root_reading(pair, compliances[0], 0, carries, width),
            root_reading(pair, compliances[1], 1, carries, width),
        ),
        follower_angle_rad=None
        if pair.pairing.motion is None
        else pair.pairing.turns(pair.position_rad)[0],
        unloaded_rotation_rad=found.unloaded_rad,
    )
    return _with_parts(result, pair, found, carries)


def _pair_tables(pair: BodyPair, found: Sweep, width_mm: float) -> PairTables:
    """Tables of the contact pairs at all positions, made when they are read."""
    axial = pair.body_1.axial
    table = partial(
        _pair_table,
        pair.pairing,
        found.pairs,
        width_mm,
        pair.effects.lumped_contact,
        slices=pair.slices,
        twist=0.0 if axial is None else axial.twist_rad_per_mm,
    )
    return PairTables(len(found.n_pairs), table)


def _with_parts(result: Result, pair: BodyPair, found: Sweep, carries: NDArray[np.int64]) -> Result:
    """A result with the parts that only some pairs have: slices, coast flanks, friction."""
    if pair.slices is not None:
        result = replace(
            result,
            slices=_slice_loads(pair, pair.slices, found).at_sites(carries),
            shafts=shaft_loads(pair, pair.slices, found.pairs),
        )
    if found.coast is not None:
        result = replace(result, coast=_coast(pair, found.coast, carries, result.face_width_mm))
    result = replace(result, warnings=(*result.warnings, *notes_of_result(result, pair)))
    if pair.friction is None:
        return result
    return replace(result, friction=_friction(pair, found, carries, result))


def _slice_loads(pair: BodyPair, slices: Slices, found: Sweep) -> SliceLoads:
    """Loads of the slices; forces are normal to the flanks."""
    axial = pair.body_1.axial
    assert axial is not None
    radius = pair.body_1.base_radius_mm or abs(pair.body_1.normal_lever_mm)
    assert found.slice_force_N is not None
    assert found.slice_peak_MPa is not None
    tangent = axial.twist_rad_per_mm * radius
    return SliceLoads(
        z_mm=slices.z_mm,
        width_mm=slices.width_mm,
        force_N=found.slice_force_N,
        peak_pressure_MPa=found.slice_peak_MPa,
        tangent_helix_base=tangent,
        cosine_helix_base=1.0 / sqrt(1.0 + tangent**2),
        directions=None
        if slices.conforming is None
        else turned(
            slices.conforming.middle_normal,
            pair.pairing.turns(pair.position_rad)[0][:, None] + pair.pairing.site_angles_rad[0],
        ),
    )


def _cost(found: Sweep, compliances: tuple[BodyCompliance, BodyCompliance]) -> dict[str, object]:
    """Work of the states of one torque, without tangents and estimate."""
    counters = found.counters.sum(axis=0, dtype=np.int64).tolist()
    return {
        "positions": found.status.size,
        "of_this_torque": dict(zip(CORE_COUNTERS, counters, strict=True)),
        "fe_degrees_of_freedom": [c.job.degrees_of_freedom for c in compliances],
        "largest_backward_error": float(np.max(found.certificate[:, 0], initial=0.0)),
        "largest_condition": float(np.max(found.certificate[:, 1], initial=0.0)),
    }


def _coast(
    pair: BodyPair, found: CoastSweep, carries: NDArray[np.int64], width: float
) -> CoastContact:
    """Contact on the coast flanks of some pair numbers."""
    return CoastContact(
        force_N=found.site_force_N[:, carries],
        peak_pressure_MPa=found.site_peak_N_per_mm[:, carries] / width,
        corner_contact=found.site_corner[:, carries] > 0,
        pair_tables=PairTables(
            len(found.pairs.count),
            partial(_pair_table, pair.pairing, found.pairs, width, pair.effects.lumped_contact),
        ),
    )


def _stiffness(tangent_rad_per_Nmm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Torque divided by rotation; NaN if a very small torque causes no rotation of body 1."""
    stiffness = np.full_like(tangent_rad_per_Nmm, np.nan)
    np.divide(1e-3, tangent_rad_per_Nmm, out=stiffness, where=tangent_rad_per_Nmm != 0)
    return stiffness


def _pair_table(
    pairing: Pairing,
    pairs: PackedPairs,
    width: float,
    lumped: bool,
    p: int,
    slices: Slices | None = None,
    twist: float = 0.0,
) -> PairTable:
    """Contact pairs at position p; `twist` is that of body 1, rad/mm."""
    site, table = pairs.at(p)
    column = dict(zip(pairs.names, table.T, strict=True))
    z_mm, length = None, np.asarray(width)
    slice_number = pairs.slices_at(p)
    if slices is not None and slice_number is not None:
        # the contact line of a slice leans by the base helix angle, as its normal does
        lever = column["x"] * column["normal_y"] - column["y"] * column["normal_x"]
        z_mm = slices.z_mm[slice_number]
        length = slices.width_mm[slice_number] * np.hypot(1.0, twist * lever)
    return PairTable(
        site=pairing.sites[site],
        arc_length_1_mm=column["s_1"],
        arc_length_2_mm=column["s_2"],
        radius_mm=column["radius"],
        x_mm=column["x"],
        y_mm=column["y"],
        normal_x=column["normal_x"],
        normal_y=column["normal_y"],
        force_N=column["force"],
        pressure_MPa=column["force"] / (column["cell"] * length),
        gap_um=1000.0 * column["gap"],
        cell_mm=column["cell"],
        sliding_mm_per_rad=column.get("sliding"),
        friction_force_N=column["friction"] * column["force"] if "friction" in column else None,
        half_width_mm=column["cell"] * (2.0 / pi) if lumped and not pairing.whole_circle else None,
        z_mm=z_mm,
    )


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

    summed = friction_result(
        {
            **{name: np.concatenate([pairs.column(name) for pairs, _ in parts]) for name in names},
            "position": np.concatenate([pairs.position for pairs, _ in parts]),
            "site": np.concatenate([pairs.sites + first for pairs, first in parts]),
            "in_section": np.concatenate([_in_section(pair, pairs) for pairs, _ in parts]),
            **({} if pair.slices is None else {"z": _from_middle(pair.slices, found.pairs)}),
        },
        n_sites=n_sites,
        n_working=pair.pairing.sites.size,
        center_distance_mm=pair.pairing.center_distance_mm,
        speeds=pair.friction.speeds(pair.pairing, result.position_rad),
        driver=pair.friction.driver,
        torque_1_Nm=result.torque_Nm,
        over_period=over_period,
    )
    return replace(summed, site_friction_N=summed.site_friction_N[:, carries])


def _in_section(pair: BodyPair, pairs: PackedPairs) -> NDArray[np.float64]:
    """Part of each normal force that lies in the transverse section: cos(beta)."""
    x, y, across, up = (pairs.column(name) for name in ("x", "y", "normal_x", "normal_y"))
    if pair.body_1.axial is None:
        return np.ones_like(x)
    return np.asarray(
        1.0 / np.hypot(1.0, pair.body_1.axial.twist_rad_per_mm * (x * up - y * across))
    )


def _from_middle(slices: Slices, pairs: PackedPairs) -> NDArray[np.float64]:
    """Axial distance of each pair from the middle of the face width."""
    z_mm = slices.z_mm - 0.5 * (slices.edges_mm[0] + slices.edges_mm[-1])
    return np.asarray(z_mm[pairs.slices])


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
        active_roll_mm=_active_roll_mm(pair.pairing.mesh, pair.pairing.ratio, profiles),
        axial=(pair.body_1.axial, pair.body_2.axial),
        tilted=pair.slices is not None
        and pair.slices.conforming is not None
        and bool(pair.slices.conforming.tilt.any()),
    )


def _active_roll_mm(
    mesh: Mesh | None,
    ratio: float,
    profiles: tuple[ProfileDeviation | None, ProfileDeviation | None],
) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
    """Roll lengths between which the flanks meet: each ends at its tip or tip rounding."""
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
