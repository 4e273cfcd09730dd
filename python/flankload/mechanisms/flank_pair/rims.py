"""Thickness of rims that are held at the bore of a gear, or at the outside of a ring.

ISO 6336-3 (rim thickness factor Y_B) counts it in tooth heights for gears and in normal modules for
rings: above 1.2, or 3.5, the rim has no influence on the root stress; 0.5, or 1.75, is to be
avoided. The same limits hold for transmission errors and root stresses of gears of 12 to 80 teeth,
relative to those with the same teeth in one piece with their shaft (bore a quarter of the root
circle):

    rim, h_t                             1.2             0.5             0.2
    held: peak to peak TE             0.97-1.00       0.92-0.96       0.88-0.92
    held: tension in the root         1.00            0.92-0.98       0.84-0.92
    free over held, peak to peak TE    1.0-1.7         1.3-10          4.4-111

Below 0.5 h_t, a held rim is neither a gear on its shaft (errors of 8 to 16 % at 0.2) nor a hollow
gear. On a ring of 60 teeth and 1.75 m_n, the last ratio is 4.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies import SectorMesh

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flankload.bodies import Body

#: Thickness from which on the rim has no influence, and least one, by kind of body.
LEAST_RIMS = {"gear": (1.2, 0.5), "ring": (3.5, 1.75)}


@dataclass(frozen=True)
class Rim:
    """The rim of a body that is held behind it.

    Attributes
    ----------
    thickness_mm : float
        From the root circle to the bore, or to the outside of a ring.
    ratio : float
        Thickness over the tooth height, of a ring over the normal module.
    unit : str
        Name of the unit of the ratio.
    enough, least : float
        Limits of the ratio (`LEAST_RIMS`).
    held_at, support : str
        Keys of the diameter and of the support.
    """

    thickness_mm: float
    ratio: float
    unit: str
    enough: float
    least: float
    held_at: str
    support: str


def held_rim(body: Body) -> Rim | None:
    """Rim of an elastic gear or ring that is held behind it; None for other bodies."""
    involute, mesh = body.involute, body.mesh
    if involute is None or body.kind not in LEAST_RIMS:
        return None
    if not isinstance(mesh, SectorMesh) or mesh.has_free_bore:
        return None
    thickness = abs(involute.root_radius_mm - body.bore_radius_mm)
    if body.kind == "gear":
        height = involute.tip_radius_mm - involute.root_radius_mm
        keys = ("tooth heights", *LEAST_RIMS["gear"], "bore_diameter_mm", "bore")
        return Rim(thickness, thickness / height, *keys)
    radius = involute.reference_radius_mm
    twist = body.axial.twist_rad_per_mm
    module = 2.0 * radius / body.teeth / float(np.hypot(1.0, twist * radius))
    keys = ("modules", *LEAST_RIMS["ring"], "outer_diameter_mm", "rim")
    return Rim(thickness, thickness / module, *keys)


def rim_notes(names: Sequence[str], bodies: Sequence[Body]) -> Iterator[str]:
    """Warnings about rims that would bend if they were not held."""
    for name, body in zip(names, bodies, strict=True):
        rim = held_rim(body)
        if rim is not None and rim.ratio < rim.enough:
            remedy = f'{name}.{rim.support} = "torque" holds only its mean motion'
            if body.axial.flexible is not None:
                remedy = f"on a pinion shaft, half the root diameter suits {name}.{rim.held_at}"
            yield (
                f"{name}: the rim of {rim.thickness_mm:.3g} mm is {rim.ratio:.2f} {rim.unit}, "
                f"below {rim.enough:g}: held, it cannot bend ({remedy})"
            )
