"""Losses by sliding in the meshes of a stage, to first order in the coefficient of friction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.torque import in_newton_metres

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.mechanisms.stage.assembly import StageAssembly


def sliding_losses(assembly: StageAssembly, found: MeshesSweep) -> tuple[Floats, Floats]:
    """(P, n) Force times sliding speed of the meshes with the sun and of those with the ring, N m.

    Per rad of the sun relative to the carrier. Both flanks slide with the speed of the relative
    rotation of their bodies about the pitch point.
    """
    pairing = assembly.pairing
    losses = np.zeros((2, len(found.motions), pairing.count))
    for mesh, sweep in zip(pairing.meshes, found.meshes, strict=True):
        one, two = (body.teeth for body in assembly.bodies[int(mesh.with_ring) :][:2])
        # the ring turns in the same sense as a planet
        relative = abs(1.0 - one / two) if mesh.with_ring else 1.0 + one / two
        pitch_mm = mesh.gears.pitch_radius_1_mm * (-1.0 if mesh.with_ring else 1.0)
        pairs = sweep.pairs
        away = np.hypot(pairs.column("x") - pitch_mm, pairs.column("y"))
        lost = np.bincount(pairs.position, pairs.column("force") * away, len(found.motions))
        losses[int(mesh.with_ring), :, mesh.planet] = mesh.rate * relative * lost
    return in_newton_metres(losses[0]), in_newton_metres(losses[1])
