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
from flankload.cost import Account
from flankload.mechanisms.belt.belt_mesh import coarser
from flankload.mechanisms.belt.drive import (
    asked_of,
    flank_elements,
    positions_of,
    predicted_work,
    pulley_mesh,
    response_at,
    solved_pulley,
    strip_of,
    tried_positions,
)
from flankload.mechanisms.belt.pulley_compliance import rest_on
from flankload.mechanisms.belt.row import BeltRow
from flankload.mechanisms.belt.sizes import BeltSizes
from flankload.mechanisms.belt.states import state_under
from flankload.mechanisms.belt.work import work_of_pulley
from flankload.mechanisms.effect_size import States
from flankload.mechanisms.element_rates import load_packages
from flankload.mechanisms.premises import Torque, broken_by_turn, held
from flankload.mechanisms.screening import Screening
from flankload.mechanisms.toggles import Toggle, toggles, with_keys, without_keys

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.pulley_mesh import PulleyMesh
    from flankload.mechanisms.belt.row import StripResponse
    from flankload.scene import Scene

    Floats = NDArray[np.float64]

#: Elements on a flank of the screening, and of the cell that shows how the duration scales with
#: them.
ELEMENTS, MORE_ELEMENTS = 2, 4
#: Positions of the screening, and one after the next tooth has engaged: lands lift most there.
POSITIONS = 3
BYTES = 8


class BeltScreening(Screening):
    """The effects of a belt with few elements at few positions, and what its run will cost."""

    def __init__(self, scene: Scene, *, levels: bool = False) -> None:
        del levels
        self._scene = scene
        own = () if scene.body_1.rigid else ("elastic_body_1",)
        self.rows = (*own, "several_torques", "land_friction", "land_lift")
        self.toggles: dict[str, Toggle] = toggles(scene, self.rows)
        with Account() as self._bodies:
            self._strip = strip = strip_of(scene)
            self.reference_radius_mm = strip.pitch_radius_mm
            self._position_rad, _ = positions_of(scene, strip)
        self._bodies.bytes = self._position_rad.nbytes
        at = self._position_rad[_tried(strip, self._position_rad)]
        self._solve(scene, at)
        loads = (min(scene.torques_Nm), max(scene.torques_Nm))
        self._torques = tuple(dict.fromkeys(loads))
        self._state_s: dict[Scene, float] = {}
        self._known: dict[tuple[int, int], BeltSizes] = {}
        self._pulleys: dict[int, PulleyMesh] = {}
        self.base = self.states(scene)
        # sliding lands would turn a pulley without torque
        still = without_keys(scene, "land_friction")
        self.unloaded_rad = self._under(still, 0.0).rotation_rad
        for states in self.base:
            torque = Torque(scene, scene.torques_Nm.index(states.torque_Nm))
            turned_rad = float((states.rotation_rad - self.unloaded_rad).max())
            held(scene, tuple(broken_by_turn(turned_rad, strip.pitch_rad, torque)))

    def _solve(self, scene: Scene, at: Floats) -> None:
        """Solve the pieces of belt and a sector of the pulley, with all land columns."""
        strip, self._account = self._strip, Account()
        elements = min(ELEMENTS, flank_elements(scene, strip))
        self._screened = BeltSizes.of(strip, elements, at)
        load_packages()
        # the first cell takes the time of what packages do once
        BeltRow(strip, elements, sliding=True, lifting=True)
        start = process_time()
        row = BeltRow(strip, elements, sliding=True, lifting=True, account=self._account)
        cell_s = process_time() - start
        self._held = [response_at(strip, row, None, float(angle)) for angle in at]
        self._pieces_s = process_time() - start
        start = process_time()
        BeltRow(strip, MORE_ELEMENTS, sliding=True, lifting=True)
        self._growth = (process_time() - start) / max(cell_s, 1e-6)
        self._yielding, self._pulley = self._held, Account()
        if not scene.body_1.rigid:
            all_asked = with_keys(scene, land_friction=scene.effects.land_friction or 0.1)
            mesh = pulley_mesh(scene, elements)
            with self._pulley:
                known = solved_pulley(all_asked, mesh, self._pulley)
            self._yielding = [rest_on(response, strip, known) for response in self._held]
            self._sector = len(mesh.sector.nodes)

    def states(self, scene: Scene) -> list[States]:
        """Contact problems of the same answers, of a rigid pulley or of one that yields."""
        start = process_time()
        found = [self._under(scene, torque) for torque in self._torques]
        self._state_s[scene] = (process_time() - start) / (len(found) * len(self._held))
        return found

    def _under(self, scene: Scene, torque_Nm: float) -> States:
        responses: list[StripResponse] = self._held if scene.body_1.rigid else self._yielding
        first = min(response.first_tooth for response in responses)
        last = max(response.first_tooth + response.teeth for response in responses)
        force = np.zeros((len(responses), last - first))
        rotation = np.zeros(len(responses))
        for p, response in enumerate(responses):
            state = state_under(scene, self._strip, response, torque_Nm, Account())
            own = response.first_tooth - first
            force[p, own : own + response.teeth] = self._strip.width_mm * state.tooth_N_per_mm
            rotation[p] = state.rotation_rad
        return States.of(torque_Nm, np.arange(first, last), rotation, force)

    # --- cost -------------------------------------------------------------------------------------
    def price(self, scene: Scene) -> dict[str, Account]:
        """CPU seconds, bytes and counters by stage for the run of a scene with other effects."""
        strip, positions, asked = self._strip, self._position_rad, asked_of(scene)
        counted = predicted_work(scene, strip, positions)
        sizes = self._sizes(strip, flank_elements(scene, strip), positions)
        states = positions.size * len(scene.torques_Nm)
        one, body = "compliance body 1", "compliance body 2"
        stages = {
            "bodies": Account(cpu_s=self._bodies.cpu_s, bytes=self._bodies.bytes),
            **({one: self._pulley_of(scene, sizes.elements)} if one in counted else {}),
            body: self._belt(sizes),
            "sweep": Account(
                cpu_s=states * self._seconds_of_state(scene, sizes),
                bytes=states * sizes.state_bytes(asked) + positions.size * sizes.flank_bytes,
            ),
        }
        stages[body].bytes = sizes.bytes(asked)
        if "estimate" in counted:
            tried = positions[tried_positions(strip, positions)]
            halved, elements = coarser(strip, sizes.elements)
            half = self._sizes(halved, elements, tried)
            stages["estimate"] = account = self._belt(half)
            loaded = tried.size * sum(torque > 0.0 for torque in scene.torques_Nm)
            coarse_s = self._seconds_of_state(scene, half)
            account.cpu_s += loaded * coarse_s
            if one in counted:
                pulley = self._pulley_of(scene, elements)
                again = 2.0 * self._seconds_of_state(scene, sizes) + coarse_s
                account.cpu_s += pulley.cpu_s + loaded * again
                account.workspace_bytes += pulley.workspace_bytes
        for stage, counters in counted.items():
            stages[stage].counters |= counters
        return stages

    def _sizes(self, strip: Strip, elements: int, at: Floats) -> BeltSizes:
        """Array sizes of the run's belt or of its estimate, independent of the land columns."""
        key = elements, at.size
        if key not in self._known:
            self._known[key] = BeltSizes.of(strip, elements, at)
        return self._known[key]

    def _belt(self, sizes: BeltSizes) -> Account:
        """Cost of the pieces of a belt: linear in their unknowns, from two measured cells."""
        mine = self._screened
        each = self._pieces_s / len(mine.pieces)
        more = (MORE_ELEMENTS / mine.elements) ** 2
        slope = max(0.0, self._growth - 1.0) / (more - 1.0)
        mean = sum(mine.unknowns) / len(mine.unknowns)
        seconds = sum(each * max(0.1, 1.0 + slope * (n / mean - 1.0)) for n in sizes.unknowns)
        part = sizes.factors / mine.factors
        return Account(cpu_s=seconds, workspace_bytes=round(part * self._account.workspace_bytes))

    def _pulley_of(self, scene: Scene, elements: int) -> Account:
        """Cost of the sector of a pulley, proportional to the entries of its factor."""
        if elements not in self._pulleys:
            self._pulleys[elements] = pulley_mesh(scene, elements)
        mesh, asked = self._pulleys[elements], asked_of(scene)
        nodes = len(mesh.sector.nodes)
        part = nodes * log(nodes) / (self._sector * log(self._sector))
        work = work_of_pulley(mesh, asked)
        loads = work["unit_loads_normal"] + work["unit_loads_tangential"]
        return Account(
            cpu_s=part * self._pulley.cpu_s,
            bytes=BYTES * mesh.sector.teeth * loads**2,
            workspace_bytes=round(part * self._pulley.workspace_bytes),
        )

    def _seconds_of_state(self, scene: Scene, sizes: BeltSizes) -> float:
        """Seconds of a contact problem: matrices of pairs and shape functions are multiplied."""
        mine = self._screened
        more = (sizes.pairs + sizes.hats) / (mine.pairs + mine.hats)
        return self._state_s.get(scene, self._state_s[self._scene]) * max(1.0, more)


def _tried(strip: Strip, position_rad: Floats) -> NDArray[np.int64]:
    """A few positions, and the first at which another tooth has engaged."""
    few = np.arange(position_rad.size)[:: max(1, -(-position_rad.size // POSITIONS))]
    first = round_down(position_rad / strip.pitch_rad + 0.5)
    return np.union1d(few, np.flatnonzero(np.diff(first))[:1] + 1)
