"""From the state of a belt to its result: tensions, lands, warnings, a drawing."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.cost import Account, totals
from flankload.result.belt import BeltDrive
from flankload.result.pairs import PairDrawing, PairTable, PairTables
from flankload.result.result import Result, make_result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.belt_contact import BeltState, SpringRow
    from flankload.belt_strip import StripResponse
    from flankload.bodies.belt import Strip
    from flankload.bodies.belt_mesh import BeltMesh
    from flankload.scene import Scene

    Floats = NDArray[np.float64]

UM_PER_MM = 1000.0


def result_of_belt(
    scene: Scene,
    strip: Strip,
    mesh: BeltMesh,
    known: tuple[StripResponse, SpringRow],
    state: BeltState,
    torque_Nm: float,
    stages: dict[str, Account],
    estimate: dict[str, object] | None,
) -> Result:
    """The state under one torque as a result.

    Parameters
    ----------
    scene : Scene
    strip : Strip
    mesh : BeltMesh
    known : StripResponse and SpringRow
        Of the strip.
    state : BeltState
    torque_Nm : float
    stages : dict of str to Account
        What the run has spent.
    estimate : dict or None
        Error estimates, as the result shows them.

    Returns
    -------
    Result
    """
    response, row = known
    width = strip.width_mm
    force = width * state.tooth_N_per_mm[None]
    drive = _drive(scene, strip, row, state)
    passes = state.contact.info
    predicted: dict[str, Any] = {
        "compliance body 2": {"counters": {"fe_factorisations": 1}},
        "sweep": {"counters": {"states": len(scene.torques_Nm)}},
    }
    result = make_result(
        name=scene.name,
        torque_Nm=torque_Nm,
        sites=np.arange(strip.wrapped_teeth),
        position_rad=np.zeros(1),
        rotation_rad=np.array([state.rotation_rad]),
        reference_radius_mm=strip.pitch_radius_mm,
        site_force_N=force,
        peak_pressure_MPa=np.zeros_like(force),
        stiffness_tangent_Nm_per_rad=np.array([_stiffness(state, width)]),
        status=np.array([state.contact.status]),
        pair_tables=PairTables(1, partial(_pairs, response, state, width)),
        corner_contact=np.zeros(force.shape, dtype=bool),
        pitch_rad=strip.pitch_rad,
        period_rad=strip.pitch_rad,
        closed=False,
        face_width_mm=width,
        estimate=estimate,
        cost={
            **totals(stages),
            "positions": 1,
            "of_this_torque": {
                "states": 1,
                "contact_passes": 1,
                "influence_columns": state.pair_N_per_mm.size,
                "pivots": passes.pivots,
            },
            "degrees_of_freedom": response.degrees_of_freedom,
            "largest_backward_error": passes.backward_error,
            "largest_condition": passes.condition,
            "bytes": sum(account.bytes for account in stages.values()),
            "stages": {
                name: account.as_dict() | {"predicted": predicted.get(name, {})}
                for name, account in stages.items()
            },
        },
        warnings=_warnings(scene, drive),
        drawing=_drawing(strip, mesh),
    )
    return replace(result, drive=drive)


def _stiffness(state: BeltState, width: float) -> float:
    """N m/rad; none where nothing turns."""
    compliance = state.compliance_rad_per_N
    return 1e-3 * width / compliance if compliance > 0.0 else np.nan


def _drive(scene: Scene, strip: Strip, row: SpringRow, state: BeltState) -> BeltDrive:
    width = strip.width_mm
    slack = scene.load.slack_tension_N
    assert slack is not None
    # what teeth and lands further on take off the cord; a land stands before its tooth
    tooth, rub = width * state.tooth_N_per_mm, width * state.land_rub_N_per_mm
    behind = slack + np.cumsum((tooth + rub[1:])[::-1])[::-1]
    land, lift = width * state.land_N_per_mm, UM_PER_MM * state.land_lift_mm
    return BeltDrive(
        wrap_angle_rad=strip.wrapped_teeth * strip.pitch_rad,
        tooth_stiffness_N_per_mm=width * row.tooth_N_per_mm2,
        cord_stiffness_N=width * row.cord_N_per_mm,
        prestress_N=width * strip.prestress_N_per_mm,
        land_friction=scene.effects.land_friction,
        tight_tension_N=np.array([width * state.tight_N_per_mm]),
        slack_tension_N=np.array([slack]),
        land_friction_N=np.array([rub.sum()]),
        last_land_N=land[-1:],
        last_land_lift_um=lift[-1:],
        tension_behind_N=behind[None],
        land_before_N=land[None, :-1],
        land_lift_um=lift[None, :-1],
    )


def _warnings(scene: Scene, drive: BeltDrive) -> tuple[str, ...]:
    """Lands that are held and would lift."""
    if scene.effects.land_lift or not drive.lifting.any():
        return ()
    lands = ", ".join(str(land) for land in np.flatnonzero(drive.lifting[0]))
    note = (
        f"the land lifts here: before tooth {lands} (of {drive.land_before_N.shape[1]}) the pulley "
        "would have to pull; effects.land_lift = true lets it go, more slack tension holds it down"
    )
    return (note,)


def _pairs(response: StripResponse, state: BeltState, width: float, _: int) -> PairTable:
    """Parts of the flanks that carry."""
    flanks = response.flanks
    at = np.flatnonzero(state.pair_N_per_mm > 0.0)
    places, unknown = flanks.places[at], np.full(at.size, np.nan)
    return PairTable(
        site=flanks.tooth[at],
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


def _drawing(strip: Strip, mesh: BeltMesh) -> PairDrawing:
    """One groove of the pulley and one pitch of the belt, a groove's middle on the x axis."""
    assert strip.tooth is not None
    parts = np.linspace(0.0, 1.0, 13)
    mirror = np.array([1.0, -1.0])
    side, tip = strip.tooth.side(parts)[0], strip.tooth.tip(parts)
    tooth = np.concatenate([side, tip[1:-1], side[::-1] * mirror])
    tooth += np.array([strip.foot_radius_mm, 0.0])
    half = 0.5 * strip.pitch_rad
    foot = float(np.arctan2(-tooth[0, 1], tooth[0, 0]))
    lands = [
        strip.land_radius_mm * np.column_stack([np.cos(turn), np.sin(turn)])
        for turn in (np.linspace(-half, -foot, 5), np.linspace(foot, half, 5))
    ]
    groove = np.concatenate([lands[0], tooth[1:-1], lands[1]])
    back = strip.land_radius_mm + strip.back_mm
    turn = np.linspace(half, -half, 13)
    outer = back * np.column_stack([np.cos(turn), np.sin(turn)])
    return PairDrawing(
        outline_1=groove,
        outline_2=np.concatenate([groove, outer]),
        teeth_1=strip.pulley_teeth,
        teeth_2=strip.wrapped_teeth,
        center_distance_mm=0.0,
        angle_1=strip.tooth_angles_rad[:1],
        angle_2=strip.tooth_angles_rad[:1],
    )
