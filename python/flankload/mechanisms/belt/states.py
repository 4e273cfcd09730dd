"""State of a belt in a scene, or the reason why none exists."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import ContactError, NoContactState
from flankload.mechanisms.belt.contact import BeltState, contact_problem, solve_belt
from flankload.mechanisms.wrapped import Sites

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flankload.cost import Account
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.row import StripResponse
    from flankload.scene import Scene

#: Number of halvings and doublings in the search for the slack tension at which a belt jumps.
STEPS = 20


def state_under(
    scene: Scene, strip: Strip, response: StripResponse, torque_Nm: float, account: Account
) -> BeltState:
    """State of a belt under a torque.

    Parameters
    ----------
    response : StripResponse
        With the columns of sliding and lifting lands, if the scene needs them.
    account : Account
        Account in which the work is counted.

    Raises
    ------
    NoContactState
        If none exists: friction on the lands turns the pulley further than the torque, or the belt
        jumps.
    """
    slack = scene.load.slack_tension_N
    assert slack is not None
    where = f"{torque_Nm:g} N m, slack strand {slack:g} N"
    try:
        state = _solved(scene, strip, response, torque_Nm, slack)
    except ContactError as error:
        friction, width = scene.effects.land_friction, strip.width_mm
        # the torque of a problem without load is that of the lands under the slack tension
        unloaded = contact_problem(strip, response, 0.0, slack / width, friction)
        alone = -1e-3 * width * unloaded.torque
        if alone > torque_Nm:
            raise NoContactState(
                f"{where}: lands that all slide with effects.land_friction = {friction:g} "
                f"carry {alone:.4g} N m without any tooth, more than the torque: they stick"
            ) from error
        raise NoContactState(f"{where}: {error}") from error
    account.count(
        states=1,
        contact_passes=1,
        influence_columns=state.pair_N_per_mm.size,
        pivots=state.contact.info.pivots,
    )
    if _jumps(strip, state):
        most = np.arange(response.lands) == state.land_lift_mm.argmax()
        land = lands_in_words(response.first_tooth + np.arange(response.teeth), most)
        raise NoContactState(
            f"{where}: the land {land} lifts {state.land_lift_mm.max():.3g} mm, more than teeth "
            "are high; belts of this wrap jump below a slack tension of about "
            f"{_jump_tension(scene, strip, response, torque_Nm, slack):.3g} N"
        )
    return state


def sites_of(states: Sequence[BeltState]) -> Sites:
    """Teeth at the positions of some states."""
    return Sites(
        [state.first_tooth for state in states], [state.tooth_N_per_mm.size for state in states]
    )


def lands_in_words(sites: NDArray[np.int64], some: NDArray[np.bool_]) -> str:
    """Names of some of the lands by their teeth: one before each, and one behind the last.

    Parameters
    ----------
    sites : (S,) array
        Numbers of the teeth.
    some : (S + 1,) array of bool
        Selected lands, from the tight strand.
    """
    before = ", ".join(str(site) for site in sites[some[:-1]])
    words = [f"before tooth {before}"] if before else []
    return " and ".join(words + [f"behind tooth {sites[-1]}"] * bool(some[-1]))


def _solved(
    scene: Scene, strip: Strip, response: StripResponse, torque_Nm: float, slack_N: float
) -> BeltState:
    return solve_belt(
        strip,
        response,
        1000.0 * torque_Nm / (strip.pitch_radius_mm * strip.width_mm),
        slack_N / strip.width_mm,
        land_friction=scene.effects.land_friction,
        land_lift=scene.effects.land_lift,
    )


def _jumps(strip: Strip, state: BeltState) -> bool:
    """Whether the lift of a land exceeds the height of a tooth."""
    return strip.tooth is not None and state.land_lift_mm.max() > strip.tooth.height_mm


def _jump_tension(
    scene: Scene, strip: Strip, response: StripResponse, torque_Nm: float, slack_N: float
) -> float:
    """Slack tension (N) below which a belt jumps that jumps at the given one."""
    low, high = slack_N, 2.0 * slack_N
    for _ in range(STEPS):
        if not _jumps(strip, _solved(scene, strip, response, torque_Nm, high)):
            break
        low, high = high, 2.0 * high
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        if _jumps(strip, _solved(scene, strip, response, torque_Nm, middle)):
            low = middle
        else:
            high = middle
    return high
