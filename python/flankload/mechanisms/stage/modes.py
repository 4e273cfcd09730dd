"""Natural modes of a planetary stage about its states."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, inf
from typing import TYPE_CHECKING

from msgspec import structs

from flankload.analysis.stage_modes import Inertia, StageModes, StageSystem, Support
from flankload.base.torque import in_newton_metres
from flankload.bodies.mass import mass_of
from flankload.contact.meshes_contact import sweep_meshes
from flankload.contact.stage_stiffness import contact_stiffness
from flankload.errors import SceneError
from flankload.mechanisms.stage.assembly import NAMES, StageAssembly, assemble
from flankload.mechanisms.stage.states import compliances_of
from flankload.mechanisms.stage_clock import StageClock
from flankload.pairing.expansion import DENSITY_KG_M3
from flankload.scene.materials import MATERIALS

if TYPE_CHECKING:
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.contact.stage_supports import StageContact
    from flankload.scene import Scene
    from flankload.scene.stage import Stage

#: Least number of positions in a tooth pitch for the mean stiffness: with 8, frequencies of the
#: example stage differ by up to 1 %, with 64 by 0.1 %.
POSITIONS = 32


def stage_modes(scene: Scene) -> tuple[StageModes, ...]:
    """Modes about the states under each torque, with the mean stiffness of a tooth pitch.

    Contact is lumped: frequencies with cells differ by 0.1 %.

    Raises
    ------
    SceneError
        If the scene cannot be solved, has a torque 0, or lacks the mass of a floating carrier.
    """
    stage = scene.stage
    assert stage is not None
    _check(scene, stage)
    # a multiple of the planets' number: their phases permute the positions, so that all meshes
    # have the same mean
    count = stage.count * ceil(POSITIONS / stage.count)
    positions = structs.replace(scene.positions, count=count, pitches=1, angles_deg=None)
    effects = structs.replace(scene.effects, contact="lumped")
    scene = replace(scene, positions=positions, effects=effects)
    assembly = assemble(scene)
    assembly, compliances = compliances_of(scene, assembly, StageClock(None, NAMES, 1, {}), {})
    contact = assembly.contact(scene, compliances)
    # by which the moments on bodies with a width are known
    wide = not assembly.is_plane
    sweeps = sweep_meshes(contact, assembly.position_rad, scene.torques_Nmm, keep_pairs=wide)
    inertias = _inertias(scene, stage, assembly)
    return tuple(_modes(assembly, contact, found, inertias) for found in sweeps)


def _check(scene: Scene, stage: Stage) -> None:
    """Refuse a torque 0, at which no flank is in contact, and supports that modes do not have."""
    for key in ("carrier", "pin_clearance_um"):
        if getattr(stage, key) and (key == "carrier" or any(stage.play_mm)):
            raise SceneError(
                file=scene.file,
                key=f"stage.{key}",
                expected="nothing for modes, in which planets are on springs of their own",
                found="a value",
            )
    if not all(scene.load.torques_Nm):
        raise SceneError(
            file=scene.file,
            key="load.torque_Nm",
            expected="a number > 0 for modes: without it, no flank is in contact",
            found="0",
        )
    if stage.floating == "carrier" and stage.carrier_mass_kg is None:
        expected = "a value for modes, with stage.floating = 'carrier'"
        raise SceneError(
            file=scene.file, key="stage.carrier_mass_kg", expected=expected, found="nothing"
        )


def _modes(
    assembly: StageAssembly,
    contact: StageContact,
    found: MeshesSweep,
    inertias: tuple[Inertia, Inertia, Inertia, Inertia],
) -> StageModes:
    """Modes under a torque."""
    supports, pairing = contact.supports, assembly.pairing
    floats = [member == supports.floating for member in ("sun", "ring", "carrier")]
    radial = [0.0 if free else inf for free in floats]
    if supports.ring_free:
        radial[1] = 0.0
    if floats[0]:
        radial[0] = supports.sun_N_per_mm or 0.0
    turning = 0.0 if inertias[3].moment_kg_m2 else inf
    system = StageSystem(
        angles_rad=pairing.angles_rad,
        center_distance_mm=pairing.center_distance_mm,
        contacts=contact_stiffness(contact, found, assembly.position_rad).mean(axis=0),
        pins_N_per_mm=supports.pin_N_per_mm,
        inertias=inertias,
        supports=(Support(radial[0], 0.0), Support(radial[1], inf), Support(radial[2], turning)),
    )
    torque = in_newton_metres(found.whole.torque_Nmm)
    return StageModes(torque, pairing.teeth[0], inertias, system.modes())


def _inertias(
    scene: Scene, stage: Stage, assembly: StageAssembly
) -> tuple[Inertia, Inertia, Inertia, Inertia]:
    """Inertias of sun, planet, ring and carrier: keys of the scene, otherwise by the shapes."""
    own = []
    for name, body in zip(NAMES, assembly.bodies, strict=True):
        material = MATERIALS.get(getattr(scene, name).material or "")
        density = DENSITY_KG_M3 if material is None else material.density_kg_m3
        own.append(mass_of(body, density, body.axial.width_in(assembly.face_width_mm)))
    (sun, turn), (planet, turn_of_planet), (ring, turn_of_ring) = own
    return (
        Inertia(stage.sun_mass_kg or sun, stage.sun_inertia_kg_m2 or turn),
        Inertia(stage.planet_mass_kg or planet, stage.planet_inertia_kg_m2 or turn_of_planet),
        Inertia(stage.ring_mass_kg or ring, turn_of_ring),
        Inertia(stage.carrier_mass_kg or 0.0, stage.carrier_inertia_kg_m2 or 0.0),
    )
