"""Results without the pressures that have no estimate: those near the ends of a flank."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import flankload as fl
from flankload.mechanisms.elements import modes_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene.discretization import choose_discretization


def with_resolved_peaks(result: fl.Result, scene: fl.Scene) -> fl.Result:
    """A plane result of a scene, with the pressures 0 that its modes do not resolve."""
    chosen = choose_discretization(scene)
    pair, peaks = build_bodies(scene, chosen), result.peak_pressure_MPa.copy()
    ends = []
    for body in (pair.body_1, pair.body_2):
        low, high = body.mode_range_mm
        reach = (high - low) / max(modes_of(body, scene, chosen) - 1, 1) ** 2
        ends.append((-np.inf, np.inf) if body.curve.closed else (low + reach, high - reach))
    for p, s in zip(*np.nonzero(peaks), strict=True):
        table = result.pairs(int(p))
        own = np.flatnonzero(table.site == result.sites[s])
        at = own[table.pressure_MPa[own].argmax()]
        for (low, high), places in zip(
            ends, (table.arc_length_1_mm, table.arc_length_2_mm), strict=True
        ):
            if not low <= places[at] <= high:
                peaks[p, s] = 0.0
    return replace(result, peak_pressure_MPa=peaks)
