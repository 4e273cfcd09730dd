"""Error estimates of a drive with several gear meshes, and of its meshes over their width."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from flankload.analysis.deciding_positions import deciding_positions, n_deciding
from flankload.analysis.estimate import OF_WIDTH, estimate_errors
from flankload.analysis.lumped_error import error_beside_cells
from flankload.analysis.more_positions import beside_more_positions, more_positions, with_known
from flankload.contact.meshes_contact import sweep_meshes
from flankload.contact.sweep import join_sweeps
from flankload.errors import ContactError
from flankload.mechanisms.elements import account_errors_of_elements, variants_of
from flankload.result.position_order import order_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.analysis.error_rules import RemainingError
    from flankload.base.arrays import Floats, Numbers
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
    slices = tuple(each.compared() for each in assembly.slices)
    compared = replace(assembly, slices=slices).meshes
    ratio = assembly.slices[0].count / slices[0].count
    variants = variants_of(compliances, assembly.slices[0], {"meshes": compared})
    whole = tuple(one.whole for one in states.found)
    most = n_deciding(plane=plane, meshes=len(assembly.slices))
    at = deciding_positions(whole[-1], most)
    cells, positions = _BesideCells(assembly, states, at), _BesideMore(assembly, states)
    reduced: dict[int, tuple[MeshesSweep, ...]] = {}
    with clock.stage("estimate") as account:

        def run_again(*, part: int, **other: Any) -> tuple[Sweep, ...]:
            reduced[part] = sweep_meshes(
                replace(contact, **other),
                assembly.position_rad[at],
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
            cells.weights,
            variants=variants,
            at=at,
            slices_ratio=ratio,
            lumped=cells.errors if lumped else None,
            sources={} if plane else {"positions": positions.errors},
        )
        found: list[dict[str, object]] = [one.as_dict() for one in estimated]
        if not plane:
            loaded = [t for t, one in enumerate(whole) if one.torque_Nmm > 0]
            every = [
                _of_mesh(m, loaded, states, variants, reduced, cells, positions, ratio)
                for m in range(len(assembly.slices) if loaded else 0)
            ]
            for t, one in enumerate(found):
                one[OF_MESHES] = tuple(mesh[t] for mesh in every) if t in loaded else ()
    account_errors_of_elements(clock, assembly.names, compliances)
    return list(found)


def _of_mesh(
    m: int,
    loaded: Sequence[int],
    states: MeshesStates,
    variants: Variants,
    reduced: Mapping[int, Sequence[MeshesSweep]],
    cells: _BesideCells,
    positions: _BesideMore,
    ratio: float,
) -> dict[int, dict[str, object]]:
    """Estimates of a mesh by torque, for those that are `loaded`."""
    contact = states.contact

    def again(*, part: int, **other: Any) -> tuple[Sweep, ...]:
        """Sweeps of the mesh in the reduced sweep of the drive with this number."""
        if part not in reduced:
            raise ContactError("the reduced sweep of the drive does not converge")
        return tuple(reduced[part][t].meshes[m] for t in loaded)

    estimated = estimate_errors(
        tuple(states.found[t].meshes[m] for t in loaded),
        again,
        tuple(
            contact.compliances[contact.pairing.tables[b]]
            for b in contact.pairing.meshes[m].members
        ),
        contact.grid,
        cells.weights,
        variants=variants,
        at=cells.at,
        slices_ratio=ratio,
        lumped=(lambda i: cells.errors(loaded[i], m)) if contact.level == "lumped" else None,
        sources={"positions": lambda part: positions.errors(part, m)},
    )
    return {t: one.as_dict() for t, one in zip(loaded, estimated, strict=True)}


@dataclass(frozen=True, eq=False)
class _BesideCells:
    """Errors of lumped contacts by cells at the deciding positions."""

    assembly: AnyAssembly
    states: MeshesStates
    at: Numbers

    @cached_property
    def weights(self) -> Floats:
        """(n,) Parts of these positions in means over the period."""
        return weights_of(self.assembly, self.at)

    @cached_property
    def found(self) -> tuple[MeshesSweep, ...] | None:
        """The states with cells; None if there is none at a position."""
        contact = self.states.contact
        with suppress(ContactError):
            return sweep_meshes(
                replace(contact, level="pairs", grid=contact.grid.coarser()),
                self.assembly.position_rad[self.at],
                [one.whole.torque_Nmm for one in self.states.found],
                # by which the moments on the bodies are known
                keep_pairs=not self.assembly.is_plane,
            )
        return None

    def errors(self, t: int, m: int | None = None) -> dict[str, RemainingError]:
        """Those under a torque, of the whole drive or of a mesh; empty without cells."""
        if self.found is None:
            return {}
        one, cells = (
            each.whole if m is None else each.meshes[m]
            for each in (self.states.found[t], self.found[t])
        )
        return error_beside_cells(join_sweeps([one], self.at), cells, self.weights)


@dataclass(frozen=True, eq=False)
class _BesideMore:
    """Errors of positions over the width, by lumped contacts at four times as many."""

    assembly: AnyAssembly
    states: MeshesStates

    @property
    def known(self) -> bool:
        """Whether the states at every fourth position are those of the drive."""
        return self.states.contact.level == "lumped"

    @cached_property
    def found(self) -> tuple[MeshesSweep, ...] | None:
        """The states at more positions; None without even ones or without a state at one."""
        if not self.assembly.closed:
            return None
        more = more_positions(self.assembly.position_rad, self.assembly.period_rad)
        with suppress(ContactError):
            # a separate account, as for the cells
            return sweep_meshes(
                replace(self.states.contact, level="lumped"),
                more[:, int(self.known) :].ravel(),
                [one.whole.torque_Nmm for one in self.states.found],
                keep_pairs=False,
            )
        return None

    def errors(self, part: Sweep, m: int | None = None) -> dict[str, RemainingError]:
        """Those of a sweep of the states, of the whole drive or of a mesh."""
        if self.found is None:
            return {}
        pairs = zip(self.states.found, self.found, strict=True)
        own, many = zip(
            *((a.whole, b.whole) if m is None else (a.meshes[m], b.meshes[m]) for a, b in pairs),
            strict=True,
        )
        t = next(t for t, one in enumerate(own) if one is part)
        all_of = with_known(part, many[t]) if self.known else many[t]
        errors = beside_more_positions(all_of, {})
        # the line loads of a whole drive are those of its meshes; states without torque are unknown
        left = {"stiffness_secant", *(OF_WIDTH if m is None else ())}
        return {name: error for name, error in errors.items() if name not in left}


def weights_of(assembly: AnyAssembly, at: Numbers | slice = slice(None)) -> Floats:
    """(n,) Parts of the positions `at` in means over the period."""
    return order_of(
        assembly.position_rad[at],
        pitch_rad=assembly.pairing.pitch_rad,
        period_rad=assembly.period_rad,
        closed=assembly.closed,
    ).weights
