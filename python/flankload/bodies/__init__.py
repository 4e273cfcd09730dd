"""Bodies: flank curve, sector mesh and material from the keys of a scene; one module per kind."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.bodies.axial_shape import axial_shape
from flankload.bodies.body import Body, Material, SectorMesh, WholeMesh
from flankload.bodies.flank_surface import flank_surface
from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.scene import (
        BodySpec,
        Cam,
        ComplianceBody,
        Follower,
        Gear,
        MeshBody,
        Ring,
        SplineHub,
        SplineShaft,
    )

__all__ = ["Body", "Material", "SectorMesh", "WholeMesh", "build_body"]


#: `flank_element_parts` of the default discretization.
DEFAULT_PARTS = 1.0 / 4.5
#: Flank elements of splines relative to those of gears: their flanks are about half as high.
SPLINE_PART = 0.45


def build_body(
    spec: BodySpec,
    key: str,
    *,
    folder: Path,
    flank_element_mm: float | None,
    flank_element_parts: float,
    flank_nodes_mm: float | None = None,
    pair_width_mm: float | None = None,
) -> Body:
    """Build the body that a table of a scene describes.

    Parameters
    ----------
    spec : Gear, Ring, SplineShaft, SplineHub, Cam, Follower, MeshBody or ComplianceBody
    key : str
        Dotted path of the table in the scene, for messages.
    folder : Path
        Folder to which files are relative.
    flank_element_mm : float or None
        Largest length of a finite element along the flank of a parametric body.
    flank_element_parts : float
        The same in modules, if `flank_element_mm` is None; scales the number of elements of cams
        and followers, which have no module.
    flank_nodes_mm : float, optional
        Largest distance of the flank's nodes, if nodal forces need finer elements there.
    pair_width_mm : float, optional
        Face width of bodies without one of their own, in a three-dimensional scene.

    Returns
    -------
    Body

    Raises
    ------
    SceneError
        If the body is impossible; names the key. MeshError, ComplianceFileError: a faulty file.
    """
    from flankload.scene import (
        Belt,
        Cam,
        Chain,
        ComplianceBody,
        Follower,
        MeshBody,
        Pulley,
        Sprocket,
    )
    from flankload.scene.axial import axial_range

    assert not isinstance(spec, Sprocket | Chain | Pulley | Belt)  # built by their drives
    if isinstance(spec, ComplianceBody | MeshBody):
        body = _build_imported(spec, key, folder)
        if pair_width_mm is None or isinstance(spec, ComplianceBody):
            return body
        _check_hand(body, spec, key)
        ends = axial_range(spec, pair_width_mm, key)
        return _along_axis(body, spec, key, folder, ends, spec.helix_radius_mm)
    if isinstance(spec, Cam | Follower):
        fineness = DEFAULT_PARTS / flank_element_parts
        return _build_cam_or_follower(spec, key, folder, flank_element_mm, fineness)
    if flank_element_mm is None:
        flank_element_mm = flank_element_parts * spec.module_mm
        flank_element_mm *= SPLINE_PART if spec.conforms else 1.0
    lengths = flank_element_mm, flank_nodes_mm
    return _build_involute(spec, key, folder, lengths, pair_width_mm)


def _build_involute(
    spec: Gear | Ring | SplineShaft | SplineHub,
    key: str,
    folder: Path,
    lengths_mm: tuple[float, float | None],
    pair_width_mm: float | None,
) -> Body:
    """A body with involute teeth; in a three-dimensional scene with its axial shape."""
    from flankload.bodies.involute.involute_body import build_involute_body
    from flankload.scene.axial import axial_range

    element, nodes = lengths_mm
    if pair_width_mm is None:
        return build_involute_body(spec, key, flank_element_mm=element, flank_nodes_mm=nodes)
    ends = axial_range(spec, pair_width_mm, key)
    body = build_involute_body(
        spec,
        key,
        flank_element_mm=element,
        flank_nodes_mm=nodes,
        regions=tuple(name for name, _ in spec.regions_of(ends)),
    )
    assert body.involute is not None
    return _along_axis(body, spec, key, folder, ends, body.involute.reference_radius_mm)


def _along_axis(
    body: Body,
    spec: Gear | Ring | SplineShaft | SplineHub | MeshBody,
    key: str,
    folder: Path,
    ends: tuple[float, float],
    radius_mm: float,
) -> Body:
    """The body with its shape along the axis; the helix angle is that at the radius."""
    surface = flank_surface(spec, key, body, folder=folder, width_mm=ends[1] - ends[0])
    return replace(body, axial=axial_shape(spec, ends, radius_mm, surface))


def _build_imported(spec: ComplianceBody | MeshBody, key: str, folder: Path) -> Body:
    from flankload.scene import MeshBody

    if isinstance(spec, MeshBody):
        from flankload.bodies.imported.mesh_body import build_mesh_body

        return build_mesh_body(spec, key, folder=folder)
    from flankload.bodies.imported.compliance_body import build_compliance_body

    return build_compliance_body(spec, key, folder=folder)


def _check_hand(body: Body, spec: MeshBody, key: str) -> None:
    """Refuse the mirror image of a helical section: its hand would be the other one."""
    if body.mirrored and spec.helix_angle_deg:
        raise SceneError(
            key=f"{key}.flank_set",
            expected=f"a flank that faces counter-clockwise, since there is a {key}."
            "helix_angle_deg",
            found=f"one that faces clockwise in {spec.file}",
        )


def _build_cam_or_follower(
    spec: Cam | Follower, key: str, folder: Path, element_mm: float | None, fineness: float
) -> Body:
    from flankload.scene import Follower

    if isinstance(spec, Follower):
        from flankload.bodies.cam.follower import build_follower

        return build_follower(spec, key, flank_element_mm=element_mm, fineness=fineness)
    from flankload.bodies.cam.cam import build_cam

    return build_cam(spec, key, folder=folder, flank_element_mm=element_mm, fineness=fineness)
