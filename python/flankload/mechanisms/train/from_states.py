"""Loads of the bodies of a gear train from its states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.analysis.load_factors import face_load_factor
from flankload.base.torque import in_newton_metres
from flankload.contact.train_supports import MIRRORED
from flankload.contact.wrenches import tilts_of, wrenches_of
from flankload.mechanisms.several.estimates import weights_of
from flankload.result.train import DoubleHelicalLoads, TrainLoads, TrainLoadsOverWidth

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import AnyContact, MeshesSweep
    from flankload.mechanisms.train.assembly import TrainAssembly
    from flankload.result.result import Result
    from flankload.result.train import TwoMeshes
    from flankload.scene import Scene


def loads_of_bodies(
    scene: Scene,
    assembly: TrainAssembly,
    contact: AnyContact,
    found: MeshesSweep,
    meshes: Sequence[Result],
) -> TwoMeshes:
    """Loads of the bodies."""
    assert scene.train is not None
    pairing, common = assembly.pairing, assembly.pairing.common
    # of the bodies of the scene, whose halves are bodies of their own
    tables = range(len(assembly.bodies))
    forces = np.stack(
        [found.resultants[:, np.equal(pairing.tables, z)].sum(axis=1) for z in tables], axis=1
    )
    every: dict[str, Any] = {
        "kind": scene.train.kind,
        "teeth": pairing.teeth,
        "centers_mm": pairing.axes_mm[[pairing.tables.index(z) for z in tables]],
        "torque_2_Nm": in_newton_metres(forces[:, 1, 2]),
        "bearing_force_N": forces[:, :, :2],
        "meshes": meshes,
    }
    if pairing.is_double_helical:
        return DoubleHelicalLoads(**every, **_of_halves(assembly, contact, found))
    every |= {
        "phases": np.array([mesh.phase for mesh in pairing.meshes]),
        "torque_3_Nm": in_newton_metres(forces[:, 2, 2]),
        "orbit_um": 1000.0 * found.moved_mm[:, common],
        "common": common + 1,
    }
    if assembly.is_plane:
        return TrainLoads(**every)
    wrenches = wrenches_of(contact, found.meshes)
    return TrainLoadsOverWidth(
        **every,
        mesh_face_load_factor=_factors(assembly, found),
        axial_force_N=wrenches[..., 2],
        common_moment_Nm=in_newton_metres(wrenches[:, common, 3:5]),
        common_tilt_urad=1e6 * tilts_of(contact, wrenches)[:, common],
    )


def _factors(assembly: TrainAssembly, found: MeshesSweep) -> Floats:
    """(2,) K_Hbeta of both meshes."""
    weights = weights_of(assembly)
    return np.array([face_load_factor(mesh, weights) for mesh in found.meshes])


def _of_halves(assembly: TrainAssembly, contact: AnyContact, found: MeshesSweep) -> dict[str, Any]:
    """Loads of the halves of double helical gears and motion of body 1, in their common frame."""
    supports, wrenches = assembly.supports, wrenches_of(contact, found.meshes)[:, :2]
    halves = wrenches * [np.ones(6), MIRRORED]
    moment = halves[..., 3:5].sum(axis=1)
    # forces on half 1 are at larger z
    apart = supports.arm_mm * (halves[:, 0, :2] - halves[:, 1, :2])
    moment += np.stack([-apart[:, 1], apart[:, 0]], axis=1)
    if supports.floating:
        # opposite rotations in place of the displacement along the axis
        twist = assembly.bodies[0].axial.twist_rad_per_mm
        along = 0.5 * (found.motions[:, 1] - found.motions[:, 0]) / twist
    else:
        along = halves[..., 2].sum(axis=1) * _compliance(supports.axial_N_per_mm)
    return {
        "mesh_face_load_factor": _factors(assembly, found),
        "axial_force_N": halves[..., 2],
        "axial_motion_um": 1000.0 * along,
        "moment_Nm": in_newton_metres(moment),
        "tilt_urad": 1e6 * moment * _compliance(supports.tilt_Nmm_per_rad),
    }


def _compliance(stiffness: float | None) -> float:
    return 0.0 if stiffness is None else 1.0 / stiffness
