"""Predicted duration of a run of a flank pair."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from flankload.mechanisms.duration import SMOOTHING_S, Duration, elements_seconds, work_in_words
from flankload.mechanisms.element_rates import unknowns_of
from flankload.mechanisms.flank_pair.prediction import predicted_work
from flankload.scene.axial import degrees_of

if TYPE_CHECKING:
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene

#: CPU seconds of a state for each contact pair, for contact at single places.
PAIR_S = 2.4e-6
#: For conforming flanks most pairs carry load: CPU seconds for each two of them, and the number of
#: passes if the teeth do not all touch at once. With finite influence coefficients: CPU seconds for
#: each two pairs.
CONFORMING_S, PASSES, FINITE_S = 5e-8, 3.0, 2e-6
#: Number of flanks that touch at once, if geometry does not give it; CPU time of a lumped contact,
#: in contact pairs; cells of the estimate relative to those of the run; final number of adaptive
#: positions relative to the first.
TOUCHING, LUMPED_PAIRS, FEWER, ADAPTIVE_PART = 2.0, 40.0, 0.5, 3.0


def duration_of(scene: Scene, pair: BodyPair) -> Duration:
    """Predict the duration of a run from counted work."""
    counted, elements_s, total = predicted_work(scene, pair), 0.0, 0
    for z, body in enumerate((pair.body_1, pair.body_2)):
        counters = counted.get(f"compliance body {z + 1}")
        if counters is not None and body.mesh is not None:
            unknowns = unknowns_of(body)
            if pair.slices is not None:  # three components in place of two, each of degree p
                unknowns = unknowns // 2 * 3 * (degrees_of(scene.accuracy)[0] + 1)
            total += unknowns
            count = sum(len(cells) for _, cells in body.mesh.cells)
            elements_s += elements_seconds(counters, unknowns, count)
            if scene.accuracy.estimate and pair.slices is None:
                loads = counters["unit_loads_normal"] + counters["unit_loads_tangential"]
                elements_s += SMOOTHING_S * count * loads
    teeth = pair.pairing.sites.size if pair.pairing.whole_circle else 0
    work = work_in_words(scene, pair.position_rad.size, "at least " * pair.adaptive)
    work += f" x {teeth} teeth at once" * bool(teeth)
    work += f", elements with {total} unknowns" * bool(total)
    return Duration(elements_s, _states_s(scene, pair), work)


def _states_s(scene: Scene, pair: BodyPair) -> float:
    """Seconds of sweep, tangents and estimate."""
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
    """Number of contact pairs of a state."""
    if pair.effects.lumped_contact:
        return LUMPED_PAIRS * (1 if pair.slices is None else pair.slices.count)
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
    """Number of threads that share the positions."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return max(1, int(asked)) if asked.isdigit() else os.cpu_count() or 1
