"""Assembly of a gear train: all data known before finite elements are solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.contact.train_supports import TrainErrors, TrainSupports
from flankload.errors import SceneError
from flankload.mechanisms.scene_bodies import with_file_of
from flankload.mechanisms.several.assembly import (
    MeshesAssembly,
    bodies_of_meshes,
    note_of_period,
    notes_of_meshes,
    positions_of_meshes,
)
from flankload.pairing.body_pair import BodyJob
from flankload.pairing.slices import plane_slice
from flankload.pairing.train import (
    NAMES,
    TrainPairing,
    idler_pairing,
    repeating_pitches,
    two_pinions_pairing,
)
from flankload.scene.discretization import Discretization, choose_discretization
from flankload.scene.effects import effects_of

if TYPE_CHECKING:
    from flankload.bodies import Body
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import Scene

    Compliances = tuple[BodyCompliance, BodyCompliance, BodyCompliance]

PAIRINGS = {"idler": idler_pairing, "two_pinions": two_pinions_pairing}


@dataclass(frozen=True)
class TrainAssembly(MeshesAssembly[TrainPairing, TrainSupports, TrainErrors]):
    """A gear train with the options of a run."""

    names = NAMES


def assemble(
    scene: Scene,
    discretization: Discretization | None = None,
    parts: Parts | None = None,
    *,
    account: Account | None = None,
    modified_elements: bool = False,
) -> TrainAssembly:
    """Bodies, meshes and positions of a train.

    Raises
    ------
    SceneError
        If a body cannot be made or the bodies cannot mesh; names file, key, expected and found.
    """
    train = scene.train
    assert train is not None
    discretization, effects = discretization or choose_discretization(scene), effects_of(scene)
    try:
        bodies = bodies_of_meshes(
            scene, discretization, effects, NAMES, parts, modified_elements=modified_elements
        )
        period = repeating_pitches(bodies)
        position_rad, pitches = positions_of_meshes(scene, bodies[0].teeth, period)
        distances = scene.pair.axes_apart_mm, train.center_distance_2_mm
        assert distances[1] is not None
        pairing = PAIRINGS[train.kind](
            bodies, train.angle_deg, (distances[0], distances[1]), position_rad
        )
    except SceneError as error:
        raise with_file_of(scene, error) from None
    idler = [train.kind == "idler" and name == "body_3" for name in NAMES]
    jobs = [
        BodyJob(not body.rigid, coast_flanks=both) for body, both in zip(bodies, idler, strict=True)
    ]
    return TrainAssembly(
        bodies=bodies,
        jobs=(jobs[0], jobs[1], jobs[2]),
        pairing=pairing,
        errors=TrainErrors(train.timing_error_um / 1000.0 / (bodies[2].base_radius_mm or 1.0)),
        supports=TrainSupports(train.bearing_N_per_mm, train.floating),
        slices=(plane_slice(scene.pair.face_width_mm),) * len(pairing.meshes),
        discretization=discretization,
        effects=effects,
        position_rad=position_rad,
        pitches=pitches,
        period_pitches=period,
        notes=_notes(scene, bodies, pairing, pitches, period),
    )


def _notes(
    scene: Scene,
    bodies: tuple[Body, Body, Body],
    pairing: TrainPairing,
    pitches: int | None,
    period: int,
) -> tuple[str, ...]:
    """Remarks for the user."""
    notes = notes_of_meshes(scene, NAMES, bodies, pairing.warnings)
    notes += note_of_period(pitches, period, "pitch errors", "body 1")
    if pairing.is_idler and any(bodies[2].pitch_errors_um):
        notes.append("body_3.pitch_errors_um apply to the flanks in mesh with body 1")
    return tuple(notes)
