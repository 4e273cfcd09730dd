"""Conversion of the states of a chain to its result: tensions, places, margins, drawing."""

from __future__ import annotations

from functools import partial
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.base.torque import stiffness_Nm_per_rad
from flankload.mechanisms.chain.contact import WrapState, work_of
from flankload.mechanisms.chain.wrap import in_world
from flankload.mechanisms.wrapped import Sites, wrapped_result
from flankload.result.drives import ChainDrive
from flankload.result.pairs import PairDrawing, PairTable, PairTables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.base.arrays import Floats
    from flankload.mechanisms.chain.drive import ChainAssembly
    from flankload.mechanisms.chain.sprocket import Sprocket
    from flankload.mechanisms.chain.wrap import Chain, Wrap
    from flankload.mechanisms.wrapped import WrappedStates
    from flankload.result.result import Result
    from flankload.scene import Scene

#: Up to this wear the error of a linear state is about 1 % of the tight tension.
LINEAR_WEAR = 0.01


def result_of_chain(
    scene: Scene,
    assembly: ChainAssembly,
    states: WrappedStates,
    number: int,
    estimate: Mapping[str, object] | None,
) -> Result:
    """Result of all positions under one torque.

    Parameters
    ----------
    number : int
        Index of the torque.
    """
    wraps, sprocket, found = assembly.wraps, assembly.sprocket, states.found[number]
    sites = Sites([wrap.first for wrap in wraps], [wrap.angles_rad.size for wrap in wraps])
    drive = _drive(scene, assembly, sites, found)
    return wrapped_result(
        scene,
        assembly,
        number,
        sites,
        [np.hypot(*state.force_N.T) for state in found],
        _warnings(assembly.chain, sprocket, drive),
        rotation_rad=np.array([state.rotation_rad for state in found]),
        reference_radius_mm=sprocket.pitch_radius_mm,
        stiffness_tangent_Nm_per_rad=tangent_stiffness(assembly, found),
        status=np.array([state.status for state in found]),
        pair_tables=PairTables(len(wraps), partial(_rollers, wraps, found)),
        face_width_mm=scene.pair.face_width_mm,
        estimate=estimate,
        cost={
            "positions": len(wraps),
            "of_this_torque": work_of(found),
            "largest_backward_error": max(state.backward_error for state in found),
            "largest_condition": max(state.condition for state in found),
        },
        drawing=_drawing(sprocket, wraps),
        drive=drive,
    )


def _drive(
    scene: Scene, assembly: ChainAssembly, sites: Sites, states: Sequence[WrapState]
) -> ChainDrive:
    tight, slack = np.array([state.tension_N[[0, -1]] for state in states]).T
    angle, sprocket = assembly.wrap_angle_rad, assembly.sprocket
    return ChainDrive(
        mode="large displacement" if scene.effects.large_displacement else "linear",
        wrap_angle_rad=angle,
        tension_ratio=sprocket.tension_ratio,
        tight_tension_N=tight,
        slack_tension_N=slack,
        jump_margin_N=slack - sprocket.jump_tension(tight, angle),
        passes=np.array([state.passes for state in states]),
        tension_behind_N=sites.spread([state.tension_N[:-1] for state in states]),
        roller_height_um=sites.spread([1000.0 * state.place_mm[:, 1] for state in states]),
        force_angle_deg=sites.spread([_force_angles_deg(state) for state in states]),
    )


def _force_angles_deg(state: WrapState) -> Floats:
    """(n,) Angles of the forces from the outward direction; NaN without force."""
    angles = np.degrees(np.arctan2(*state.force_N.T))
    return np.where(np.hypot(*state.force_N.T) > 0, angles, np.nan)


def tangent_stiffness(assembly: ChainAssembly, states: Sequence[WrapState]) -> Floats:
    """(P,) Tangent stiffness, N m/rad."""
    return stiffness_Nm_per_rad(np.array([state.compliance_rad_per_Nmm for state in states]))


def _warnings(chain: Chain, sprocket: Sprocket, drive: ChainDrive) -> tuple[str, ...]:
    """Warn if one linear state is not sufficient, and if the chain may jump."""
    notes = []
    climbs = float(np.nanmax(drive.roller_height_um)) / 1000.0
    if drive.mode == "linear" and chain.elongation > LINEAR_WEAR:
        notes.append(
            f"wear of {100 * chain.elongation:g} %: beyond {100 * LINEAR_WEAR:g} % one linear "
            "solution is off by more than 1 % of the tight tension; effects.large_displacement = "
            "true follows the rollers"
        )
    elif drive.mode == "linear" and climbs > sprocket.highest_roller_mm:
        notes.append(
            f"a roller would climb {climbs:.3g} mm, over the tip of its tooth: "
            "effects.large_displacement = true follows it"
        )
    if drive.least_margin_N < 0:
        notes.append(
            f"the slack strand pulls {-drive.least_margin_N:.3g} N less than T1 q^n: a worn chain "
            "would climb over the teeth"
        )
    return tuple(notes)


def _rollers(wraps: Sequence[Wrap], states: Sequence[WrapState], p: int) -> PairTable:
    """Rollers that carry load at a position, each as one contact pair."""
    wrap, state = wraps[p], states[p]
    force = np.hypot(*state.force_N.T)
    at = np.flatnonzero(force > 0)
    polar = wrap.angles_rad[at] + state.rotation_rad
    normal = in_world(state.force_N[at], polar) / force[at, None]
    point = in_world(state.place_mm[at] + [0.0, wrap.sprocket.pitch_radius_mm], polar)
    point = point - 0.5 * wrap.sprocket.roller_diameter_mm * normal
    unknown = np.full(at.size, np.nan)
    return PairTable(
        site=wrap.first + at,
        radius_mm=np.hypot(*point.T),
        arc_length_1_mm=unknown,
        arc_length_2_mm=unknown,
        x_mm=point[:, 0],
        y_mm=point[:, 1],
        normal_x=normal[:, 0],
        normal_y=normal[:, 1],
        force_N=force[at],
        pressure_MPa=unknown,
        gap_um=np.zeros(at.size),
        cell_mm=unknown,
        half_width_mm=unknown,
    )


def _drawing(sprocket: Sprocket, wraps: Sequence[Wrap]) -> PairDrawing:
    half = 0.5 * sprocket.roller_diameter_mm
    return PairDrawing(
        outline_1=sprocket.outline(),
        outline_2=half * directions(np.linspace(0.0, 2 * pi, 49)),
        teeth_1=sprocket.teeth,
        teeth_2=1,
        center_distance_mm=0.0,
        angle_1=np.array([wrap.angles_rad[0] for wrap in wraps]),
        angle_2=np.zeros(len(wraps)),
    )
