"""Rows of `flankload check`, and the meshes of `flankload mesh`."""

from __future__ import annotations

from math import atan
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies import SectorMesh, WholeMesh
from flankload.bodies.profile.tooth_thickness import measurements
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.premises import broken_by_geometry
from flankload.mechanisms.premises import require_premises
from flankload.mechanisms.protocol import Description
from flankload.meshes.report import quality_rows
from flankload.pairing.gear_pair import describe_gears
from flankload.pairing.spline_fit import describe_fit
from flankload.scene.effects import EFFECTS, switches_of

if TYPE_CHECKING:
    from flankload.bodies import Body
    from flankload.bodies.profile.involute import Involute
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import BodySpec, Scene
    from flankload.scene.effects import Switch


def describe(scene: Scene) -> Description:
    """Describe bodies, pairing and effects; raises a SceneError if they are impossible."""
    pair = build_bodies(scene)
    for body in pair.bodies:
        if body.imported is not None:
            compliance_of(body, scene)  # checks the file at negligible cost
    switches = switches_of(scene)
    has_teeth = pair.pairing.motion is None
    effects = [row for row in EFFECTS if has_teeth or not row.of_teeth]
    rows = {
        f"body_{number}: {body.kind}": rows_of_body(body, spec)
        for number, (body, spec) in enumerate(
            zip(pair.bodies, (scene.body_1, scene.body_2), strict=True), start=1
        )
    }
    rows["pair"] = _rows_of_pair(scene, pair)
    rows["effects"] = [(row.title, _said(switches[row.name])) for row in effects]
    broken = require_premises(scene, broken_by_geometry(pair))
    return Description(rows, (*pair.notes, *(one.note for one in broken)))


def _rows_of_pair(scene: Scene, pair: BodyPair) -> list[tuple[str, str]]:
    gears, fit = pair.pairing.gear_geometry, pair.pairing.fit
    return [
        ("offset" if fit else "centre distance", f"{scene.pair.axes_apart_mm:.8g} mm"),
        ("face width", f"{pair.face_width_mm:g} mm"),
        *(describe_gears(gears) if gears is not None else ()),
        *(describe_fit(fit) if fit is not None else ()),
    ]


def _said(switch: Switch) -> str:
    return f"{'yes' if switch.on else 'no'} ({switch.because})"


def rows_of_body(body: Body, spec: BodySpec) -> list[tuple[str, str]]:
    """Rows of a body."""
    rows = [] if body.kind in ("cam", "follower") else [("teeth", f"{body.teeth}")]
    involute = body.involute
    if involute is not None:
        for name, radius in (
            ("root", involute.root_radius_mm),
            ("form", involute.form_radius_mm),
            ("base", involute.base_radius_mm),
            ("tip", involute.tip_radius_mm),
        ):
            rows.append((f"{name} diameter", f"{2 * radius:.4f} mm"))
        tip = involute.tip_radius_mm
        rows.append(
            ("tooth thickness at tip", f"{2 * tip * involute.tooth_half_angle_at(tip):.4f} mm")
        )
        rows += _rows_of_thickness(body, involute, spec)
    elif body.curve.closed:
        radii = np.hypot(*body.outline.T)
        rows += [
            ("profile", f"{body.curve.length_mm:.4f} mm around"),
            ("radii of the profile", f"{radii.min():.4f} to {radii.max():.4f} mm"),
        ]
    else:
        rows.append(("reference radius", f"{body.reference_radius_mm:g} mm"))
    if body.imported is not None:
        return [*rows, ("compliance", body.imported.description)]
    if body.mesh is None:
        return [*rows, ("mesh", "none: rigid")]
    return [*rows, *_rows_of_mesh(body)]


def _rows_of_thickness(body: Body, involute: Involute, spec: BodySpec) -> list[tuple[str, str]]:
    """Measurements of the tooth thickness, without tooth deviations."""
    helix = atan(abs(body.axial.twist_rad_per_mm) * involute.reference_radius_mm)
    named = getattr(spec.flank_keys[1], "span_teeth", None)
    found = measurements(involute, body.teeth, helix, named)
    over = "over" if involute.outward > 0 else "between"
    rows = []
    if found.span_mm is not None:
        teeth = f"{found.span_teeth} {'tooth' if found.span_teeth == 1 else 'teeth'}"
        rows.append(("span measurement", f"{found.span_mm:.4f} mm over {teeth}"))
    balls = f"{found.ball_mm:.4f} mm {over} balls of {found.ball_diameter_mm:g} mm"
    return [*rows, ("measurement by balls", balls)]


def _rows_of_mesh(body: Body) -> list[tuple[str, str]]:
    mesh = body.mesh
    assert mesh is not None
    low, high = (float(np.hypot(*body.curve.point([s])[0])) for s in body.mode_range_mm)
    whole = isinstance(mesh, WholeMesh)
    kinds = ", ".join(f"{len(data)} {kind}" for kind, data in mesh.cells)
    free = isinstance(mesh, SectorMesh) and mesh.has_free_bore
    held = mesh.bore_nodes if isinstance(mesh, SectorMesh) else mesh.fixed_nodes
    rows = [
        ("mesh of the whole body" if whole else "mesh of a sector",
         f"{len(mesh.nodes)} nodes, {kinds}"),
        *quality_rows(mesh.nodes, mesh.cells),
        ("held in the mean" if free else "held",
         f"{held.size} nodes, mean radius {body.bore_radius_mm:.4f} mm"),
        ("flank", f"{mesh.flank_elements} elements"
         + ("" if body.curve.closed else f", radii {low:.4f} to {high:.4f} mm")),
    ]  # fmt: skip
    rows += [(name, f"z from {one:g} to {two:g} mm") for name, (one, two) in body.axial.regions]
    if isinstance(mesh, WholeMesh) and len(mesh.flanks) > 1:
        rows.append(("flanks", f"{len(mesh.flanks)}"))
    if body.flank_nodes is not None:
        nodes = body.flank_nodes
        rows.append(("flank nodes", f"{nodes.count}, up to {nodes.spacing_mm:.3g} mm apart"))
    return rows
