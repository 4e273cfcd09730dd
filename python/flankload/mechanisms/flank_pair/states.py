"""States of a flank pair at all positions, with tangents and the state without load."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from flankload.analysis.adaptive_positions import Window, sweep_adaptively
from flankload.analysis.tangent import with_tangents, with_unloaded
from flankload.contact.sweep import known_contacts
from flankload.cost import held_bytes
from flankload.errors import ContactError
from flankload.mechanisms.flank_pair.premises import blame_load
from flankload.mechanisms.flank_pair.stages import contact_of, swept
from flankload.result.geometry import pair_geometry
from flankload.scene.discretization import position_tolerance

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import numpy as np
    from numpy.typing import NDArray

    from flankload.analysis.adaptive_positions import PositionErrors
    from flankload.contact.sweep import FlankContact, Sweep
    from flankload.mechanisms.flank_pair.stages import Compliances
    from flankload.mechanisms.stage_clock import StageClock
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.geometry import PairGeometry
    from flankload.scene import Scene

    Run = Callable[..., tuple[Sweep, ...]]

#: A transmission error that varies by less than this part of the flank's length is roundoff.
LEAST_VARIATION = 1e-7


@dataclass(frozen=True)
class FlankStates:
    """States of a flank pair: one entry of `found` and of estimated position errors per torque.

    `rounds` is the number of sweeps in which adaptive positions (P,) were found; `geometry` is that
    at all positions, `contact` that of both bodies.
    """

    found: tuple[Sweep, ...]
    position_errors: tuple[PositionErrors | None, ...]
    rounds: int
    geometry: PairGeometry
    position_rad: NDArray[np.float64]
    contact: FlankContact


def flank_states(
    scene: Scene, pair: BodyPair, compliances: Compliances, clock: StageClock
) -> tuple[BodyPair, FlankStates]:
    """Sweep a flank pair under all torques; return also the pair at all positions.

    Raises
    ------
    ContactError
        If a position has no state; PremiseError if a part of the torque violates a premise.
    """
    contact = contact_of(scene, pair, compliances)
    with clock.stage("sweep") as account:
        run = partial(swept, contact, torques_Nmm=scene.torques_Nmm, account=account)
        try:
            pair, found, errors, rounds = _all_positions(scene, pair, run, clock)
        except ContactError as error:
            geometry = pair_geometry(pair, compliances)
            alone = partial(swept, contact, pair.position_rad)
            blame_load(scene, pair, geometry, error, lambda torque: alone([torque]))
            raise
        account.bytes += held_bytes(found)
    again = partial(swept, contact, pair.position_rad, keep_pairs=False)
    if scene.accuracy.tangents and not pair.effects.lumped_contact:
        # the equations of a lumped contact include its tangent
        with clock.stage("tangent") as account:
            progress = clock.sweep_progress("tangent")
            found = with_tangents(found, partial(again, account=account, progress=progress))
    with clock.account("result") as account:
        found = with_unloaded(found, partial(again, account=account))
    for name in ("states", "slices"):  # those are of positions under a torque
        account.counters.pop(name, None)
    geometry = pair_geometry(pair, compliances)
    return pair, FlankStates(found, errors, rounds, geometry, pair.position_rad, contact)


def continued_states(
    scene: Scene, pair: BodyPair, compliances: Compliances, clock: StageClock, similar: FlankStates
) -> tuple[BodyPair, FlankStates]:
    """As `flank_states`, from those of a solved pair that differs by a small step; no tangents."""
    pair = replace(pair, position_rad=similar.position_rad, adaptive=False)
    contact = contact_of(scene, pair, compliances)
    run = partial(swept, contact, pair.position_rad)
    with clock.stage("sweep") as account:
        known = known_contacts(similar.found)
        found = run(scene.torques_Nmm, known=known, account=account)
    with clock.account("result") as account:
        found = with_unloaded(found, partial(run, keep_pairs=False, account=account))
    geometry, none = pair_geometry(pair, compliances), (None,) * len(found)
    return pair, FlankStates(found, none, 1, geometry, similar.position_rad, contact)


def _all_positions(
    scene: Scene, pair: BodyPair, run: Run, clock: StageClock
) -> tuple[BodyPair, tuple[Sweep, ...], tuple[PositionErrors | None, ...], int]:
    """The pair at all positions, the states, the estimated position errors, the rounds."""
    if not pair.adaptive:
        found = run(position_rad=pair.position_rad, progress=clock.sweep_progress("sweep"))
        return pair, found, (None,) * len(found), 1

    def run_round(position_rad: NDArray[np.float64], number: int) -> tuple[Sweep, ...]:
        return run(position_rad=position_rad, progress=clock.sweep_progress("sweep", number=number))

    window = window_of(pair)
    adapted = sweep_adaptively(
        run_round,
        pair.position_rad,
        window,
        tolerance=position_tolerance(scene),
        most=scene.positions.most_per_pitch * window.pitches,
        least_rad=LEAST_VARIATION * pair.body_1.curve.length_mm / pair.body_1.reference_radius_mm,
    )
    pair = replace(pair, position_rad=adapted.position_rad)
    return pair, adapted.found, adapted.errors, adapted.rounds


def window_of(pair: BodyPair) -> Window:
    """Range of tooth pitches that the positions cover, which are not single angles."""
    assert pair.pitches is not None
    pairing = pair.pairing
    return Window(
        pitch_rad=pairing.pitch_rad,
        pitches=pair.pitches,
        closed=pair.closed,
        sites=pairing.sites,
        # the single flank of a cam is its own neighbour
        whole_circle=pairing.whole_circle or pairing.motion is not None,
    )


def position_notes(scene: Scene, pair: BodyPair, error: PositionErrors | None) -> Iterator[str]:
    """Warnings about adaptive positions whose estimated error exceeds the tolerance."""
    tolerance = position_tolerance(scene)
    if error is not None and error.largest > tolerance:
        yield (
            f"{pair.position_rad.size} positions are too few for a tolerance of {tolerance:g}: "
            f"harmonics are in doubt by {100 * error.harmonics:.2g} %, the peak to peak by "
            f"{100 * error.peak_to_peak:.2g} % (positions.max_count, positions.tolerance)"
        )
