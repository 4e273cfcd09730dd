"""Conversion of the states of a belt to its result: tensions, lands, warnings, a drawing."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.base.torque import stiffness_Nm_per_rad
from flankload.mechanisms.belt.contact import lands_in_words
from flankload.mechanisms.wrapped import Sites, slack_of, wrapped_result
from flankload.result.drives import BeltDrive
from flankload.result.pairs import PairDrawing, PairTable, PairTables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.contact import BeltState, SpringRow
    from flankload.mechanisms.belt.drive import BeltAssembly, BeltStates
    from flankload.result.result import Result
    from flankload.scene import Scene


UM_PER_MM = 1000.0


def result_of_belt(
    scene: Scene,
    assembly: BeltAssembly,
    states: BeltStates,
    number: int,
    estimate: Mapping[str, object] | None,
) -> Result:
    """Result of all positions under one torque.

    Parameters
    ----------
    number : int
        Index of the torque.
    """
    strip, found = assembly.strip, states.found[number]
    width, teeth = strip.width_mm, [state.tooth_N_per_mm.size for state in found]
    sites = Sites([state.first_tooth for state in found], teeth)
    drive = _drive(scene, strip, states.springs, sites, found)
    return wrapped_result(
        scene,
        assembly,
        number,
        sites,
        [width * state.tooth_N_per_mm for state in found],
        _warnings(scene, sites.numbers, drive),
        rotation_rad=np.array([state.rotation_rad for state in found]),
        reference_radius_mm=strip.pitch_radius_mm,
        stiffness_tangent_Nm_per_rad=tangent_stiffness(assembly, found),
        status=np.array([state.contact.status for state in found]),
        pair_tables=PairTables(len(found), partial(_pairs, found, width)),
        face_width_mm=width,
        estimate=estimate,
        cost=_cost(found),
        drawing=_drawing(strip, sites.numbers, assembly.position_rad),
        drive=drive,
    )


def tangent_stiffness(assembly: BeltAssembly, states: Sequence[BeltState]) -> Floats:
    """(P,) Tangent stiffness, N m/rad; NaN if nothing rotates."""
    compliance = np.array([state.compliance_rad_per_N for state in states])
    return stiffness_Nm_per_rad(compliance / assembly.strip.width_mm)


def _cost(states: Sequence[BeltState]) -> dict[str, object]:
    """Work of the states of one torque."""
    passes = [state.contact.info for state in states]
    return {
        "positions": len(states),
        "of_this_torque": {
            "states": len(states),
            "contact_passes": len(states),
            "influence_columns": sum(state.pair_N_per_mm.size for state in states),
            "pivots": sum(info.pivots for info in passes),
        },
        "degrees_of_freedom": states[0].degrees_of_freedom,
        "largest_backward_error": max(info.backward_error for info in passes),
        "largest_condition": max(info.condition for info in passes),
    }


def _drive(
    scene: Scene, strip: Strip, row: SpringRow, sites: Sites, states: Sequence[BeltState]
) -> BeltDrive:
    width = strip.width_mm
    slack = slack_of(scene)
    lands = [width * state.land_N_per_mm for state in states]
    lifts = [UM_PER_MM * state.land_lift_mm for state in states]
    friction_forces = [width * state.land_friction_N_per_mm for state in states]
    # tension removed by later teeth and lands; a land precedes its tooth
    behind = [
        slack + np.cumsum((width * state.tooth_N_per_mm + friction[1:])[::-1])[::-1]
        for state, friction in zip(states, friction_forces, strict=True)
    ]
    # NaN if the last land precedes a site
    last = np.array([state.first_land + state.land_N_per_mm.size - 1 for state in states])
    ends = np.where(last > sites.numbers[-1], 0.0, np.nan)
    return BeltDrive(
        wrap_angle_rad=strip.wrapped_teeth * strip.pitch_rad,
        tooth_stiffness_N_per_mm=width * row.tooth_N_per_mm2,
        cord_stiffness_N=width * row.cord_N_per_mm,
        prestress_N=width * strip.prestress_N_per_mm,
        land_friction=scene.effects.land_friction,
        tight_tension_N=np.array([width * state.tight_N_per_mm for state in states]),
        slack_tension_N=np.full(len(states), slack),
        land_friction_N=np.array([friction.sum() for friction in friction_forces]),
        last_land_N=ends + np.array([land[-1] for land in lands]),
        last_land_lift_um=ends + np.array([lift[-1] for lift in lifts]),
        tension_behind_N=sites.spread(behind),
        land_before_N=sites.spread(lands),
        land_lift_um=sites.spread(lifts),
        pulley_coupling_um_per_N=UM_PER_MM / width * row.coupling_mm2_per_N,
    )


def _warnings(scene: Scene, sites: Numbers, drive: BeltDrive) -> tuple[str, ...]:
    """Warn about fixed lands that would lift."""
    if scene.effects.land_lift or not drive.lifting.any():
        return ()
    at = np.flatnonzero(drive.lifting.any(axis=1))
    lands = lands_in_words(sites, np.asarray(drive.lifting.any(axis=0)))
    where = "" if len(drive.lifting) == 1 else f" at {at.size} of {len(drive.lifting)} positions"
    note = (
        f"the land lifts here: {lands} (of {sites[0]} to {sites[-1]}), where the pulley "
        f"would have to pull{where}; effects.land_lift = true lets it lift off, a higher slack "
        "tension holds it down"
    )
    return (note,)


def _pairs(states: Sequence[BeltState], width: float, p: int) -> PairTable:
    """Contact pairs of the flanks that carry load at a position."""
    state, flanks = states[p], states[p].flanks
    at = np.flatnonzero(state.pair_N_per_mm > 0.0)
    places, unknown = flanks.places[at], np.full(at.size, np.nan)
    return PairTable(
        site=flanks.tooth[at] + state.first_tooth,
        radius_mm=np.hypot(*places.T),
        arc_length_1_mm=unknown,
        arc_length_2_mm=unknown,
        x_mm=places[:, 0],
        y_mm=places[:, 1],
        normal_x=-flanks.normals[at, 0],
        normal_y=-flanks.normals[at, 1],
        force_N=width * state.pair_N_per_mm[at],
        pressure_MPa=state.pair_N_per_mm[at] / flanks.lengths_mm[at],
        gap_um=UM_PER_MM * state.pair_gap_mm[at],
        cell_mm=flanks.lengths_mm[at],
    )


def _drawing(strip: Strip, sites: Numbers, position_rad: Floats) -> PairDrawing:
    """One groove of the pulley and one pitch of the belt, with a groove's middle on the x axis."""
    assert strip.tooth is not None
    parts = np.linspace(0.0, 1.0, 13)
    mirror = np.array([1.0, -1.0])
    side, tip = strip.tooth.side(parts)[0], strip.tooth.tip(parts)
    tooth = np.concatenate([side, tip[1:-1], side[::-1] * mirror])
    tooth += np.array([strip.foot_radius_mm, 0.0])
    half = 0.5 * strip.pitch_rad
    foot = float(np.arctan2(-tooth[0, 1], tooth[0, 0]))
    lands = [
        strip.land_radius_mm * directions(turn)
        for turn in (np.linspace(-half, -foot, 5), np.linspace(foot, half, 5))
    ]
    groove = np.concatenate([lands[0], tooth[1:-1], lands[1]])
    back = strip.land_radius_mm + strip.back_mm
    outer = back * directions(np.linspace(half, -half, 13))
    first = strip.pitch_rad * (sites[0] + 0.5) + position_rad
    return PairDrawing(
        outline_1=groove,
        outline_2=np.concatenate([groove, outer]),
        teeth_1=strip.pulley_teeth,
        teeth_2=sites.size,
        center_distance_mm=0.0,
        angle_1=first,
        angle_2=first,
    )
