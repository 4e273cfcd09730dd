"""How long a run will take, said before it starts: what can be counted, times rates.

Nothing is solved and nothing is tried, so that it costs next to nothing and is right to a factor of
two or so; `flankload plan` solves some states on the machine itself. The rates were measured on
gears, rings, cams and splines with 10 to 40 cells on a half-width, and on elements with 600 to
16000 unknowns (CPU seconds, the shortest of several runs on one thread of a core at 3 GHz); on
another machine they scale with its speed.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.plan.elements import unknowns_of
from flankload.prediction import predicted_work

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.assembly import BodyPair
    from flankload.scene import Scene

    Counters = Mapping[str, int]

#: Of a mesh, an element, a factor, a solution; a column of the cuts takes less than another one.
ASSEMBLY_S, ELEMENT_S, FACTOR_S, FACTOR_POWER = 0.011, 6.5e-5, 3.0e-7, 1.3
SOLUTION_S, CUT_PART, SMOOTHING_S = 1.0e-7, 0.3, 8e-7
#: Of a state for each contact pair, where single places touch.
PAIR_S = 2.4e-6
#: Where flanks conform most pairs carry: for each two of them; and so many passes where teeth do
#: not all touch at once. Where the numbers are those of finite forces: for each two pairs.
CONFORMING_S, PASSES, FINITE_S = 5e-8, 3.0, 2e-6
#: Flanks that touch at once, where geometry does not say; pairs of a lumped contact, in seconds;
#: cells of the estimate over those of the run; positions that adaptive ones become.
TOUCHING, LUMPED_PAIRS, FEWER, ADAPTIVE_PART = 2.0, 40.0, 0.5, 3.0
#: Of a contact problem of a belt.
BELT_STATE_S = 1e-3


@dataclass(frozen=True)
class Duration:
    """How long a run will take, to a factor of two or so.

    Attributes
    ----------
    elements_s, states_s : float
        Finite elements; states, on as many threads as there are.
    work : str
        What there is to do.
    """

    elements_s: float
    states_s: float
    work: str

    @property
    def seconds(self) -> float:
        """All of it."""
        return self.elements_s + self.states_s

    def __str__(self) -> str:
        """One line."""
        return f"about {float(f'{self.seconds:.1g}'):g} s: {self.work}"


def duration_of(scene: Scene, pair: BodyPair) -> Duration:
    """How long a run of two bodies with flanks will take."""
    counted, elements_s, unknowns = predicted_work(scene, pair), 0.0, 0
    for z, body in enumerate((pair.body_1, pair.body_2)):
        counters = counted.get(f"compliance body {z + 1}")
        if counters is not None and body.mesh is not None:
            unknowns += unknowns_of(body)
            count = sum(len(cells) for _, cells in body.mesh.cells)
            elements_s += _elements_s(counters, unknowns_of(body), count)
            if scene.accuracy.estimate:
                loads = counters["unit_loads_normal"] + counters["unit_loads_tangential"]
                elements_s += SMOOTHING_S * count * loads
    teeth = pair.pairing.sites.size if pair.pairing.whole_circle else 0
    work = _work(scene, pair.position_rad.size, "at least " * pair.adaptive)
    work += f" x {teeth} teeth at once" * bool(teeth)
    work += f", elements with {unknowns} unknowns" * bool(unknowns)
    return Duration(elements_s, _states_s(scene, pair), work)


def duration_of_belt(scene: Scene) -> Duration:
    """How long a run of a belt will take."""
    from flankload.belt_drive import flank_elements, positions_of, predicted_work, strip_of
    from flankload.plan.belt import BeltSizes

    strip = strip_of(scene)
    position_rad, _ = positions_of(scene, strip)
    counted = predicted_work(scene, strip, position_rad)
    sizes = BeltSizes.of(strip, flank_elements(scene, strip), position_rad)
    mean = sum(sizes.unknowns) // len(sizes.unknowns)
    elements_s = sum(
        len(sizes.unknowns) * ASSEMBLY_S + _elements_s(counters, mean, sum(sizes.unknowns) // 8)
        for name, counters in counted.items()
        if "fe_factorisations" in counters
    )
    states = sum(counters.get("states", 0) for counters in counted.values())
    work = f"{_work(scene, position_rad.size)}, {strip.wrapped_teeth} teeth"
    return Duration(elements_s, BELT_STATE_S * states, work)


def _work(scene: Scene, positions: int, least: str = "") -> str:
    torques = len(scene.torques_Nm)
    work = f"{least}{positions} position{'s' * (positions != 1)}"
    return f"{torques} torques x {work}" if torques > 1 else work


def _elements_s(counters: Counters, unknowns: int, elements: int) -> float:
    """Assembly, factors and solutions."""
    cuts = counters.get("cut_columns", 0)
    columns = counters["fe_solutions"] - cuts + CUT_PART * cuts
    factors = counters["fe_factorisations"] * FACTOR_S * unknowns**FACTOR_POWER
    return ASSEMBLY_S + ELEMENT_S * elements + factors + SOLUTION_S * unknowns * columns


def _states_s(scene: Scene, pair: BodyPair) -> float:
    """Sweep, tangents and estimate."""
    loaded = sum(torque > 0 for torque in scene.torques_Nm)
    pairs = _pairs(pair)
    seconds = len(scene.torques_Nm) * _state_s(pair, pairs)
    if not pair.effects.lumped_contact:
        seconds += 2 * loaded * _state_s(pair, pairs)
    if scene.accuracy.estimate:
        seconds += 3 * loaded * _state_s(pair, FEWER * pairs)
    positions = pair.position_rad.size * (ADAPTIVE_PART if pair.adaptive else 1.0)
    return seconds * positions / min(_threads(), pair.position_rad.size)


def _pairs(pair: BodyPair) -> float:
    """Contact pairs of a state."""
    if pair.effects.lumped_contact:
        return LUMPED_PAIRS
    grid, pairing = pair.resolution.grid, pair.pairing
    cells = 2.0 * grid.zone_half_widths * grid.strips_per_half_width
    touching = TOUCHING
    if pairing.whole_circle:
        touching = float(pairing.sites.size)
    elif pairing.motion is not None:
        touching = 1.0
    elif pairing.mesh is not None:
        touching = pairing.mesh.contact_ratio
    return cells * touching * (2.0 if pairing.coast is not None else 1.0)


def _state_s(pair: BodyPair, pairs: float) -> float:
    seconds = PAIR_S * pairs
    if pair.pairing.whole_circle:
        uneven = pair.effects.pitch_errors or pair.pairing.center_distance_mm > 0.0
        seconds += CONFORMING_S * pairs**2 * (PASSES if uneven else 1.0)
    if pair.effects.finite_influence:
        seconds += FINITE_S * pairs**2
    return seconds


def _threads() -> int:
    """Threads that positions are shared by."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return max(1, int(asked)) if asked.isdigit() else os.cpu_count() or 1
