"""Bodies of kind "gear": an external spur gear, fixed at its bore."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.bodies.body import Body, Material, checked_pitch_errors
from flankload.bodies.involute.sector_mesh import sector_mesh
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.scene import Gear, SplineShaft


def build_gear(
    spec: Gear, key: str, *, flank_element_mm: float, flank_nodes_mm: float | None = None
) -> Body:
    """Build a gear.

    Parameters
    ----------
    spec : Gear
        Keys of the gear.
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
        If the gear is impossible or cannot be meshed; names the key.
    """
    return outward_body(spec, key, flank_element_mm=flank_element_mm, flank_nodes_mm=flank_nodes_mm)


def outward_body(
    spec: Gear | SplineShaft,
    key: str,
    *,
    flank_element_mm: float,
    flank_nodes_mm: float | None = None,
) -> Body:
    """Build a body with external teeth, fixed at its bore; see `build_gear`."""
    profile = gear_profile(spec, key)
    bore_radius = 0.5 * spec.bore_diameter_mm
    if bore_radius >= profile.involute.root_radius_mm:
        raise SceneError(
            key=f"{key}.bore_diameter_mm",
            expected=f"less than the root diameter {2 * profile.involute.root_radius_mm:.4f}",
            found=f"{spec.bore_diameter_mm:g}",
        )
    mesh = None
    if not spec.rigid:
        mesh = sector_mesh(
            profile,
            bore_radius_mm=bore_radius,
            flank_element_mm=flank_element_mm,
            key=key,
            flank_nodes_mm=flank_nodes_mm,
        )
    return Body(
        kind=spec.kind,
        curve=profile.curve,
        teeth=profile.teeth,
        material=Material(spec.young_modulus_MPa, spec.poisson_ratio),
        rigid=spec.rigid,
        mesh=mesh,
        mode_range_mm=profile.mode_range_mm,
        reference_radius_mm=profile.involute.base_radius_mm,
        involute=profile.involute,
        flank_angle_known=True,
        pitch_errors_um=checked_pitch_errors(spec.pitch_errors_um, profile.teeth, key),
        outline=profile.outline(),
        bore_radius_mm=bore_radius,
    )
