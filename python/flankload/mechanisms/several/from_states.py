"""Conversion of the states of several gear meshes to a result, and of each mesh to its own."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.torque import in_newton_metres, stiffness_Nm_per_rad
from flankload.contact.status import on_corner
from flankload.mechanisms.flank_pair.from_sweep import contact_columns, cost_of, result_of
from flankload.mechanisms.several.estimates import OF_MESHES
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.gear_pair import cosine_base_helix
from flankload.result.geometry import pair_geometry
from flankload.result.pairs import DrawnBody, PairDrawing, PairTable, PairTables
from flankload.result.result import Result

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.several.states import AnyAssembly
    from flankload.result.stage import StageLoads
    from flankload.result.train import TwoMeshes
    from flankload.scene import Scene


def result_of_mesh(
    scene: Scene,
    assembly: AnyAssembly,
    compliances: Compliances,
    found: MeshesSweep,
    estimates: Sequence[Mapping[str, object]],
    m: int,
) -> Result:
    """Ordinary result of a mesh, at its own positions; `estimates`: of all meshes, or empty."""
    pairing = assembly.pairing
    mesh, own_mesh = pairing.meshes[m], assembly.meshes[m]
    one, two = (pairing.tables[b] for b in mesh.members)
    if pairing.is_image(m):  # teeth of the mirror image run clockwise
        first, second = mesh.pairing.site_teeth
        teeth = -first % own_mesh.body_1.teeth, -second % own_mesh.body_2.teeth
        own_mesh = replace(own_mesh, pairing=replace(mesh.pairing, site_teeth=teeth))
    pair = BodyPair(
        **vars(own_mesh),
        jobs=(assembly.jobs[one], assembly.jobs[two]),
        discretization=assembly.discretization,
        effects=assembly.effects,
        position_rad=mesh.positions(assembly.position_rad),
        pitches=assembly.pitches,
        closed=assembly.closed,
        adaptive=False,
        notes=(),
    )
    own = compliances[one], compliances[two]
    if pairing.is_image(m):
        own = _with_image_of_roots(own[0]), _with_image_of_roots(own[1])
    result = result_of(
        scene,
        pair,
        own,
        found.meshes[m],
        estimate=estimates[m] if estimates else None,
        geometry=pair_geometry(pair, own),
    )
    return replace(
        result,
        name=f"{scene.name}: {pairing.title(m)}",
        stiffness_tangent_Nm_per_rad=np.full(assembly.position_rad.size, np.nan),
        warnings=(),
    )


def _with_image_of_roots(compliance: BodyCompliance) -> BodyCompliance:
    """A compliance whose root stress is that by loads on coast flanks."""
    root = compliance.root
    return compliance if root is None else replace(compliance, root=root.in_mirror_image())


def result_of_meshes(
    scene: Scene,
    assembly: AnyAssembly,
    compliances: Compliances,
    found: MeshesSweep,
    estimate: Mapping[str, object] | None,
    drive: StageLoads | TwoMeshes,
) -> Result:
    """Result of a torque; `drive`: its quantities that only this kind of drive has."""
    pairing, whole = assembly.pairing, found.whole
    return Result(
        name=scene.name,
        torque_Nm=in_newton_metres(whole.torque_Nmm),
        sites=np.arange(1, len(pairing.site_meshes) + 1),
        position_rad=assembly.position_rad,
        rotation_rad=whole.rotation_rad,
        reference_radius_mm=assembly.bodies[0].reference_radius_mm,
        site_force_N=whole.site_force_N,
        peak_pressure_MPa=whole.site_peak_N_per_mm / assembly.slices[0].compliance_width_mm,
        stiffness_tangent_Nm_per_rad=stiffness_Nm_per_rad(whole.tangent_rad_per_Nmm),
        status=whole.status,
        pair_tables=PairTables(assembly.position_rad.size, partial(_contacts, assembly, found)),
        corner_contact=on_corner(whole.site_corner),
        pitch_rad=pairing.pitch_rad,
        period_rad=assembly.period_rad,
        closed=assembly.closed,
        face_width_mm=assembly.face_width_mm,
        estimate=None
        if estimate is None
        else {name: part for name, part in estimate.items() if name != OF_MESHES},
        cost=cost_of(whole, compliances),
        warnings=assembly.notes,
        drawing=_drawing(assembly),
        drive=drive,
    )


def _contacts(assembly: AnyAssembly, found: MeshesSweep, p: int) -> PairTable:
    """Contact pairs of all meshes at a position, in the common frame."""
    pairing, tables = assembly.pairing, []
    sites = {m: site for site, meshes in enumerate(pairing.site_meshes) for m in meshes}
    for m, mesh in enumerate(pairing.meshes):
        pairs, gears = found.meshes[m].pairs, assembly.meshes[m]
        column = pairs.columns_at(p)
        own = mesh.in_common_frame(np.column_stack([column["x"], column["y"]]))
        own = own + pairing.axes_mm[mesh.members[0]]
        normal = mesh.in_common_frame(np.column_stack([column["normal_x"], column["normal_y"]]))
        tables.append(
            {
                "site": np.full(len(own), sites[m] + 1),
                "radius_mm": np.hypot(*own.T),
                "x_mm": own[:, 0],
                "y_mm": own[:, 1],
                "normal_x": normal[:, 0],
                "normal_y": normal[:, 1],
                # contact lines are inclined by the base helix angle
                **contact_columns(
                    column, gears.slices, pairs.slices_at(p), 1.0 / cosine_base_helix(gears.body_1)
                ),
            }
        )
    return PairTable(**{name: np.concatenate([t[name] for t in tables]) for name in tables[0]})


def _drawing(assembly: AnyAssembly) -> PairDrawing:
    """The bodies at their angles."""
    pairing = assembly.pairing
    second, angles = pairing.drawn_second, pairing.body_angles(assembly.position_rad).T
    bodies = [assembly.bodies[table] for table in pairing.tables]
    one, two = bodies[0], bodies[second]
    between = tuple(
        DrawnBody(1, body.outline, body.teeth, angle, body.bore_radius_mm, axis)
        for b, (body, angle, axis) in enumerate(zip(bodies, angles, pairing.axes_mm, strict=True))
        if b not in {0, second}
    )
    return PairDrawing(
        outline_1=one.outline,
        outline_2=two.outline,
        teeth_1=one.teeth,
        teeth_2=two.teeth,
        center_distance_mm=float(pairing.axes_mm[second, 0]),
        angle_1=angles[0],
        angle_2=angles[second],
        bore_radius_1_mm=one.bore_radius_mm,
        bore_radius_2_mm=two.bore_radius_mm,
        between=between,
    )
