"""Conversion of the states of a stage to its result, and of each mesh to one of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from flankload.base.torque import in_newton_metres, stiffness_Nm_per_rad
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.status import on_corner
from flankload.mechanisms.flank_pair.from_sweep import result_of
from flankload.mechanisms.stage.assembly import StageAssembly
from flankload.mechanisms.stage.estimates import OF_MESHES
from flankload.mechanisms.stage.over_width import loads_over_width
from flankload.mechanisms.stage.planet_bending import bending_of_planets
from flankload.mechanisms.stage.rim import motion_of_rim
from flankload.mechanisms.stage.sliding import sliding_losses
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.gear_pair import cosine_base_helix
from flankload.pairing.stage import orbit_orders, surviving_order
from flankload.result.geometry import pair_geometry
from flankload.result.pairs import DrawnBody, PairDrawing, PairTable, PairTables
from flankload.result.result import Result
from flankload.result.stage import HIGHEST_ORDER, StageLoads
from flankload.result.stage_over_width import StageLoadsOverWidth

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.contact.stage_supports import StageContact
    from flankload.mechanisms.stage.states import Compliances, StageStates
    from flankload.scene import Scene


class MeshResults(Sequence[Result]):
    """Results of the meshes of a stage, each made when it is read.

    `estimates`: of the meshes, or empty.
    """

    def __init__(
        self,
        scene: Scene,
        assembly: StageAssembly,
        compliances: Compliances,
        found: MeshesSweep,
        estimates: Sequence[Mapping[str, object]],
    ) -> None:
        self._made, self._estimates = (scene, assembly, compliances, found), estimates

    def __len__(self) -> int:
        return len(self._made[3].meshes)

    def _of(self, m: int) -> Result:
        estimate = self._estimates[m] if self._estimates else None
        return mesh_result(*self._made, m, estimate)

    @overload
    def __getitem__(self, index: int) -> Result: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Result]: ...

    def __getitem__(self, index: int | slice) -> Result | Sequence[Result]:
        which = range(len(self))[index]
        if isinstance(which, range):
            return tuple(self._of(m) for m in which)
        return self._of(which)


def stage_results(
    scene: Scene,
    assembly: StageAssembly,
    compliances: Compliances,
    states: StageStates,
    estimates: Sequence[Mapping[str, object] | None],
) -> tuple[Result, ...]:
    """Results, one per torque."""
    return tuple(
        _result(scene, assembly, states.contact, found, estimate)
        for found, estimate in zip(states.found, estimates, strict=True)
    )


def _result(
    scene: Scene,
    assembly: StageAssembly,
    contact: StageContact,
    found: MeshesSweep,
    estimate: Mapping[str, object] | None,
) -> Result:
    """Result of a torque."""
    compliances = contact.compliances
    pairing, width = assembly.pairing, assembly.slices[0].compliance_width_mm
    planets, sun = found.whole, assembly.bodies[0]
    counters = planets.counters.sum(axis=0, dtype=np.int64).tolist()
    return Result(
        name=scene.name,
        torque_Nm=in_newton_metres(planets.torque_Nmm),
        sites=np.arange(1, pairing.count + 1),
        position_rad=assembly.position_rad,
        rotation_rad=planets.rotation_rad,
        reference_radius_mm=sun.reference_radius_mm,
        site_force_N=planets.site_force_N,
        peak_pressure_MPa=planets.site_peak_N_per_mm / width,
        stiffness_tangent_Nm_per_rad=stiffness_Nm_per_rad(planets.tangent_rad_per_Nmm),
        status=planets.status,
        pair_tables=PairTables(assembly.position_rad.size, partial(_contacts, assembly, found)),
        corner_contact=on_corner(planets.site_corner),
        pitch_rad=pairing.pitch_rad,
        period_rad=assembly.period_rad,
        closed=assembly.closed,
        face_width_mm=assembly.face_width_mm,
        estimate=None
        if estimate is None
        else {name: part for name, part in estimate.items() if name != OF_MESHES},
        cost={
            "positions": planets.status.size,
            "of_this_torque": dict(zip(CORE_COUNTERS, counters, strict=True)),
            "fe_degrees_of_freedom": [c.job.degrees_of_freedom for c in compliances],
            "largest_backward_error": float(np.max(planets.certificate[:, 0], initial=0.0)),
            "largest_condition": float(np.max(planets.certificate[:, 1], initial=0.0)),
        },
        warnings=assembly.notes,
        drawing=_drawing(assembly),
        drive=_loads(scene, assembly, contact, found, (estimate or {}).get(OF_MESHES, ())),
    )


def _loads(
    scene: Scene,
    assembly: StageAssembly,
    contact: StageContact,
    found: MeshesSweep,
    of_meshes: Any,
) -> StageLoads:
    """Loads of the members; `of_meshes`: error estimates of the meshes, or empty."""
    compliances = contact.compliances
    pairing, n = assembly.pairing, assembly.pairing.count
    sun_force, force = found.whole.site_force_N, found.resultants
    total = sun_force.sum(axis=1)
    factor = np.full(total.shape, np.nan)
    np.divide(n * sun_force.max(axis=1), total, out=factor, where=total > 0)
    # the moments of all contacts on the ring; the carrier carries the rest of the torques
    ring_torque = -force[:, -1, 2]
    on_planets = np.stack([_force_on_body_2(assembly, found, m) for m in range(n)], axis=1)
    on_planets *= cosine_base_helix(assembly.bodies[0])
    zs, _, zr = pairing.teeth
    even = pairing.equally_spaced and not assembly.errors.any and assembly.period_pitches == 1
    radial, by_bolts = motion_of_rim(assembly, compliances[2], found)
    floats = assembly.supports.moving == "carrier"
    carrier_mm = found.motions[:, -2:] if floats else np.zeros((total.size, 2))
    with_sun, with_ring = sliding_losses(assembly, found)
    plane = assembly.slices[0].plane
    kind = StageLoads if plane else StageLoadsOverWidth
    return kind(
        **({} if plane else loads_over_width(assembly, contact, found)),
        teeth=pairing.teeth,
        center_distance_mm=pairing.center_distance_mm,
        planet_angles_rad=pairing.angles_rad,
        phases=np.stack([pairing.sun_phases, pairing.ring_phases]),
        order=surviving_order(n, zs) if even else None,
        orbit_orders=orbit_orders(n, zs, HIGHEST_ORDER) if even else (),
        mesh_load_factor=factor,
        ring_torque_Nm=in_newton_metres(ring_torque),
        carrier_torque_Nm=in_newton_metres(found.whole.torque_Nmm + ring_torque),
        transmission_error_output_urad=1e6 * found.whole.rotation_rad * zs / (zs + zr),
        sun_orbit_um=1000.0 * (found.moved_mm[:, 0] + np.asarray(assembly.errors.sun_at_mm)),
        ring_orbit_um=1000.0 * (found.moved_mm[:, -1] + by_bolts),
        ring_deflection_um=1000.0 * radial,
        carrier_orbit_um=1000.0 * carrier_mm,
        planet_force_N=on_planets,
        pin_force_N=force[:, 1:-1, :2],
        sun_mesh_sliding_loss_Nm=with_sun,
        ring_mesh_sliding_loss_Nm=with_ring,
        planet_bending=bending_of_planets(assembly, compliances[1], found),
        meshes=MeshResults(scene, assembly, compliances, found, of_meshes),
    )


def _force_on_body_2(assembly: StageAssembly, found: MeshesSweep, m: int) -> Floats:
    """(P, 2) Sum of the normal forces of a mesh on its body 2, in the frame of the carrier, N."""
    pairs, mesh = found.meshes[m].pairs, assembly.pairing.meshes[m]
    force = pairs.column("force")
    parts = [
        np.bincount(pairs.position, force * pairs.column(f"normal_{k}"), pairs.count.size)
        for k in "xy"
    ]
    return mesh.in_common_frame(np.stack(parts, axis=-1))


def _contacts(assembly: StageAssembly, found: MeshesSweep, p: int) -> PairTable:
    """Contact pairs of all meshes at a position; sites are planets, the frame is the carrier's."""
    tables = []
    for m, mesh in enumerate(assembly.pairing.meshes):
        pairs, gears = found.meshes[m].pairs, assembly.meshes[m]
        column, number, slices = pairs.columns_at(p), pairs.slices_at(p), gears.slices
        # contact lines are inclined by the base helix angle
        length = slices.width_mm[number] / cosine_base_helix(gears.body_1)
        own = mesh.in_common_frame(np.column_stack([column["x"], column["y"]]))
        if mesh.with_ring:
            own = own + assembly.pairing.centers_mm[mesh.planet]
        normal = mesh.in_common_frame(np.column_stack([column["normal_x"], column["normal_y"]]))
        tables.append(
            {
                "site": np.full(len(own), mesh.planet + 1),
                "radius_mm": np.hypot(*own.T),
                "arc_length_1_mm": column["s_1"],
                "arc_length_2_mm": column["s_2"],
                "x_mm": own[:, 0],
                "y_mm": own[:, 1],
                "normal_x": normal[:, 0],
                "normal_y": normal[:, 1],
                "force_N": column["force"],
                "pressure_MPa": column["force"] / (column["cell"] * length),
                "gap_um": 1000.0 * column["gap"],
                "cell_mm": column["cell"],
                **({} if slices.plane else {"z_mm": slices.z_mm[number]}),
            }
        )
    return PairTable(**{name: np.concatenate([t[name] for t in tables]) for name in tables[0]})


def _drawing(assembly: StageAssembly) -> PairDrawing:
    """Sun, ring and planets at their angles."""
    (sun, planet, ring), pairing = assembly.bodies, assembly.pairing
    angle_1, turned, angle_2 = pairing.body_angles(assembly.position_rad)
    own = 1, planet.outline, planet.teeth
    planets = tuple(
        DrawnBody(*own, angle, planet.bore_radius_mm, center)
        for angle, center in zip(turned.T, pairing.centers_mm, strict=True)
    )
    return PairDrawing(
        outline_1=sun.outline,
        outline_2=ring.outline,
        teeth_1=sun.teeth,
        teeth_2=ring.teeth,
        center_distance_mm=0.0,
        angle_1=angle_1,
        angle_2=angle_2,
        bore_radius_1_mm=sun.bore_radius_mm,
        bore_radius_2_mm=ring.bore_radius_mm,
        between=planets,
    )


def mesh_result(
    scene: Scene,
    assembly: StageAssembly,
    compliances: Compliances,
    found: MeshesSweep,
    m: int,
    estimate: Mapping[str, object] | None = None,
) -> Result:
    """Ordinary result of one mesh, at its own positions."""
    mesh, own_mesh = assembly.pairing.meshes[m], assembly.meshes[m]
    first = 1 if mesh.with_ring else 0
    if mesh.with_ring:  # teeth of the mirror image run clockwise
        one, two = mesh.pairing.site_teeth
        teeth = -one % own_mesh.body_1.teeth, -two % own_mesh.body_2.teeth
        own_mesh = replace(own_mesh, pairing=replace(mesh.pairing, site_teeth=teeth))
    pair = BodyPair(
        **vars(own_mesh),
        jobs=(assembly.jobs[first], assembly.jobs[first + 1]),
        discretization=assembly.discretization,
        effects=assembly.effects,
        position_rad=mesh.positions(assembly.position_rad),
        pitches=assembly.pitches,
        closed=assembly.closed,
        adaptive=False,
        notes=(),
    )
    own = compliances[first], compliances[first + 1]
    result = result_of(
        scene, pair, own, found.meshes[m], estimate=estimate, geometry=pair_geometry(pair, own)
    )
    which = "ring" if mesh.with_ring else "sun"
    unknown = np.full(assembly.position_rad.size, np.nan)
    return replace(
        result,
        name=f"{scene.name}: planet {mesh.planet + 1} with the {which}",
        stiffness_tangent_Nm_per_rad=unknown,
        warnings=(),
    )
