"""Assembly and states of a chain on its sprocket.

Pockets are planes and the chain is a truss, so no finite elements are solved.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.torque import in_newton_metres
from flankload.errors import ContactError, NoContactState, SceneError
from flankload.mechanisms.chain.contact import CONVERGED, WrapState, solve_wrap, work_of
from flankload.mechanisms.chain.sprocket import Sprocket, build_sprocket
from flankload.mechanisms.chain.wrap import Chain, Wrap, wrap_at
from flankload.mechanisms.parameters import Parameters, named
from flankload.mechanisms.scene_bodies import with_file_of
from flankload.mechanisms.wrapped import WrappedAssembly, positions_of, slack_of

if TYPE_CHECKING:
    from flankload.cost import Account
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import Scene

#: Length of the free strands in pitches if a scene does not name one.
SPAN_PITCHES = 40.0
#: Contact problems of a linear state: for the state, and for its stiffness.
LINEAR_PASSES = 2
#: Least tension of a link, relative to the tight tension: roundoff of a slack link.
LEAST_TENSION = -1e-6


@dataclass(frozen=True)
class ChainAssembly(WrappedAssembly):
    """A chain on its sprocket.

    Attributes
    ----------
    wraps : list of Wrap
        One entry per position.
    """

    sprocket: Sprocket
    chain: Chain
    wrap_angle_rad: float
    wraps: list[Wrap]

    @property
    def pitch_rad(self) -> float:
        """Angle between adjacent teeth."""
        return self.sprocket.pitch_rad


def assemble(scene: Scene) -> ChainAssembly:
    """Sprocket, chain and positions of a scene; a SceneError if the rollers do not fit."""
    sprocket, chain, wrap_angle = build_drive(scene)
    position_rad, pitches = positions_of(scene, sprocket.pitch_rad)
    wraps = [wrap_at(sprocket, wrap_angle, float(angle)) for angle in position_rad]
    return ChainAssembly(position_rad, pitches, sprocket, chain, wrap_angle, wraps)


def predicted_work(scene: Scene, assembly: ChainAssembly) -> dict[str, dict[str, int]]:
    """Known counters of a run by stages; the number of passes of an iteration is unknown."""
    counted = {"states": len(assembly.wraps) * len(scene.torques_Nm)}
    if not scene.effects.large_displacement:
        counted["contact_passes"] = LINEAR_PASSES * counted["states"]
    none: dict[str, dict[str, int]] = {"estimate": {}} if scene.accuracy.estimate else {}
    return {"bodies": {}, "sweep": counted, **none}


def parameters_of_chain(scene: Scene, parts: Parts | None = None) -> Parameters:
    """Discretization parameters of a scene: none, since links and pockets have no elements."""
    fixed = named(scene)
    fixed.setdefault("positions", "equally spaced positions suffice")
    return Parameters({}, fixed, {}, {}, has_pressures=False)


def error_estimate(
    scene: Scene,
    assembly: ChainAssembly,
    states: list[WrapState],
    torque_Nmm: float,
    account: Account,
) -> dict[str, object]:
    """Error of one linear state, from an iteration at two positions, in the form of the result.

    The error of the iteration is its tolerance. Its work is counted.
    """
    if scene.effects.large_displacement:
        left = {"transmission_error": CONVERGED, "load_share": CONVERGED}
        return {**left, "by_source": {"passes": left}}
    turn, share = 0.0, 0.0
    scale = max(abs(state.rotation_rad) for state in states)
    for p in sorted({0, len(states) // 2}):
        other = solve_wrap(
            assembly.wraps[p],
            assembly.chain,
            torque_Nmm,
            slack_of(scene),
            large_displacement=True,
            with_compliance=False,
        )
        account.count(**work_of([other]))
        turn = max(turn, abs(other.rotation_rad - states[p].rotation_rad) / scale)
        one, two = (np.hypot(*state.force_N.T) for state in (states[p], other))
        share = max(share, float(np.abs(one / one.sum() - two / two.sum()).max()))
    found = {"transmission_error": turn, "load_share": share}
    return {**found, "by_source": {"one solution": found}}


def build_drive(scene: Scene) -> tuple[Sprocket, Chain, float]:
    """Sprocket, chain and wrap angle (rad) of a scene.

    Raises SceneError if the rollers do not fit.
    """
    from flankload.scene import Chain as ChainKeys
    from flankload.scene import Sprocket as SprocketKeys

    spec_1, spec_2 = scene.body_1, scene.body_2
    assert isinstance(spec_1, SprocketKeys)
    assert isinstance(spec_2, ChainKeys)
    try:
        sprocket = build_sprocket(spec_1, "body_1")
    except SceneError as error:
        raise with_file_of(scene, error) from None
    chain = Chain(
        pitch_mm=spec_2.pitch_mm,
        elongation=spec_2.elongation,
        link_stiffness_N=spec_2.link_stiffness_N,
        contact_stiffness_N_per_mm=spec_2.contact_stiffness_N_per_mm,
        span_mm=spec_2.span_length_mm or SPAN_PITCHES * spec_2.pitch_mm,
    )
    return sprocket, chain, radians(spec_2.wrap_angle_deg)


def solve_position(scene: Scene, assembly: ChainAssembly, torque_Nmm: float, p: int) -> WrapState:
    """State of a position.

    Raises NoContactState if there is none; the message names the tension below which the chain
    jumps.
    """
    slack = slack_of(scene)
    wrap, large = assembly.wraps[p], scene.effects.large_displacement
    one, two = wrap.levers_mm
    tight = (torque_Nmm + slack * two) / one
    limit = float(wrap.sprocket.jump_tension(np.array(tight), assembly.wrap_angle_rad))
    where = f"position {p} at {in_newton_metres(torque_Nmm):g} N m"
    needed = f"this chain jumps below a slack tension of about {limit:.3g} N"
    try:
        state = solve_wrap(wrap, assembly.chain, torque_Nmm, slack, large_displacement=large)
    except ContactError as error:
        raise NoContactState(f"{where}: {error}; {needed}, it is {slack:g} N") from error
    if not large:
        return state
    highest = float(state.place_mm[:, 1].max())
    if highest > wrap.sprocket.highest_roller_mm:
        raise NoContactState(
            f"{where}: a roller climbs {highest:.3g} mm, over the tip of its tooth "
            f"({wrap.sprocket.highest_roller_mm:.3g} mm); {needed}, it is {slack:g} N"
        )
    if state.moves_mm > 0.0:
        raise NoContactState(
            f"{where}: after {state.passes} passes rollers still move by {state.moves_mm:.2g} mm; "
            f"{needed}, it is {slack:g} N"
        )
    if state.tension_N.min() < LEAST_TENSION * state.tension_N.max():
        raise NoContactState(f"{where}: links would have to push; {needed}, it is {slack:g} N")
    return state
