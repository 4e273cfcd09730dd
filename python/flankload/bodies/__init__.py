"""Bodies: flank curve, sector mesh and material from the keys of a scene; one module per kind."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flankload.bodies.body import Body, Material, SectorMesh, WholeMesh

if TYPE_CHECKING:
    from flankload.scene import BodySpec, Cam, Follower

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
) -> Body:
    """Build the body that a table of a scene describes.

    Parameters
    ----------
    spec : Gear, Ring, SplineShaft, SplineHub, Cam, Follower, MeshBody or ComplianceBody
    key : str
        Dotted path of the table in the scene, for messages.
    folder : Path
        Folder to which the bodies' files are relative.
    flank_element_mm : float or None
        Largest length of a finite element along the flank of a parametric body.
    flank_element_parts : float
        The same in modules, if `flank_element_mm` is None; for cams and followers, which have no
        module, the number of elements along the flank is scaled in proportion.
    flank_nodes_mm : float, optional
        Largest distance of the flank's nodes, if nodal forces need finer elements there than
        elsewhere.

    Returns
    -------
    Body

    Raises
    ------
    SceneError
        If the body is impossible; names the key. MeshError or ComplianceFileError if a file is
        faulty.
    """
    from flankload.scene import (
        Belt,
        Cam,
        Chain,
        ComplianceBody,
        Follower,
        MeshBody,
        Pulley,
        SplineHub,
        SplineShaft,
        Sprocket,
    )

    assert not isinstance(spec, Sprocket | Chain | Pulley | Belt)  # built by their drives
    if isinstance(spec, ComplianceBody):
        from flankload.bodies.imported.compliance_body import build_compliance_body

        return build_compliance_body(spec, key, folder=folder)
    if isinstance(spec, MeshBody):
        from flankload.bodies.imported.mesh_body import build_mesh_body

        return build_mesh_body(spec, key, folder=folder)
    if isinstance(spec, Cam | Follower):
        return _build_cam_or_follower(
            spec, key, folder, flank_element_mm, DEFAULT_PARTS / flank_element_parts
        )
    if flank_element_mm is None:
        flank_element_mm = flank_element_parts * spec.module_mm
        if isinstance(spec, SplineShaft | SplineHub):
            flank_element_mm *= SPLINE_PART
    from flankload.bodies.involute.involute_body import build_involute_body

    return build_involute_body(
        spec, key, flank_element_mm=flank_element_mm, flank_nodes_mm=flank_nodes_mm
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
