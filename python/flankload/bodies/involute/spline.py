"""Bodies of kinds "spline_shaft" and "spline_hub": a gear with short teeth and a ring around it."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians, tan
from typing import TYPE_CHECKING

from msgspec import structs

from flankload.bodies.involute.gear import outward_body
from flankload.bodies.involute.ring import inward_body
from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.bodies.body import Body
    from flankload.scene import SplineHub, SplineShaft


def build_spline_shaft(
    spec: SplineShaft, key: str, *, flank_element_mm: float, flank_nodes_mm: float | None = None
) -> Body:
    """Build the shaft of a spline.

    Parameters
    ----------
    spec : SplineShaft
        Keys of the shaft.
    key : str
        Key of the body in the scene, for messages.
    flank_element_mm : float
        Largest length of a finite element along the flank; not used for a rigid body.
    flank_nodes_mm : float, optional
        Largest distance of the flank's nodes, if nodal forces need finer elements there than
        elsewhere.

    Returns
    -------
    Body

    Raises
    ------
    SceneError
        If the shaft is impossible or cannot be meshed; names the key.
    """
    _check_root(spec, key)
    return _by_pitch_radius(
        outward_body(spec, key, flank_element_mm=flank_element_mm, flank_nodes_mm=flank_nodes_mm)
    )


def build_spline_hub(
    spec: SplineHub, key: str, *, flank_element_mm: float, flank_nodes_mm: float | None = None
) -> Body:
    """Build the hub of a spline; see `build_spline_shaft`."""
    from flankload.scene.gear import SPLINE_FILLET

    radius = spec.root_fillet_radius_mm
    if radius is None:
        radius = SPLINE_FILLET * spec.module_mm
    spec = structs.replace(spec, root_fillet_radius_mm=radius)
    return _by_pitch_radius(
        inward_body(spec, key, flank_element_mm=flank_element_mm, flank_nodes_mm=flank_nodes_mm)
    )


def _by_pitch_radius(body: Body) -> Body:
    """The body with transmission errors measured on its pitch circle."""
    assert body.involute is not None
    return replace(body, reference_radius_mm=body.involute.reference_radius_mm)


def _check_root(spec: SplineShaft, key: str) -> None:
    """Check that the rack for the root circle has a positive depth and a land at its tip."""
    pitch_diameter = spec.teeth * spec.module_mm
    deepest = 0.25 * pi / tan(radians(spec.pressure_angle_deg))
    largest = pitch_diameter + 2 * spec.profile_shift * spec.module_mm
    least = largest - 2 * deepest * spec.module_mm
    if not max(least, 0.0) < spec.root_diameter_mm < min(largest, spec.tip_diameter_mm):
        raise SceneError(
            key=f"{key}.root_diameter_mm",
            expected=f"more than {max(least, 0.0):.4f}, where the generating rack is pointed, and "
            f"less than {min(largest, spec.tip_diameter_mm):.4f}, "
            + (
                f"{key}.tip_diameter_mm"
                if spec.tip_diameter_mm <= largest
                else "where the rack does not cut below its pitch line"
            ),
            found=f"{spec.root_diameter_mm:g}",
        )
