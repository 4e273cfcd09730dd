"""How long a run will take, said before it starts: what can be counted, times rates.

Nothing is solved and nothing is tried, so that it costs next to nothing and is right to a factor of
two or so; `flankload plan` tries some states and is right to a fifth. Rates of elements are those
of `price`. Rates of states were measured on gears, rings, cams and splines with 10 to 40 cells on a
half-width (CPU seconds of the stages over their states, the shortest of several runs on one thread
of a core at 3 GHz); on another machine they scale with its speed.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.mechanisms.belt.drive import BeltAssembly
from flankload.mechanisms.flank_pair.prediction import predicted_work
from flankload.pairing.body_pair import BodyPair
from flankload.plan.price import ADAPTIVE_PART, SMOOTHING_S, elements_price, unknowns_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene

    Counted = Mapping[str, Mapping[str, int]]

#: Seconds of a state for each contact pair, where single places touch.
PAIR_S = 2.4e-6
#: Where flanks conform most pairs carry: seconds for each two of them; and so many passes where
#: teeth do not all touch at once.
CONFORMING_S, PASSES = 5e-8, 3.0
#: Where the numbers are those of finite forces: seconds for each two pairs.
FINITE_S = 2e-6
#: Pairs of flanks that touch at once, where geometry does not say.
TOUCHING = 2.0
#: Contact pairs of a lumped contact, in what they take.
LUMPED_PAIRS = 40.0
#: The estimate sweeps with half as many cells.
FEWER = 0.5


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


def duration_of(scene: Scene, assembly: object) -> Duration | None:
    """How long a run will take.

    Parameters
    ----------
    scene : Scene
    assembly : BodyPair, BeltAssembly or ChainAssembly

    Returns
    -------
    Duration or None
        None of a chain, which takes next to nothing.
    """
    if isinstance(assembly, BodyPair):
        return _duration_of_pair(scene, assembly)
    return duration_of_belt(scene) if isinstance(assembly, BeltAssembly) else None


def _duration_of_pair(scene: Scene, pair: BodyPair) -> Duration:
    counted = predicted_work(scene, pair)
    positions = pair.position_rad.size
    torques = len(scene.torques_Nm)
    unknowns = sum(
        unknowns_of(body)
        for z, body in enumerate((pair.body_1, pair.body_2))
        if body.mesh is not None and f"compliance body {z + 1}" in counted
    )
    parts = [
        f"{torques} torques" if torques > 1 else "",
        f"{'at least ' if pair.adaptive else ''}{positions} position{'s' * (positions != 1)}",
    ]
    if pair.pairing.whole_circle:
        parts.append(f"{pair.pairing.sites.size} teeth at once")
    work = " x ".join(part for part in parts if part)
    if unknowns:
        work += f", elements with {unknowns} unknowns"
    return Duration(_elements_s(scene, pair, counted), _states_s(scene, pair), work)


def _elements_s(scene: Scene, pair: BodyPair, counted: Counted) -> float:
    """Both compliances, and what the estimate smooths."""
    seconds = 0.0
    for z, body in enumerate((pair.body_1, pair.body_2)):
        counters = counted.get(f"compliance body {z + 1}")
        if counters is None or body.mesh is None:
            continue
        seconds += elements_price(body, counters).cpu_s
        if scene.accuracy.estimate:
            columns = counters["unit_loads_normal"] + counters["unit_loads_tangential"]
            seconds += SMOOTHING_S * sum(len(cells) for _, cells in body.mesh.cells) * columns
    return seconds


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
    grid, pairing = pair.discretization.grid, pair.pairing
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


def duration_of_belt(scene: Scene) -> Duration:
    """How long a run of a belt will take.

    Parameters
    ----------
    scene : Scene
        With a pulley and a belt.

    Returns
    -------
    Duration
    """
    from flankload.mechanisms.belt.drive import positions_of, strip_of
    from flankload.plan.belt_price import price_belt

    strip = strip_of(scene)
    position_rad, _ = positions_of(scene, strip)
    slower = {"compliance body 1": 1.0, "compliance body 2": 1.0, "sweep": 1.0}
    stages = price_belt(scene, strip, position_rad, slower)
    elements = sum(a.cpu_s for name, a in stages.items() if name.startswith("compliance"))
    whole = sum(account.cpu_s for account in stages.values())
    count, torques = position_rad.size, len(scene.torques_Nm)
    work = f"{count} position{'s' * (count != 1)}, {strip.wrapped_teeth} teeth"
    return Duration(
        elements, whole - elements, f"{torques} torques x {work}" if torques > 1 else work
    )
