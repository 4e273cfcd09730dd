"""Error estimates of a flank pair."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from flankload.analysis.error_rules import of_positions
from flankload.analysis.estimate import estimate_errors
from flankload.analysis.period_error import OtherTeeth, of_other_teeth
from flankload.analysis.tip_error import tip_error
from flankload.cost import held_bytes
from flankload.mechanisms.flank_pair.stages import swept
from flankload.mechanisms.flank_pair.states import window_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flankload.analysis.error_rules import Left
    from flankload.contact.sweep import Sweep
    from flankload.mechanisms.flank_pair.stages import Compliances
    from flankload.mechanisms.flank_pair.states import FlankStates
    from flankload.mechanisms.stage_clock import StageClock
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene


def error_estimates(
    scene: Scene, pair: BodyPair, compliances: Compliances, states: FlankStates, clock: StageClock
) -> list[Mapping[str, object] | None]:
    """Estimate the errors of the states, one entry per torque, as the result shows it.

    None without torque, for which nothing is approximated. `pair` has all positions.
    """
    found = states.found
    loaded = [t for t, part in enumerate(found) if part.torque_Nmm > 0]
    estimates: list[Mapping[str, object] | None] = [None] * len(found)
    with clock.stage("estimate") as account:
        if loaded:

            def run_again(*, part: int, **other: Any) -> tuple[Sweep, ...]:
                return swept(
                    replace(states.contact, **other),
                    states.position_rad,
                    [found[t].torque_Nmm for t in loaded],
                    keep_pairs=False,
                    account=account,
                    progress=clock.sweep_progress("estimate", sweep=part),
                )

            estimated = estimate_errors(
                tuple(found[t] for t in loaded),
                run_again,
                compliances,
                pair.discretization.grid,
                lumped=pair.effects.lumped_contact,
                variants=_variants(pair, compliances),
                sources=_sources(pair, compliances, scene.pair.face_width_mm),
            )
            for t, estimate in zip(loaded, estimated, strict=True):
                estimates[t] = estimate.as_dict(positions=states.position_errors[t])
    for z, compliance in enumerate(compliances):
        account.bytes += held_bytes(compliance.missed)
        clock.move(compliance.job.seconds, f"compliance body {z + 1}", "estimate")
    return estimates


def _variants(pair: BodyPair, compliances: Compliances) -> dict[str, dict[str, object]]:
    """Arguments of the sweeps that show the errors of degrees along the axis and of slices."""
    if pair.slices is None:
        return {}
    fewer = tuple(compliance.fewer_axial_modes() for compliance in compliances)
    return {"axial": {"compliances": fewer}, "slices": {"slices": pair.slices.coarser()}}


def _sources(
    pair: BodyPair, compliances: Compliances, face_width_mm: float
) -> dict[str, Callable[[Sweep], dict[str, Left]]]:
    """Sources of errors that follow from a sweep itself: tips, positions, other teeth."""
    sources: dict[str, Callable[[Sweep], dict[str, Left]]] = {}
    if pair.slices is None:
        sources["tip"] = partial(
            tip_error,
            bodies=pair.bodies,
            compliances=compliances,
            pairing=pair.pairing,
            face_width_mm=face_width_mm,
        )
    if pair.pitches is None:
        return sources
    window = window_of(pair)
    if not pair.adaptive:
        sources["positions"] = partial(of_positions, window=window, position_rad=pair.position_rad)
    others = OtherTeeth.of(pair, compliances, face_width_mm, window)
    if others is not None:
        sources["period"] = partial(of_other_teeth, others=others)
    return sources


def unseen_notes(pair: BodyPair, compliances: Compliances) -> tuple[str, ...]:
    """Notes on bodies whose discretization error the estimate does not include."""
    if pair.slices is not None:
        jumps = any(body.axial and body.axial.regions for body in pair.bodies)
        slower = ", slower where widths jump" * jumps
        note = (
            "the error estimate does not contain the error of the degree of the displacements "
            f"along the axis (accuracy.axial_degree{slower}) and of forces that turn at tip corners"
        )
        return (note,)
    unknown = [
        f"body_{z + 1}"
        for z, (body, compliance) in enumerate(zip(pair.bodies, compliances, strict=True))
        if body.given is not None and compliance.missed is None and compliance.modes.nodes is None
    ]
    if not unknown:
        return ()
    note = (
        "the error estimate does not contain what the elements behind the compliance of "
        f"{' and '.join(unknown)} miss: its file does not tell"
    )
    return (note,)
