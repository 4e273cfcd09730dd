"""The conductor of a timing belt on its pulley: elements once, a contact problem for each torque.

All positions at which the strands meet the belt between two teeth are alike: one is computed.
"""

from __future__ import annotations

from math import ceil, degrees
from typing import TYPE_CHECKING

import numpy as np

from flankload.belt_contact import BeltState, solve_belt, spring_row
from flankload.belt_result import result_of_belt
from flankload.belt_strip import StripResponse, solve_strip
from flankload.bodies.belt import Strip, build_strip
from flankload.bodies.belt_mesh import FLANK_ELEMENTS, BeltMesh, mesh_strip
from flankload.cost import Account, held_bytes
from flankload.errors import ContactError, NoContactState

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.result import Result
    from flankload.scene import Scene

#: Fewer elements on a flank are too few for a pressure that changes along it.
LEAST_ELEMENTS = 2


def solve_belts(
    scene: Scene, progress: Callable[[str, int, int], None] | None = None
) -> tuple[Result, ...]:
    """Forces of a timing belt on its pulley.

    Parameters
    ----------
    scene : Scene
        With a pulley and a belt.
    progress : callable, optional
        As for `solve`.

    Returns
    -------
    tuple of Result, one per torque

    Raises
    ------
    NoContactState
        If the belt has no state under a torque.
    """
    tell = progress if progress is not None else (lambda stage, done, total: None)
    torques = scene.torques_Nm
    total = 3 + len(torques)
    stages: dict[str, Account] = {}

    def stage(name: str, done: int) -> Account:
        tell(name, done, total)
        return stages.setdefault(name, Account())

    with stage("bodies", 0) as account:
        strip = strip_of(scene)
        mesh = mesh_strip(strip, flank_elements(scene, strip))
        account.bytes = held_bytes(mesh)
    with stage("compliance body 2", 1) as account:
        response = _response(scene, strip, mesh, account)
        row = spring_row(strip, response)
        account.bytes = held_bytes(response)
    states = []
    with stage("sweep", 2) as account:
        for t, torque in enumerate(torques):
            tell("sweep", 2 + t, total)
            states.append(_state(scene, strip, response, torque, account))
        account.bytes = held_bytes(states)
    estimates: list[dict[str, object] | None] = [None] * len(states)
    if scene.accuracy.estimate and any(torques):
        with stage("estimate", 2 + len(torques)) as account:
            estimates = _estimates(scene, strip, states, account)
    results = tuple(
        result_of_belt(scene, strip, mesh, (response, row), state, torque, stages, estimate)
        for torque, state, estimate in zip(torques, states, estimates, strict=True)
    )
    tell("done", total, total)
    return results


def strip_of(scene: Scene) -> Strip:
    """Belt and pulley of a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Strip
    """
    from flankload.scene import Belt, Pulley

    assert isinstance(scene.body_1, Pulley)
    assert isinstance(scene.body_2, Belt)
    return build_strip(scene.body_1, scene.body_2)


def flank_elements(scene: Scene, strip: Strip) -> int:
    """Elements on the flank of a tooth.

    Parameters
    ----------
    scene : Scene
    strip : Strip

    Returns
    -------
    int
    """
    size = scene.accuracy.flank_element_mm
    if size is None or strip.tooth is None:
        return FLANK_ELEMENTS
    return max(LEAST_ELEMENTS, ceil(strip.tooth.height_mm / size - 1e-9))


def describe_belt(scene: Scene) -> dict[str, list[tuple[str, str]]]:
    """What `flankload check` says of a pulley and its belt.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    dict of str to list of (str, str)
        Name and value of each row, by title.
    """
    strip = strip_of(scene)
    mesh = mesh_strip(strip, flank_elements(scene, strip))
    slack = scene.load.slack_tension_N or 0.0
    tight = 1000.0 * np.array(scene.torques_Nm) / strip.pitch_radius_mm + slack
    mean = 0.5 * (tight.max() + slack)
    said = f"{strip.prestress_N_per_mm * strip.width_mm:g} N (half of both tensions: {mean:.4g} N)"
    clearance = 1000.0 * strip.clearance_rad * strip.pitch_radius_mm
    effects = scene.effects
    return {
        "body_1: pulley": [
            ("teeth", f"{strip.pulley_teeth}"),
            ("pitch diameter", f"{2 * strip.pitch_radius_mm:.4f} mm"),
            ("outer diameter", f"{2 * strip.land_radius_mm:.4f} mm"),
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


def _response(scene: Scene, strip: Strip, mesh: BeltMesh, account: Account) -> StripResponse:
    return solve_strip(
        strip,
        mesh,
        rubbing=scene.effects.land_friction != 0.0,
        lifting=scene.effects.land_lift,
        account=account,
    )


def _state(
    scene: Scene, strip: Strip, response: StripResponse, torque_Nm: float, account: Account
) -> BeltState:
    slack = scene.load.slack_tension_N
    assert slack is not None
    try:
        state = solve_belt(
            strip,
            response,
            1000.0 * torque_Nm / (strip.pitch_radius_mm * strip.width_mm),
            slack / strip.width_mm,
            land_friction=scene.effects.land_friction,
            land_lift=scene.effects.land_lift,
        )
    except ContactError as error:
        text = f"{torque_Nm:g} N m, slack strand {slack:g} N: {error}"
        raise NoContactState(text) from error
    account.count(
        states=1,
        contact_passes=1,
        influence_columns=state.pair_N_per_mm.size,
        pivots=state.contact.info.pivots,
    )
    return state


def _estimates(
    scene: Scene, strip: Strip, states: list[BeltState], account: Account
) -> list[dict[str, object] | None]:
    """What elements twice as long change: at sharp corners errors fall about as elements do."""
    coarse = mesh_strip(strip, max(1, flank_elements(scene, strip) // 2))
    response = _response(scene, strip, coarse, account)
    found: list[dict[str, object] | None] = []
    for torque, state in zip(scene.torques_Nm, states, strict=True):
        whole = state.tooth_N_per_mm.sum()
        if whole <= 0.0:
            found.append(None)
            continue
        other = _state(scene, strip, response, torque, account)
        left = {
            "transmission_error": abs(other.rotation_rad / state.rotation_rad - 1.0),
            "load_share": float(np.abs(other.tooth_N_per_mm - state.tooth_N_per_mm).max() / whole),
        }
        found.append({**left, "by_source": {"elements": left}})
    return found
