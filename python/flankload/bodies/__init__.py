"""Bodies from the keys of a scene: flank curve, mesh and material; one module per kind."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.bodies.axial_shape import axial_shape
from flankload.bodies.body import Body, Material, SectorMesh, WholeMesh
from flankload.bodies.flank_surface import flank_surface
from flankload.scene import Cam, ComplianceBody, Follower, MeshBody
from flankload.scene.axial import axial_range
from flankload.scene.discretization import DEFAULT
from flankload.scene.drive import DriveTable
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.scene import BodySpec, Gear, Ring, SplineHub, SplineShaft

__all__ = ["Body", "Material", "SectorMesh", "WholeMesh", "build_body"]


#: Length of flank elements of splines over that of gears, whose flanks are twice as high.
SPLINE_ELEMENT_FACTOR = 0.45


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
    """Build a body from its table of a scene.

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

    Raises
    ------
    SceneError
        If the body is impossible, with the key; MeshError, ComplianceFileError for a faulty file.
    """
    assert not isinstance(spec, DriveTable)  # built by their drives
    if isinstance(spec, Cam | Follower):
        length, finer = flank_element_mm, DEFAULT.flank_element_parts / flank_element_parts
        if isinstance(spec, Follower):
            from flankload.bodies.cam.follower import build_follower

            return build_follower(spec, key, flank_element_mm=length, fineness=finer)
        from flankload.bodies.cam.cam import build_cam

        return build_cam(spec, key, folder=folder, flank_element_mm=length, fineness=finer)
    ends = None if pair_width_mm is None else axial_range(spec, pair_width_mm, key)
    if isinstance(spec, ComplianceBody):
        from flankload.bodies.imported.compliance_body import build_compliance_body

        body = build_compliance_body(spec, key, folder=folder, ends_mm=ends)
    elif isinstance(spec, MeshBody):
        from flankload.bodies.imported.mesh_body import build_mesh_body

        body = build_mesh_body(spec, key, folder=folder)
    else:
        from flankload.bodies.involute.involute_body import build_involute_body

        if flank_element_mm is None:
            flank_element_mm = flank_element_parts * spec.module_mm
            flank_element_mm *= SPLINE_ELEMENT_FACTOR if spec.conforms else 1.0
        body = build_involute_body(
            spec,
            key,
            flank_element_mm=flank_element_mm,
            flank_nodes_mm=flank_nodes_mm,
            regions=() if ends is None else tuple(name for name, _ in spec.regions_of(ends)),
            width_mm=None if ends is None else ends[1] - ends[0],
        )
    return body if ends is None else _along_axis(body, spec, key, folder, ends)


def _along_axis(
    body: Body,
    spec: Gear | Ring | SplineShaft | SplineHub | MeshBody | ComplianceBody,
    key: str,
    folder: Path,
    ends: tuple[float, float],
) -> Body:
    """The body with its shape along the axis.

    A mirrored helical mesh is refused, since mirroring reverses its hand.
    """
    if isinstance(spec, ComplianceBody):
        radius_mm = body.reference_radius_mm  # without a helix angle: the twist is that of the file
    elif isinstance(spec, MeshBody):
        radius_mm = spec.helix_radius_mm
        if body.mirrored and spec.helix_angle_deg:
            expected = f"a flank that faces counter-clockwise, since there is a {key}."
            expected += "helix_angle_deg"
            refuse(f"{key}.flank_set", expected, f"one that faces clockwise in {spec.file}")
    else:
        assert body.involute is not None
        radius_mm = body.involute.reference_radius_mm
    surface = flank_surface(spec, key, body, folder=folder, width_mm=ends[1] - ends[0])
    shape, notes = axial_shape(spec, ends, radius_mm, surface), surface.notes if surface else ()
    if isinstance(spec, ComplianceBody):
        shape = replace(shape, twist_rad_per_mm=body.axial.twist_rad_per_mm)
    elements = None if body.elements is None else replace(body.elements, axial=shape)
    return replace(body, axial=shape, elements=elements, notes=(*body.notes, *notes))
