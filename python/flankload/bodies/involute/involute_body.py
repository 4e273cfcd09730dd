"""Bodies with involute teeth: gears, rings, spline shafts and hubs."""

from __future__ import annotations

from math import pi, radians, tan
from typing import TYPE_CHECKING

from msgspec import structs

from flankload.bodies.body import Body, Material, checked_pitch_errors
from flankload.bodies.involute.free_bore import with_free_bore
from flankload.bodies.involute.region_mesh import with_regions
from flankload.bodies.involute.ring_mesh import ring_mesh
from flankload.bodies.involute.sector_mesh import sector_mesh
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.bodies.profile.ring_profile import ring_profile
from flankload.errors import SceneError
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.bodies.body import SectorMesh
    from flankload.bodies.profile.tooth_profile import ToothProfile
    from flankload.scene import Gear, Ring, SplineHub, SplineShaft


def build_involute_body(
    spec: Gear | Ring | SplineShaft | SplineHub,
    key: str,
    *,
    flank_element_mm: float,
    flank_nodes_mm: float | None = None,
    regions: tuple[str, ...] = (),
    width_mm: float | None = None,
) -> Body:
    """Build a body with involute teeth, held at its bore or at the outside of its rim.

    The reference radius of a spline is its pitch radius, that of other bodies the base radius.
    Parameters as for `build_body`; `regions`: those behind the rim, from the teeth on; `width_mm`:
    of the body, if it has one.

    Raises
    ------
    SceneError
        If the body is impossible or cannot be meshed; names the key.
    """
    from flankload.scene.gear import Ring
    from flankload.scene.spline import SplineHub

    lengths = (flank_element_mm, flank_nodes_mm)
    if isinstance(spec, Ring | SplineHub):
        profile, rim_radius, mesh = _inward(spec, key, lengths, regions)
    else:
        fixed_over = None if spec.has_free_bore else width_mm
        profile, rim_radius, mesh = _outward(spec, key, lengths, regions, fixed_over)
    if mesh is not None and spec.has_free_bore:
        mesh = with_free_bore(mesh)
    involute = profile.involute
    return Body(
        kind=spec.kind,
        curve=profile.curve,
        teeth=profile.teeth,
        material=Material(spec.young_modulus_MPa, spec.poisson_ratio),
        rigid=spec.rigid,
        mesh=mesh,
        mode_range_mm=profile.mode_range_mm,
        reference_radius_mm=involute.reference_radius_mm
        if spec.conforms
        else involute.base_radius_mm,
        involute=involute,
        pitch_errors_um=checked_pitch_errors(spec.pitch_errors_um, profile.teeth, key),
        outline=profile.outline(),
        bore_radius_mm=rim_radius,
    )


def _outward(
    spec: Gear | SplineShaft,
    key: str,
    lengths: tuple[float, float | None],
    regions: tuple[str, ...],
    width_mm: float | None,
) -> tuple[ToothProfile, float, SectorMesh | None]:
    """Profile, bore radius and mesh of a body with external teeth, fixed over `width_mm`."""
    from flankload.scene.gear import Gear
    from flankload.scene.spline import SplineShaft

    if isinstance(spec, SplineShaft):
        _check_root(spec, key)
    profile, bore_radius = gear_profile(spec, key), 0.5 * spec.bore_diameter_mm
    if bore_radius >= profile.involute.root_radius_mm:
        expected = f"less than the root diameter {2 * profile.involute.root_radius_mm:.4f}"
        refuse(f"{key}.bore_diameter_mm", expected, f"{spec.bore_diameter_mm:g}")
    if not isinstance(spec, Gear):
        mesh = None
        if not spec.rigid:
            mesh = sector_mesh(profile, bore_radius, lengths, key, width_mm=width_mm)
        return profile, bore_radius, mesh
    radii = spec.region_radii(profile.involute.root_radius_mm, key)
    if spec.rigid:
        return profile, bore_radius, None
    if not regions:
        mesh = sector_mesh(profile, bore_radius, lengths, key, width_mm=width_mm)
        return profile, bore_radius, mesh
    below = [(name, radii[name]) for name in regions]
    inner_key = spec.region_diameter_key(regions[0])
    rim = sector_mesh(profile, radii[regions[0]], lengths, key, inner_key=inner_key)
    return profile, bore_radius, with_regions(rim, bore_radius, below, lengths[0])


def _inward(
    spec: Ring | SplineHub,
    key: str,
    lengths: tuple[float, float | None],
    regions: tuple[str, ...],
) -> tuple[ToothProfile, float, SectorMesh | None]:
    """Profile, outer radius and mesh of a body with internal teeth."""
    from flankload.scene.spline import SPLINE_FILLET, SplineHub

    if isinstance(spec, SplineHub) and spec.root_fillet_radius_mm is None:
        spec = structs.replace(spec, root_fillet_radius_mm=SPLINE_FILLET * spec.module_mm)
    profile, outer_radius = ring_profile(spec, key), 0.5 * spec.outer_diameter_mm
    radii = (
        {}
        if isinstance(spec, SplineHub)
        else spec.region_radii(profile.involute.root_radius_mm, key)
    )
    if spec.rigid:
        return profile, outer_radius, None
    if not regions:
        return profile, outer_radius, ring_mesh(profile, outer_radius, lengths, key)
    behind = [(name, radii[name]) for name in regions]
    rim = ring_mesh(profile, radii[regions[0]], lengths, key)
    return profile, outer_radius, with_regions(rim, outer_radius, behind, lengths[0])


def _check_root(spec: SplineShaft, key: str) -> None:
    """Check that the rack of a root circle has a positive depth and a land at its tip."""
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
