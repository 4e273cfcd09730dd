"""Assembly of a planetary stage: all data known before finite elements are solved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from flankload.base.rotation import directions
from flankload.bodies.axial_shape import lead_of
from flankload.bodies.carrier import carrier_compliance
from flankload.bodies.free_corner import forces_turn
from flankload.contact.stage_supports import StageSupports
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import fillets_of, slices_of_mesh
from flankload.mechanisms.scene_bodies import with_file_of
from flankload.mechanisms.several.assembly import (
    MeshesAssembly,
    bodies_of_meshes,
    note_of_period,
    notes_of_meshes,
    positions_of_meshes,
)
from flankload.pairing.body_pair import BodyJob
from flankload.pairing.slices import Slices
from flankload.pairing.stage import StagePairing, repeating_pitches, stage_pairing
from flankload.pairing.stage_errors import StageErrors, pin_displacements
from flankload.scene.discretization import Discretization, choose_discretization
from flankload.scene.effects import Effects, effects_of
from flankload.scene.gear import Ring
from flankload.scene.stage import Stage, assembled_places

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies import Body
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.reuse import Parts
    from flankload.pairing.placed_mesh import PlacedMesh
    from flankload.scene import Scene

    Compliances = tuple[BodyCompliance, BodyCompliance, BodyCompliance]

#: Tables of the bodies.
NAMES = ("body_1", "planet", "body_2")


@dataclass(frozen=True)
class StageAssembly(MeshesAssembly[StagePairing, StageSupports, StageErrors]):
    """A planetary stage with the options of a run."""

    all_names = NAMES

    @property
    def different_meshes(self) -> tuple[tuple[str, str, PlacedMesh], ...]:
        """Those of planet 1."""
        with_sun, with_ring = self.pairing.meshes[:: self.pairing.count]
        key = "pair.center_distance_mm"
        return ("sun and planets", key, with_sun), ("planets and ring", key, with_ring)


def assemble(
    scene: Scene,
    discretization: Discretization | None = None,
    parts: Parts | None = None,
    *,
    account: Account | None = None,
    modified_elements: bool = False,
) -> StageAssembly:
    """Bodies, meshes and positions of a stage.

    Raises
    ------
    SceneError
        If a body cannot be made or the bodies cannot mesh; names file, key, expected and found.
    """
    stage = scene.stage
    assert stage is not None
    discretization, effects = discretization or choose_discretization(scene), effects_of(scene)
    try:
        bodies = bodies_of_meshes(
            _held(scene), discretization, effects, NAMES, parts, modified_elements=modified_elements
        )
        _check_bearing(stage, bodies[1])
        run_outs = bool(stage.sun_run_out_um), bool(stage.ring_run_out_um)
        period = repeating_pitches(bodies, run_outs)
        position_rad, pitches = positions_of_meshes(scene, bodies[0].teeth, period)
        pairing = stage_pairing(
            bodies,
            assembled_places(stage, bodies[0].teeth + bodies[2].teeth),
            radians(stage.nominal_angles_deg[0]),
            scene.pair.axes_apart_mm,
            position_rad,
        )
        jobs = _jobs(bodies, stage, effects)
        supports = _supports(scene, stage, pairing)
    except SceneError as error:
        raise with_file_of(scene, error) from None
    return StageAssembly(
        bodies=bodies,
        jobs=jobs,
        pairing=pairing,
        errors=errors_of(stage, pairing.angles_rad),
        supports=supports,
        slices=tuple(slices for slices in _slices(scene, bodies) for _ in range(pairing.count)),
        discretization=discretization,
        effects=effects,
        position_rad=position_rad,
        pitches=pitches,
        period_pitches=period,
        notes=_notes(scene, bodies, pairing, pitches, period),
    )


def _check_bearing(stage: Stage, planet: Body) -> None:
    """Refuse a bearing that is longer than its planet is wide."""
    (low, high), length = planet.axial.range_mm, stage.pin_bearing_width_mm
    if length is not None and length > high - low:
        raise SceneError(
            key="stage.pin_bearing_width_mm",
            expected=f"at most the width of the planets, {high - low:g} mm",
            found=f"{length:g} mm",
        )


def _jobs(
    bodies: tuple[Body, ...], stage: Stage, effects: Effects
) -> tuple[BodyJob, BodyJob, BodyJob]:
    """Purposes of the elements of sun, planet and ring."""
    elastic = [not body.rigid for body in bodies]
    fillets = [fillets_of(body, name, effects) for name, body in zip(NAMES, bodies, strict=True)]
    turns, free = forces_turn(bodies), stage.ring_support != "clamped"
    return (
        BodyJob(elastic[0], fillets[0], turns=turns),
        BodyJob(elastic[1], fillets[1], coast_flanks=True, turns=turns),
        BodyJob(elastic[2], fillets[2], rim=free, mirrored=True, turns=turns),
    )


def _held(scene: Scene) -> Scene:
    """The scene with the support of the rim in the keys of the ring."""
    assert scene.stage is not None
    if scene.stage.ring_support == "clamped":
        return scene
    assert isinstance(scene.body_2, Ring)
    return replace(scene, body_2=structs.replace(scene.body_2, rim="torque"))


def _slices(scene: Scene, bodies: tuple[Body, ...]) -> tuple[Slices, Slices]:
    """Slices of both kinds of mesh; the only one of a plane stage."""
    sun, planet, ring = (body.axial for body in bodies)
    images = planet.in_mirror_image(), ring.in_mirror_image()
    if scene.stage is not None and scene.stage.planet_ring_flank is not None:
        lead = lead_of(scene.stage.planet_ring_flank)
        images = replace(images[0], lead=lead), images[1]
    one, two = (slices_of_mesh(scene, shapes) for shapes in ((sun, planet), images))
    if planet.surface is not None and not np.array_equal(one.edges_mm, two.edges_mm):
        key = "profile_twist_um" if scene.planet.topography_file is None else "topography_file"  # type: ignore[union-attr]
        raise SceneError(
            key=f"planet.{key}",
            expected="nothing, unless the planets have the same width in common with the sun and "
            "with the ring",
            found="a value",
        )
    return one, two


def errors_of(stage: Stage, angles_rad: Floats) -> StageErrors:
    """Errors of pins, thicknesses and run-outs, and the displacement of the sun by its weight."""
    radial, tangential, thickness = (
        np.asarray(stage.errors_mm(f"{name}_errors_um"))
        for name in ("pin_radial", "pin_tangential", "planet_thickness")
    )
    leaning = [
        np.asarray(stage.errors_mm(f"pin_{along}_inclinations_um_per_mm"))
        for along in ("radial", "tangential")
    ]
    # du/dz along d is the rotation e_z x d
    slopes = pin_displacements(angles_rad, *leaning) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    (x, y), stiffness = _weight(stage), stage.sun_stiffness_N_per_um
    softness = 0.0 if stiffness is None else 1.0 / (1000.0 * stiffness)
    return StageErrors(
        pins_mm=pin_displacements(angles_rad, radial, tangential),
        thickness_mm=thickness,
        sun_mm=(stage.sun_run_out_um / 2000.0, radians(stage.sun_run_out_angle_deg)),
        ring_mm=(stage.ring_run_out_um / 2000.0, radians(stage.ring_run_out_angle_deg)),
        sun_at_mm=(softness * x, softness * y),
        tilts_rad=slopes if slopes.any() else None,
    )


def _weight(stage: Stage) -> tuple[float, float]:
    """Weight of the sun in x and y, N."""
    x, y = stage.sun_weight_N * directions(np.array([radians(stage.sun_weight_angle_deg)]))[0]
    return float(x), float(y)


def _supports(scene: Scene, stage: Stage, pairing: StagePairing) -> StageSupports:
    stiffness, carrier = stage.sun_stiffness_N_per_um, None
    if stage.carrier is not None:
        places = pairing.angles_rad, pairing.center_distance_mm
        carrier = carrier_compliance(stage.carrier, *places, scene.folder)
    return StageSupports(
        floating=stage.floating,
        ring_free=stage.ring_support == "free",
        pin_N_per_mm=stage.pin_stiffness_N_per_mm,
        sun_N_per_mm=None if stiffness is None else 1000.0 * stiffness,
        sun_load_N=_weight(stage),
        tilt_Nmm_per_rad=(
            stage.tilt_Nmm_per_rad("sun"),
            stage.tilt_Nmm_per_rad("pin"),
            stage.tilt_Nmm_per_rad("ring"),
        ),
        carrier=carrier,
        play_mm=stage.play_mm if any(stage.play_mm) else (),
    )


def _notes(
    scene: Scene,
    bodies: tuple[Body, ...],
    pairing: StagePairing,
    pitches: int | None,
    period: int,
) -> tuple[str, ...]:
    """Remarks for the user."""
    notes = notes_of_meshes(scene, NAMES, bodies, pairing.warnings)
    notes += note_of_period(pitches, period, "pitch errors or run-outs", "the sun")
    if any(bodies[1].pitch_errors_um):
        notes.append("planet.pitch_errors_um apply to the flanks in mesh with the sun")
    return tuple(notes)
