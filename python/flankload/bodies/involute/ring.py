"""Bodies of kind "ring": an internal spur gear, fixed at the outside of its rim."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.bodies.body import Body, Material, checked_pitch_errors
from flankload.bodies.involute.ring_mesh import ring_mesh
from flankload.bodies.profile.ring_profile import ring_profile

if TYPE_CHECKING:
    from flankload.scene import Ring, SplineHub


def build_ring(
    spec: Ring, key: str, *, flank_element_mm: float, flank_nodes_mm: float | None = None
) -> Body:
    """Build a ring.

    Parameters
    ----------
    spec : Ring
        Keys of the ring.
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
        If the ring is impossible or cannot be meshed; names the key.
    """
    return inward_body(spec, key, flank_element_mm=flank_element_mm, flank_nodes_mm=flank_nodes_mm)


def inward_body(
    spec: Ring | SplineHub,
    key: str,
    *,
    flank_element_mm: float,
    flank_nodes_mm: float | None = None,
) -> Body:
    """Build a body with internal teeth, fixed at its rim; see `build_ring`."""
    profile = ring_profile(spec, key)
    outer_radius = 0.5 * spec.outer_diameter_mm
    mesh = None
    if not spec.rigid:
        mesh = ring_mesh(
            profile,
            outer_radius_mm=outer_radius,
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
        bore_radius_mm=outer_radius,
    )
