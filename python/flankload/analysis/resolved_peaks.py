"""Peak pressures that have an estimate: those at places where the pressure modes resolve them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance


def with_resolved_peaks(part: Sweep, compliances: tuple[BodyCompliance, ...]) -> Sweep:
    """The sweep without the pressures of contacts near ends of flanks, which have no estimate.

    Polynomials of degree n change within 1/n² of the ends of a flank. Beyond it, on a rounding or
    a chamfer, modes converge slowly on what is much shorter than an element. Unchanged with a width
    and for several gear meshes, of whose sites the sweep has sums only.
    """
    pairs, found = part.pairs, np.zeros_like(part.site_force_N, dtype=bool)
    several = len(compliances) > 2 or pairs.sites.max(initial=0) >= len(found.T)
    if several or not part.slices.plane:
        return part
    position, sites = pairs.position, pairs.sites
    pressure = pairs.column("force") / pairs.column("cell")
    peaks = np.zeros(found.shape)
    np.maximum.at(peaks, (position, sites), pressure)
    highest = (pressure > 0) & (pressure == peaks[position, sites])
    for z, compliance in enumerate(compliances):
        modes, degree = compliance.modes, compliance.flank_modes - 1
        if modes.closed or modes.nodes is not None or degree < 1:
            continue
        low, high = modes.range_mm
        reach = (high - low) / degree**2
        s = pairs.column(f"s_{z + 1}")
        near = highest & ((s < low + reach) | (s > high - reach))
        found[position[near], sites[near]] = True
    return replace(part, site_peak_N_per_mm=np.where(found, 0.0, part.site_peak_N_per_mm))
