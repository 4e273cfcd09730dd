"""Screening of a timing belt: few elements at few positions, with all land columns.

The pieces of the belt are solved once; sliding lands, lifting lands and an elastic pulley are other
contact problems with the same responses.
"""

from __future__ import annotations

from math import log
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_down
from flankload.cost import Account, held_bytes
from flankload.mechanisms.belt.contact import state_under
from flankload.mechanisms.belt.drive import (
    assemble,
    land_columns_of,
    predicted_work,
    response_at,
    solved_pulley,
    work_of_pulley,
)
from flankload.mechanisms.belt.drive_result import sites_of
from flankload.mechanisms.belt.pulley_compliance import on_elastic_pulley
from flankload.mechanisms.belt.row import BeltRow
from flankload.mechanisms.element_rates import load_packages
from flankload.mechanisms.premises import Torque, broken_by_turn, require_premises
from flankload.mechanisms.screening import Screening
from flankload.mechanisms.toggles import Toggle, toggles, with_keys, without_keys

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.row import PieceSize
    from flankload.mechanisms.effect_size import States
    from flankload.scene import Scene

#: Elements on a flank of the screening, and least number of a second piece; that one has half as
#: many as the run, so that it costs a fifth of a piece of the run.
ELEMENTS, MORE_ELEMENTS = 2, 3
#: Positions of the screening, and one after the next tooth has engaged: lands lift most there.
POSITIONS = 3
BYTES = 8


class PieceRates:
    """Cost of pieces with n unknowns, t = t_0 + b n^(3/2), from two pieces with the tight strand.

    The exponent is that of the factorisation of a plane mesh (George, SIAM J. Numer. Anal. 10,
    1973); t_0 is the time of everything that does not depend on the size of small pieces.

    Parameters
    ----------
    few, more : BeltRow
        With few elements, and with nearly as many as the run; not solved yet.
    phase : float
        Advance of the teeth, in pitches.
    """

    def __init__(self, few: BeltRow, more: BeltRow, phase: float) -> None:
        with Account() as coarse:
            small = few.solve_tight_end(phase, coarse)
        with Account() as finer:
            large = more.solve_tight_end(phase, finer)
        change = _factor_work([large]) - _factor_work([small])
        self._factor_s = max(0.0, (finer.cpu_s - coarse.cpu_s) / change)
        self._piece_s = max(0.0, coarse.cpu_s - self._factor_s * _factor_work([small]))
        self._bytes_per_entry = coarse.workspace_bytes / _factor_entries([small])

    def price(self, sizes: Sequence[PieceSize]) -> Account:
        """CPU seconds and bytes of pieces."""
        return Account(
            cpu_s=len(sizes) * self._piece_s + self._factor_s * _factor_work(sizes),
            workspace_bytes=round(self._bytes_per_entry * _factor_entries(sizes)),
        )


def _factor_work(sizes: Sequence[PieceSize]) -> float:
    return sum(size.unknowns**1.5 for size in sizes)


def _factor_entries(sizes: Sequence[PieceSize]) -> float:
    """Entries of the factors, up to a constant factor."""
    return sum(size.unknowns * log(size.unknowns) for size in sizes)


class BeltScreening(Screening):
    """The effects of a belt with few elements at few positions, and what its run will cost."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        own = () if scene.body_1.rigid else ("elastic_body_1",)
        self.rows = (*own, "several_torques", "land_friction", "land_lift")
        self.toggles: dict[str, Toggle] = toggles(scene, self.rows)
        with Account() as self._bodies:
            self._assembly = assemble(scene)
        self._bodies.bytes = held_bytes(self._assembly)
        strip = self._assembly.strip
        self.reference_radius_mm = strip.pitch_radius_mm
        self._torques = tuple(dict.fromkeys((min(scene.torques_Nm), max(scene.torques_Nm))))
        self._state_s: dict[Scene, float] = {}
        self._solve(scene)
        self.base = self.states(scene)
        # sliding lands would turn a pulley without torque
        still = without_keys(scene, "land_friction")
        self.unloaded_rad = self._under(still, 0.0).rotation_rad
        for states in self.base:
            torque = Torque(scene, scene.torques_Nm.index(states.torque_Nm))
            turned_rad = float((states.rotation_rad - self.unloaded_rad).max())
            require_premises(scene, broken_by_turn(turned_rad, strip.pitch_rad, torque))

    def _solve(self, scene: Scene) -> None:
        """Solve the pieces of belt and a sector of the pulley, with all land columns."""
        run, at = self._assembly.row, self._assembly.position_rad
        at = at[_tried(run.strip, at)]
        self._few = BeltRow(run.strip, min(ELEMENTS, run.elements), sliding=True, lifting=True)
        load_packages()
        # the first piece takes the time of what packages do once
        self._few.solve_cell(Account())
        elements = max(MORE_ELEMENTS, run.elements // 2)
        more = BeltRow(run.strip, elements, **land_columns_of(scene))
        self._rates = PieceRates(self._few, more, float(at[0]) / run.strip.pitch_rad)
        self._held = [response_at(self._few, None, float(angle)) for angle in at]
        self._elastic, self._pulley = self._held, Account()
        if not scene.body_1.rigid:
            all_asked = with_keys(scene, land_friction=scene.effects.land_friction or 0.1)
            mesh = self._assembly.pulley.of(self._few.elements)
            with self._pulley:
                known = solved_pulley(all_asked, mesh, self._pulley)
            self._elastic = [
                on_elastic_pulley(response, run.strip, known) for response in self._held
            ]
            self._sector = len(mesh.sector.nodes)

    def states(self, scene: Scene) -> list[States]:
        """Contact problems with the same responses, of a rigid pulley or of an elastic one."""
        start = process_time()
        found = [self._under(scene, torque) for torque in self._torques]
        self._state_s[scene] = (process_time() - start) / (len(found) * len(self._held))
        return found

    def _under(self, scene: Scene, torque_Nm: float) -> States:
        strip = self._assembly.strip
        responses = self._held if scene.body_1.rigid else self._elastic
        found = [
            state_under(scene, strip, response, torque_Nm, Account()) for response in responses
        ]
        return sites_of(found).effect_states(
            torque_Nm,
            [state.rotation_rad for state in found],
            [strip.width_mm * state.tooth_N_per_mm for state in found],
        )

    # --- cost -------------------------------------------------------------------------------------
    def price(self, scene: Scene) -> dict[str, Account]:
        """CPU seconds, bytes and counters by stage for the run of a scene with other effects."""
        assembly, positions = self._assembly, self._assembly.position_rad
        row, counted = assembly.row, predicted_work(scene, assembly)
        sizes, states = row.sizes(positions), positions.size * len(scene.torques_Nm)
        one, body = "compliance body 1", "compliance body 2"
        stages = {
            "bodies": Account(cpu_s=self._bodies.cpu_s, bytes=self._bodies.bytes),
            **({one: self._pulley_of(scene, row.elements)} if one in counted else {}),
            body: self._rates.price(sizes),
            "sweep": Account(cpu_s=states * self._seconds_of_state(scene, row)),
        }
        stages[body].bytes, state, flanks = _bytes(scene, row, sizes)
        stages["sweep"].bytes = states * state + positions.size * flanks
        if "estimate" in counted:
            tried = positions[assembly.tried]
            stages["estimate"] = account = self._rates.price(assembly.coarse.sizes(tried))
            loaded = tried.size * sum(torque > 0.0 for torque in scene.torques_Nm)
            coarse_s = self._seconds_of_state(scene, assembly.coarse)
            account.cpu_s += loaded * coarse_s
            if one in counted:
                pulley = self._pulley_of(scene, assembly.coarse.elements)
                again = 2.0 * self._seconds_of_state(scene, row) + coarse_s
                account.cpu_s += pulley.cpu_s + loaded * again
                account.workspace_bytes += pulley.workspace_bytes
        for stage, counters in counted.items():
            stages[stage].counters |= counters
        return stages

    def _pulley_of(self, scene: Scene, elements: int) -> Account:
        """Cost of the sector of a pulley, proportional to the entries of its factor."""
        mesh = self._assembly.pulley.of(elements)
        nodes, work = len(mesh.sector.nodes), work_of_pulley(scene, mesh)
        part = nodes * log(nodes) / (self._sector * log(self._sector))
        loads = work["unit_loads_normal"] + work["unit_loads_tangential"]
        return Account(
            cpu_s=part * self._pulley.cpu_s,
            bytes=BYTES * mesh.sector.teeth * loads**2,
            workspace_bytes=round(part * self._pulley.workspace_bytes),
        )

    def _seconds_of_state(self, scene: Scene, row: BeltRow) -> float:
        """Seconds of a contact problem, proportional to its pairs."""
        return self._state_s.get(scene, self._state_s[self._scene]) * max(
            1.0, row.pairs / self._few.pairs
        )


def _bytes(scene: Scene, row: BeltRow, sizes: Sequence[PieceSize]) -> tuple[int, int, int]:
    """Bytes of the largest response, of a state with contact at most pairs, and of the flanks."""
    teeth, n, columns = row.strip.wrapped_teeth, row.pairs, land_columns_of(scene)
    inner = sum(size.land_functions for size in sizes if not size.held and not size.pulled)
    tight, slack = (
        [size.land_functions for size in sizes if getattr(size, end)] for end in ("held", "pulled")
    )
    # the longest tight end and the shortest slack end belong to the same position
    h = (teeth - 1) * inner + max(tight) + min(slack)
    response = n * n + h * n + 2 * n + 3 * h + 1
    response += sum(columns.values()) * (n * h + h * h + h)
    state = 3 * (n + columns["lifting"] * h) + 4 * teeth
    lines = 2 * teeth * (2 * row.elements + 1)
    return BYTES * (response + lines + 8 * n), BYTES * state, BYTES * 8 * n


def _tried(strip: Strip, position_rad: Floats) -> Numbers:
    """A few positions, and the first at which another tooth has engaged."""
    few = np.arange(position_rad.size)[:: max(1, -(-position_rad.size // POSITIONS))]
    first = round_down(position_rad / strip.pitch_rad + 0.5)
    return np.union1d(few, np.flatnonzero(np.diff(first))[:1] + 1)
