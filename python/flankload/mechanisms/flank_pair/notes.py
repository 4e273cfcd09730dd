"""Warnings of a result: conditions under which its numbers are less accurate than usual."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE
from flankload.contact.conforming import touches_over_height
from flankload.contact.status import SiteCorner
from flankload.pairing.node_spacing import wide_nodes_notes
from flankload.result.corners import corner_notes
from flankload.scene.discretization import elements_for_modes

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.flank_pair.stages import Compliances
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.result import Result

#: Largest rotation of body 1 under load for small deformations, in pitches, or in radians without
#: pitches. On FZG type C pairs of softer materials, finite elements with large displacements rotate
#: further than with small ones by 0.3 % at 0.0067, 0.7 % at 0.016, 1.1 % at 0.031, 1.9 % at 0.061.
SMALL_WIND_UP = 0.02
#: Ratio of `elements_for_modes` to the number of elements that suffices. On 56 gears and rings, 6
#: modes on 10 elements instead of 12, and 7 on 14 instead of 18, had errors of 0.83 and 0.73 % in
#: nine of ten peak pressures; 0.80 and 0.75 % with the full number, 1.1 and 1.2 % with fewer still.
ELEMENT_RESERVE = 1.2


def notes_of_sweep(pair: BodyPair, compliances: Compliances, found: Sweep) -> Iterator[str]:
    """Warnings about the states of a sweep."""
    yield from wide_nodes_notes(
        pair.bodies,
        (compliances[0].modes.nodes, compliances[1].modes.nodes),
        found.torque_Nmm,
        pair.face_width_mm,
    )
    yield from corner_notes(pair, found)
    if found.slices.conforming:
        yield (
            "splines in three dimensions: pressures are means over the common height of the "
            "flanks, without the peaks at its ends (a plane scene has them)"
        )
        if not touches_over_height(pair, compliances, found.torque_Nmm):
            yield (
                "body_1 and body_2 expand so differently that their flanks touch over a part of "
                "the height; slices of splines carry over the whole height (a plane scene has both)"
            )
    shaped = int(np.count_nonzero((found.site_corner == SiteCorner.NOT_PARABOLIC).any(axis=1)))
    if shaped:
        yield (
            f"contact ends at a kink, a rounding or an edge of a flank at "
            f"{_positions(shaped, found.status.size)}; pressures there are Hertz values and may be "
            "up to twice as high"
            + (' (effects.contact = "pairs" resolves them)' if pair.slices.plane else "")
        )
    left_out = np.flatnonzero((found.site_corner == SiteCorner.END_WOULD_TOUCH).any(axis=1))
    if left_out.size:
        yield (
            f"a tip or fillet that effects.tip_contact = false excludes would touch at "
            f"{_positions(left_out.size, found.status.size)}; the rotation there is too large"
        )
    for z in (0, 1):
        yield from _notes_of_body(pair, compliances[z], found, z)


def _notes_of_body(
    pair: BodyPair, compliance: BodyCompliance, found: Sweep, z: int
) -> Iterator[str]:
    """Warnings about the modes and the flanks of one body."""
    body = pair.bodies[z]
    modes = compliance.flank_modes if compliance.modes.nodes is None else 0
    wanted = _wanted_elements(body, modes)
    if body.mesh is not None and wanted > ELEMENT_RESERVE * body.mesh.flank_elements:
        yield (
            f"{modes} pressure modes on the {body.mesh.flank_elements} flank elements of "
            f"body_{z + 1}: they need {wanted} elements; fewer increase the error, mainly that of "
            "pressures at tip roundings"
        )
    alone = _beside_absent_teeth(pair, found) if body.named_teeth else []
    if alone:
        yield (
            f"teeth of body_{z + 1} next to the loaded pairs {', '.join(map(str, alone))} may "
            "carry load, but have no flank in its file: name their flanks"
        )
    low = body.mode_range_mm[0]
    places = found.pairs.column(f"s_{z + 1}")
    below = (places < low - TIE * body.curve.length_mm) & (found.pairs.column("force") > 0)
    if below.any():
        deepest = low - float(places[below].min())
        yield (
            f"contact reaches {deepest:.3f} mm below the active flank of body_{z + 1}; the "
            "compliance of the lower end of the flank is used there"
            + (", and its root stress" if compliance.root is not None else "")
        )


def _positions(count: int, total: int) -> str:
    """How many of the positions, in words."""
    if count == total:
        return "all positions" if total > 1 else "the position"
    return f"{count} of {total} positions"


def notes_of_result(result: Result, pair: BodyPair) -> Iterator[str]:
    """Warnings about the rotation and gaps of a result."""
    yield from _large_wind_up(result)
    if result.coast is None and any(job.body_load is not None for job in pair.jobs):
        yield from _overlaps(result)


def _wanted_elements(body: Body, modes: int) -> int:
    """Flank elements required by the modes; cam profiles always have enough."""
    if body.modes_factor > 1.0 or body.curve.closed:
        return 2 * (modes - 1)
    return elements_for_modes(modes)


def _beside_absent_teeth(pair: BodyPair, found: Sweep) -> list[int]:
    """Loaded pairs next to a pair that is not modelled."""
    sites = pair.pairing.sites
    loaded = sites[(found.site_force_N > 0).any(axis=0)]
    return [int(j) for j in loaded if not np.isin([j - 1, j + 1], sites).all()]


def _wind_up_rad(result: Result) -> NDArray[np.float64]:
    """Lower bound of the rotation of body 1 by the torque.

    A contact gets stiffer as the torque increases, so torque divided by tangent stiffness is a
    lower bound.
    """
    stiffness = result.stiffness_tangent_Nm_per_rad
    turned_rad = np.zeros_like(stiffness)
    np.divide(result.torque_Nm, stiffness, out=turned_rad, where=stiffness > 0)
    return turned_rad


def _large_wind_up(result: Result) -> Iterator[str]:
    """Warn if the bodies deform too far for a theory of small deformations."""
    unit = min(result.pitch_rad, 1.0)
    part = float(_wind_up_rad(result).max(initial=0.0)) / unit
    if part > SMALL_WIND_UP:
        of = "a pitch" if unit < 1.0 else "a radian"
        yield (
            f"the torque turns body 1 by at least {part:.2g} of {of}, expected at most "
            f"{SMALL_WIND_UP:g}: the model assumes small deformations and contact at the places "
            "without load (reduce the torque, or use stiffer bodies; flankload verify "
            "--large-displacement includes the deformed geometry)"
        )


def _overlaps(result: Result) -> Iterator[str]:
    """Warn if expansion makes coast flanks overlap without torque."""
    gap_um = result.coast_flank_gap_um
    if gap_um is None:
        return
    opened_um = 1000.0 * result.reference_radius_mm * _wind_up_rad(result)
    overlap_um = np.nanmax(opened_um - gap_um, initial=0.0)
    if overlap_um > 0.0:
        yield (
            "the expansion closes the backlash: without torque, coast flanks would overlap by at "
            f"least {overlap_um:.1f} um, which this run ignores (effects.coast_flank = true "
            "includes them)"
        )
