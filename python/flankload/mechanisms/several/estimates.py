"""Error estimates of a drive with several gear meshes, and of its meshes over their width."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.analysis.estimate import estimate_errors
from flankload.analysis.lumped_error import measured_error
from flankload.contact.meshes_contact import sweep_meshes
from flankload.errors import ContactError
from flankload.mechanisms.elements import (
    account_errors_of_elements,
    variants_of,
)
from flankload.result.position_order import order_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.analysis.error_rules import RemainingError
    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.contact.sweep import Sweep
    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.several.states import AnyAssembly, MeshesStates
    from flankload.mechanisms.stage_clock import StageClock
    from flankload.scene import Scene

    Variants = Mapping[str, Mapping[str, object]]

#: Key of the estimates of the meshes in that of a drive with width.
OF_MESHES = "meshes"


def error_estimates(
    scene: Scene,
    assembly: AnyAssembly,
    compliances: Compliances,
    states: MeshesStates,
    clock: StageClock,
) -> list[Mapping[str, object] | None]:
    """Estimate the errors of the states, one entry per torque: as of a pair, over all meshes.

    With a width also those of each mesh under a torque, by the same reduced sweeps, as `OF_MESHES`.
    """
    contact, torques = states.contact, scene.torques_Nmm
    lumped, grid = contact.level == "lumped", contact.grid
    plane = assembly.is_plane
    coarser = tuple(slices.coarser() for slices in assembly.slices)
    variants = variants_of(
        compliances,
        assembly.slices[0],
        lambda: {"meshes": replace(assembly, slices=coarser).meshes},
    )
    weights = np.full(assembly.position_rad.size, 1.0 / assembly.position_rad.size)
    whole = tuple(one.whole for one in states.found)
    reduced: dict[int, tuple[MeshesSweep, ...]] = {}
    with clock.stage("estimate") as account:

        def run_again(*, part: int, **other: Any) -> tuple[Sweep, ...]:
            reduced[part] = sweep_meshes(
                replace(contact, **other),
                assembly.position_rad,
                torques,
                # by which the moments on the bodies are known
                keep_pairs=not plane,
                account=account,
                progress=clock.sweep_progress("estimate", sweep=part),
            )
            return tuple(one.whole for one in reduced[part])

        estimated = estimate_errors(
            whole,
            run_again,
            compliances,
            grid if lumped else grid.coarser(),
            weights,
            variants=variants,
            lumped=(lambda t: measured_error(whole[t], compliances)) if lumped else None,
        )
        found: list[dict[str, object]] = [one.as_dict() for one in estimated]
        if not plane:
            for t, of_meshes in enumerate(_of_meshes(assembly, states, variants, reduced)):
                found[t][OF_MESHES] = of_meshes
    account_errors_of_elements(clock, assembly.names, compliances)
    return list(found)


def _of_meshes(
    assembly: AnyAssembly,
    states: MeshesStates,
    variants: Variants,
    reduced: Mapping[int, Sequence[MeshesSweep]],
) -> list[tuple[Mapping[str, object], ...]]:
    """Estimates of the meshes under each torque; empty without torque."""
    contact, weights = states.contact, weights_of(assembly)
    found: list[tuple[Mapping[str, object], ...]] = [()] * len(states.found)
    loaded = [t for t, one in enumerate(states.found) if one.whole.torque_Nmm > 0]
    for m, mesh in enumerate(contact.pairing.meshes if loaded else ()):
        own = [contact.compliances[contact.pairing.tables[b]] for b in mesh.members]
        estimated = estimate_errors(
            tuple(states.found[t].meshes[m] for t in loaded),
            partial(_again, reduced, loaded, m),
            tuple(own),
            contact.grid,
            weights,
            variants=variants,
            lumped=partial(_lumped, states, loaded, m) if contact.level == "lumped" else None,
        )
        for t, one in zip(loaded, estimated, strict=True):
            found[t] = (*found[t], one.as_dict())
    return found


def _again(
    reduced: Mapping[int, Sequence[MeshesSweep]],
    loaded: Sequence[int],
    m: int,
    *,
    part: int,
    **other: Any,
) -> tuple[Sweep, ...]:
    """Sweeps of a mesh in the reduced sweep of the drive with this number."""
    if part not in reduced:
        raise ContactError("the reduced sweep of the drive does not converge")
    return tuple(reduced[part][t].meshes[m] for t in loaded)


def _lumped(
    states: MeshesStates, loaded: Sequence[int], m: int, t: int
) -> dict[str, RemainingError]:
    """Errors of the lumped contacts of a mesh."""
    return measured_error(states.found[loaded[t]].meshes[m], states.contact.compliances)


def weights_of(assembly: AnyAssembly) -> Floats:
    """(P,) Parts of the positions in means over the period."""
    return order_of(
        assembly.position_rad,
        pitch_rad=assembly.pairing.pitch_rad,
        period_rad=assembly.period_rad,
        closed=assembly.closed,
    ).weights
