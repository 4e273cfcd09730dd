"""States of a flank pair at all positions, with tangents, the state without load and errors."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.analysis.adaptive_positions import Window, sweep_adaptively
from flankload.analysis.deciding_positions import deciding_positions, n_deciding
from flankload.analysis.estimate import estimate_errors
from flankload.analysis.lumped_error import error_beside_cells, spread_error, worst_beside
from flankload.analysis.more_positions import beside_more_positions, more_positions, with_known
from flankload.analysis.period_error import OtherTeeth, of_other_teeth
from flankload.analysis.root_error import root_tension
from flankload.analysis.sampling_error import between_positions
from flankload.base.number_text import percent
from flankload.bodies.imported.compliance import ModalCompliance
from flankload.contact.status import on_corner
from flankload.contact.sweep import join_sweeps, known_contacts, sweep
from flankload.cost import Account, held_bytes
from flankload.errors import ContactError
from flankload.mechanisms.elements import account_errors_of_elements, variants_of
from flankload.mechanisms.flank_pair.assembly import build_bodies, with_flank_distance
from flankload.mechanisms.flank_pair.from_sweep import pair_tables
from flankload.mechanisms.flank_pair.premises import blame_load
from flankload.mechanisms.flank_pair.stages import compliances_of, contact_of
from flankload.mechanisms.scene_bodies import PAIR
from flankload.mechanisms.stage_clock import StageClock
from flankload.result.geometry import pair_geometry
from flankload.result.position_order import order_of
from flankload.scene.discretization import position_tolerance

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from numpy.typing import NDArray

    from flankload.analysis.adaptive_positions import PositionErrors
    from flankload.analysis.error_rules import RemainingError
    from flankload.base.arrays import Floats
    from flankload.contact.core_call import KnownContacts
    from flankload.contact.flank_contact import FlankContact
    from flankload.contact.sweep import Sweep
    from flankload.mechanisms.flank_pair.stages import Compliances
    from flankload.mechanisms.protocol import States
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.geometry import PairGeometry
    from flankload.scene import Scene

    Run = Callable[..., tuple[Sweep, ...]]

#: Least variation of the transmission error above roundoff, relative to the flank's length.
LEAST_VARIATION = 1e-7
#: Largest error of the rotation if forces do not turn over a sharp tip (FZG type C pair).
LARGEST_TURN = 0.007
#: Reasons why forces on a body from a compliance file do not turn, and remedies.
WITHOUT_SMOOTH_NT = (
    "files of earlier versions have no response to loads along the flank (smooth_nt)",
    "; flankload compliance writes a file that has it",
)
BETWEEN_NODES = ("a matrix between nodes has no response to loads along the flank", "")


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

    @cached_property
    def known(self) -> KnownContacts | None:
        """Pairs in contact, from which similar states are continued."""
        return known_contacts(self.found)


def flank_states(
    scene: Scene,
    pair: BodyPair,
    compliances: Compliances,
    clock: StageClock,
    similar: States | None = None,
    *,
    unloaded: bool = True,
) -> tuple[BodyPair, FlankStates]:
    """Sweep a flank pair under all torques; return also the pair at all positions.

    The states of a `similar` pair are continued, with its positions and without tangents.

    Raises
    ------
    ContactError
        If a position has no state; PremiseError if a part of the torque violates a premise.
    """
    if similar is not None:
        assert isinstance(similar, FlankStates)
        return _continued_states(scene, pair, compliances, clock, similar)
    contact = contact_of(scene, pair, compliances)
    with clock.stage("sweep") as account:
        run = partial(
            sweep,
            contact,
            torques_Nmm=scene.torques_Nmm,
            # a lumped contact is solved with its tangent
            tangents=scene.accuracy.tangents and not pair.effects.lumped_contact,
            unloaded=unloaded,
            account=account,
        )
        try:
            pair, found, errors, rounds = _all_positions(scene, pair, run, clock)
        except ContactError as error:
            geometry = pair_geometry(pair, compliances)
            alone = partial(sweep, contact, pair.position_rad)
            blame_load(scene, pair, geometry, error, lambda torque: alone([torque]))
            raise
        account.bytes += held_bytes(found)
    geometry = pair_geometry(pair, compliances)
    return pair, FlankStates(found, errors, rounds, geometry, pair.position_rad, contact)


def record_files(scene: Scene) -> Mapping[str, Floats]:
    """Records of both bodies, their mesh and their motion; states determine adaptive positions."""
    from flankload.contact.record_files import pair_records

    account, clock = Account(), StageClock(None, PAIR, 1, {})
    pair = with_flank_distance(scene, build_bodies(scene), account)
    pair, compliances = compliances_of(scene, pair, clock, {})
    if pair.adaptive:
        accuracy = replace(scene.accuracy, tangents=False)
        bare = replace(scene, accuracy=accuracy)
        pair, _ = flank_states(bare, pair, compliances, clock, unloaded=False)
    contact = contact_of(scene, pair, compliances)
    return pair_records(contact, pair.position_rad, scene.torques_Nmm)


def _continued_states(
    scene: Scene, pair: BodyPair, compliances: Compliances, clock: StageClock, similar: FlankStates
) -> tuple[BodyPair, FlankStates]:
    """As `flank_states`, continued from those of a slightly different pair; no tangents."""
    pair = replace(pair, position_rad=similar.position_rad, adaptive=False)
    contact = contact_of(scene, pair, compliances)
    with clock.stage("sweep") as account:
        found = sweep(
            contact,
            pair.position_rad,
            scene.torques_Nmm,
            known=similar.known,
            unloaded=True,
            account=account,
        )
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
    """Range of tooth pitches that positions other than single angles cover."""
    assert pair.pitches is not None
    pairing = pair.pairing
    return Window(
        pitch_rad=pairing.pitch_rad,
        pitches=pair.pitches,
        closed=pair.closed,
        sites=pairing.sites,
        # the neighbour of a cam's single flank is the same flank
        cyclic=pairing.whole_circle or pairing.motion is not None,
    )


def position_notes(scene: Scene, pair: BodyPair, error: PositionErrors | None) -> Iterator[str]:
    """Warnings about adaptive positions whose estimated error exceeds the tolerance."""
    tolerance = position_tolerance(scene)
    if error is not None and error.largest > tolerance:
        yield (
            f"{pair.position_rad.size} positions are too few for a tolerance of {tolerance:g}: "
            f"harmonics are uncertain by {percent(error.harmonics)}, the peak to peak by "
            f"{percent(error.peak_to_peak)} (positions.max_count, positions.tolerance)"
        )


# --- error estimates ------------------------------------------------------------------------------
def error_estimates(
    scene: Scene, pair: BodyPair, compliances: Compliances, states: FlankStates, clock: StageClock
) -> list[Mapping[str, object] | None]:
    """Estimate the errors of the states, one entry per torque, as the result shows it.

    None without torque, for which nothing is approximated. `pair` has all positions.
    """
    found, lumped, grid = states.found, pair.effects.lumped_contact, pair.discretization.grid
    loaded = [t for t, part in enumerate(found) if part.torque_Nmm > 0]
    estimates: list[Mapping[str, object] | None] = [None] * len(found)
    with clock.stage("estimate") as account:
        if loaded:
            under_load = tuple(found[t] for t in loaded)
            at = deciding_positions(under_load[-1], n_deciding(plane=pair.slices.plane))
            compared = replace(pair, slices=pair.slices.compared())
            weights, torques = _weights(pair, at), [part.torque_Nmm for part in under_load]

            def run_again(*, part: int, unloaded: bool = False, **other: Any) -> tuple[Sweep, ...]:
                return sweep(
                    replace(states.contact, **other),
                    states.position_rad[at],
                    torques,
                    unloaded=unloaded,
                    keep_pairs=False,
                    account=account,
                    progress=clock.sweep_progress("estimate", sweep=part),
                )

            estimated = estimate_errors(
                under_load,
                run_again,
                compliances,
                grid if lumped else grid.coarser(),
                weights,
                variants=variants_of(
                    compliances, pair.slices, {"mesh": compared, "unloaded": True}
                ),
                at=at,
                slices_ratio=pair.slices.count / compared.slices.count,
                lumped=_lumped_errors(under_load, states.contact, pair, at) if lumped else None,
                roots=lambda part: root_tension(pair, compliances, pair_tables(pair, part.pairs)),
                sources=_sources(pair, states.contact),
            )
            for t, estimate in zip(loaded, estimated, strict=True):
                estimates[t] = estimate.as_dict(positions=states.position_errors[t])
    account_errors_of_elements(clock, pair.names, compliances)
    return estimates


def _lumped_errors(
    found: tuple[Sweep, ...], contact: FlankContact, pair: BodyPair, at: NDArray[np.int64]
) -> Callable[[int], dict[str, RemainingError]]:
    """Errors of lumped contacts of a torque by its index; none if cells have no state.

    Unlike those of other sources they jump from one position to the next: at each of the positions
    `at` the worst ones of twice as many are taken.
    """
    if pair.slices.conforming:
        return lambda _: spread_error()
    more = deciding_positions(found[-1], 2 * at.size)
    with suppress(ContactError):
        # a separate account, since no plan predicts the number of these cells
        cells = sweep(
            replace(contact, level="pairs", grid=contact.grid.coarser()),
            pair.position_rad[more],
            [part.torque_Nmm for part in found],
            keep_pairs=False,
        )
        weights, parts = _weights(pair, more), [join_sweeps([part], more) for part in found]
        nearest = np.abs(np.subtract.outer(more, at)).argmin(axis=1)
        return lambda t: {
            name: worst_beside(error, nearest)
            for name, error in error_beside_cells(parts[t], cells[t], weights).items()
        }
    return lambda _: {}


def _weights(pair: BodyPair, at: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n,) Parts of positions in means over the period."""
    return order_of(
        pair.position_rad[at],
        pitch_rad=pair.pairing.pitch_rad,
        period_rad=pair.period_rad,
        closed=pair.closed,
    ).weights


def _sources(
    pair: BodyPair, contact: FlankContact
) -> dict[str, Callable[[Sweep], dict[str, RemainingError]]]:
    """Sources of errors that follow from a sweep itself: positions, other teeth."""
    if pair.pitches is None:
        return {}
    window = window_of(pair)
    sources: dict[str, Callable[[Sweep], dict[str, RemainingError]]] = {
        "positions": lambda found: _sampling_error(found, contact, pair, window)
    }
    others = OtherTeeth(pair, contact.compliances, window)
    if window.pitches % others.pitches != 0:
        sources["period"] = partial(of_other_teeth, others=others)
    return sources


def _sampling_error(
    found: Sweep, contact: FlankContact, pair: BodyPair, window: Window
) -> dict[str, RemainingError]:
    """Errors of what depends on all positions."""
    position_rad = pair.position_rad
    if not pair.slices.plane and window.closed and not pair.adaptive:
        more = more_positions(position_rad, window.pitches * window.pitch_rad)
        known = contact.level == "lumped"  # the states at the first column
        with suppress(ContactError):
            # a separate account, as for the cells
            (many,) = sweep(
                replace(contact, level="lumped"),
                more[:, int(known) :].ravel(),
                [found.torque_Nmm],
                unloaded=True,
                keep_pairs=False,
            )
            many = with_known(found, many) if known else many
            return beside_more_positions(many, between_positions(many, window, more.ravel()))
    return between_positions(found, window, position_rad, adaptive=pair.adaptive)


def incomplete_estimate_notes(pair: BodyPair, compliances: Compliances) -> tuple[str, ...]:
    """Notes on bodies whose error the estimate does not include."""
    unknown = [
        name
        for name, body, compliance in zip(pair.names, pair.bodies, compliances, strict=True)
        if body.imported is not None
        and compliance.fe_error is None
        and compliance.modes.nodes is None
    ]
    if not unknown:
        return ()
    note = (
        "the error estimate omits the discretization error of the imported compliance of "
        f"{' and '.join(unknown)}, which its file does not state"
    )
    return (note,)


def unturned_notes(pair: BodyPair, compliances: Compliances, found: Sweep) -> Iterator[str]:
    """Notes on imported bodies whose forces do not turn over sharp tips, if corners carry load."""
    if not on_corner(found.slices.corner_off_ends).any():
        return
    named: dict[tuple[str, str], list[str]] = {}
    for name, body, job, compliance in zip(
        pair.names, pair.bodies, pair.jobs, compliances, strict=True
    ):
        if body.imported is not None and not compliance.turns and job.turns and job.elastic:
            modal = isinstance(body.imported, ModalCompliance)
            named.setdefault(WITHOUT_SMOOTH_NT if modal else BETWEEN_NODES, []).append(name)
    for (why, remedy), names in named.items():
        yield (
            f"forces on {' and '.join(names)} do not turn over sharp tips, since {why}: where tips "
            f"carry load, the rotation has an error of up to about {percent(LARGEST_TURN)}, which "
            f"the error estimate omits{remedy}"
        )
