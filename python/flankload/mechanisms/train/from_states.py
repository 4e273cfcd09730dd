"""Conversion of the states of a gear train to its result, and of each mesh to one of its own."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.torque import in_newton_metres, stiffness_Nm_per_rad
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.status import on_corner
from flankload.mechanisms.flank_pair.from_sweep import result_of
from flankload.pairing.body_pair import BodyPair
from flankload.result.geometry import pair_geometry
from flankload.result.pairs import DrawnBody, PairDrawing, PairTable, PairTables
from flankload.result.result import Result
from flankload.result.train import TrainLoads

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.mechanisms.train.assembly import TrainAssembly
    from flankload.mechanisms.train.states import Compliances, TrainStates
    from flankload.scene import Scene


def train_results(
    scene: Scene,
    assembly: TrainAssembly,
    compliances: Compliances,
    states: TrainStates,
    estimates: Sequence[Mapping[str, object] | None],
) -> tuple[Result, ...]:
    """Results, one per torque."""
    return tuple(
        _result(scene, assembly, compliances, found, estimate)
        for found, estimate in zip(states.found, estimates, strict=True)
    )


def _result(
    scene: Scene,
    assembly: TrainAssembly,
    compliances: Compliances,
    found: MeshesSweep,
    estimate: Mapping[str, object] | None,
) -> Result:
    """Result of a torque."""
    every, width = found.whole, assembly.face_width_mm
    counters = every.counters.sum(axis=0, dtype=np.int64).tolist()
    return Result(
        name=scene.name,
        torque_Nm=in_newton_metres(every.torque_Nmm),
        sites=np.array([1, 2]),
        position_rad=assembly.position_rad,
        rotation_rad=every.rotation_rad,
        reference_radius_mm=assembly.bodies[0].reference_radius_mm,
        site_force_N=every.site_force_N,
        peak_pressure_MPa=every.site_peak_N_per_mm / width,
        stiffness_tangent_Nm_per_rad=stiffness_Nm_per_rad(every.tangent_rad_per_Nmm),
        status=every.status,
        pair_tables=PairTables(assembly.position_rad.size, partial(_contacts, assembly, found)),
        corner_contact=on_corner(every.site_corner),
        pitch_rad=assembly.pairing.pitch_rad,
        period_rad=assembly.period_rad,
        closed=assembly.closed,
        face_width_mm=width,
        estimate=estimate,
        cost={
            "positions": every.status.size,
            "of_this_torque": dict(zip(CORE_COUNTERS, counters, strict=True)),
            "fe_degrees_of_freedom": [c.job.degrees_of_freedom for c in compliances],
            "largest_backward_error": float(np.max(every.certificate[:, 0], initial=0.0)),
            "largest_condition": float(np.max(every.certificate[:, 1], initial=0.0)),
        },
        warnings=assembly.notes,
        drawing=_drawing(assembly),
        drive=TrainLoads(
            kind="idler" if assembly.pairing.is_idler else "two_pinions",
            teeth=assembly.pairing.teeth,
            centers_mm=assembly.pairing.axes_mm,
            phases=np.array([mesh.phase for mesh in assembly.pairing.meshes]),
            torque_2_Nm=in_newton_metres(found.resultants[:, 1, 2]),
            torque_3_Nm=in_newton_metres(found.resultants[:, 2, 2]),
            bearing_force_N=found.resultants[:, :, :2],
            orbit_um=1000.0 * found.moved_mm[:, assembly.pairing.common],
            common=assembly.pairing.common + 1,
            meshes=(
                _mesh_result(scene, assembly, compliances, found, 0),
                _mesh_result(scene, assembly, compliances, found, 1),
            ),
        ),
    )


def _contacts(assembly: TrainAssembly, found: MeshesSweep, p: int) -> PairTable:
    """Contact pairs of both meshes at a position; sites are meshes, the frame is the common one."""
    tables = []
    for m, mesh in enumerate(assembly.pairing.meshes):
        column = found.meshes[m].pairs.columns_at(p)
        own = mesh.in_common_frame(np.column_stack([column["x"], column["y"]]))
        own = own + assembly.pairing.axes_mm[mesh.members[0]]
        normal = mesh.in_common_frame(np.column_stack([column["normal_x"], column["normal_y"]]))
        tables.append(
            {
                "site": np.full(len(own), m + 1),
                "radius_mm": np.hypot(*own.T),
                "arc_length_1_mm": column["s_1"],
                "arc_length_2_mm": column["s_2"],
                "x_mm": own[:, 0],
                "y_mm": own[:, 1],
                "normal_x": normal[:, 0],
                "normal_y": normal[:, 1],
                "force_N": column["force"],
                "pressure_MPa": column["force"] / (column["cell"] * assembly.face_width_mm),
                "gap_um": 1000.0 * column["gap"],
                "cell_mm": column["cell"],
            }
        )
    return PairTable(**{name: np.concatenate([t[name] for t in tables]) for name in tables[0]})


def _drawing(assembly: TrainAssembly) -> PairDrawing:
    """The bodies at their angles; the second one drawn is the mate of body 1 on the x axis."""
    pairing, bodies = assembly.pairing, assembly.bodies
    angles = pairing.body_angles(assembly.position_rad).T
    mate = pairing.meshes[0].members[1]
    other = 3 - mate
    return PairDrawing(
        outline_1=bodies[0].outline,
        outline_2=bodies[mate].outline,
        teeth_1=bodies[0].teeth,
        teeth_2=bodies[mate].teeth,
        center_distance_mm=float(pairing.axes_mm[mate, 0]),
        angle_1=angles[0],
        angle_2=angles[mate],
        bore_radius_1_mm=bodies[0].bore_radius_mm,
        bore_radius_2_mm=bodies[mate].bore_radius_mm,
        between=(
            DrawnBody(
                1,
                bodies[other].outline,
                bodies[other].teeth,
                angles[other],
                bodies[other].bore_radius_mm,
                pairing.axes_mm[other],
            ),
        ),
    )


def _mesh_result(
    scene: Scene, assembly: TrainAssembly, compliances: Compliances, found: MeshesSweep, m: int
) -> Result:
    """Ordinary result of one mesh, at its own positions."""
    mesh, own_mesh = assembly.pairing.meshes[m], assembly.meshes[m]
    one, two = mesh.members
    if mesh.sense < 0:  # teeth of the mirror image run clockwise
        one_teeth, two_teeth = mesh.pairing.site_teeth
        teeth = -one_teeth % own_mesh.body_1.teeth, -two_teeth % own_mesh.body_2.teeth
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
    geometry = pair_geometry(pair, own)
    result = result_of(scene, pair, own, found.meshes[m], estimate=None, geometry=geometry)
    return replace(
        result,
        name=f"{scene.name}: {' and '.join(mesh.names)}",
        stiffness_tangent_Nm_per_rad=np.full(assembly.position_rad.size, np.nan),
        warnings=(),
    )
