"""Values of the modes of a member of a stage at the contacts of its meshes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.near_field import mode_values
from flankload.result.root_stress import OverWidth, modes_on_slices

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.slices import Slices


def mode_values_at(compliance: BodyCompliance, slices: Slices, sweep: Sweep, which: int) -> Floats:
    """(N, p) Values of the modes of a body in all pairs of a mesh, in which it is body `which`.

    Over the width in the plane, so that products with forces are those of the compliance.
    """
    pairs, modes = sweep.pairs, compliance.modes
    places, span = pairs.column(f"s_{which + 1}"), modes.range_mm
    n_modes = compliance.modes_along
    if not slices.plane:
        over_width = OverWidth(modes.axial.range_mm, modes.axial.degree, slices.edges_mm)
        z_mm = slices.z_mm[pairs.slices]
        return modes_on_slices(
            (places, pairs.column("cell"), z_mm), span, modes.tip, n_modes, over_width
        )
    end = span[1] if modes.tip is None else modes.tip.end_mm
    within = np.clip(places, span[0], end)
    return mode_values(within, span, n_modes, tip=modes.tip) / slices.compliance_width_mm
