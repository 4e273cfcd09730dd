"""Assembly of a gear train: all data known before finite elements are solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.contact.train_supports import TrainContact, TrainErrors, TrainSupports
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import without_ends
from flankload.mechanisms.flank_pair.rims import rim_notes
from flankload.mechanisms.scene_bodies import bodies_of, with_file_of
from flankload.mechanisms.several_meshes import positions_of_meshes
from flankload.pairing.body_pair import BodyJob
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.slices import plane_slice
from flankload.pairing.train import (
    NAMES,
    TrainPairing,
    idler_pairing,
    repeating_pitches,
    two_pinions_pairing,
)
from flankload.scene.discretization import Discretization, choose_discretization
from flankload.scene.effects import Effects, effects_of
from flankload.scene.usual import question_notes

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies import Body
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import Scene

    Compliances = tuple[BodyCompliance, BodyCompliance, BodyCompliance]

PAIRINGS = {"idler": idler_pairing, "two_pinions": two_pinions_pairing}


@dataclass(frozen=True)
class TrainAssembly:
    """A gear train with the options of a run.

    Attributes
    ----------
    bodies : Body, Body, Body
        Bodies 1, 2, 3.
    jobs : three BodyJob
    pairing : TrainPairing
    face_width_mm : float
    discretization : Discretization
    effects : Effects
    position_rad : (P,) array
    pitches : int or None
        Tooth pitches of body 1 that the positions cover; None for explicit angles.
    period_pitches : int
        Tooth pitches after which everything repeats.
    notes : tuple of str
    """

    bodies: tuple[Body, Body, Body]
    jobs: tuple[BodyJob, BodyJob, BodyJob]
    pairing: TrainPairing
    face_width_mm: float
    discretization: Discretization
    effects: Effects
    position_rad: Floats
    pitches: int | None
    period_pitches: int
    notes: tuple[str, ...]

    names = NAMES

    @property
    def meshes(self) -> tuple[GearMesh, GearMesh]:
        """Both gear meshes."""
        one, two = (
            GearMesh(
                (self.bodies[first], self.bodies[second]),
                mesh.pairing,
                plane_slice(self.face_width_mm),
                names=mesh.names,
            )
            for mesh in self.pairing.meshes
            for first, second in [mesh.members]
        )
        return one, two

    @property
    def closed(self) -> bool:
        """Whether several positions cover whole periods."""
        whole = self.pitches is not None and self.pitches % self.period_pitches == 0
        return whole and self.position_rad.size > 1

    @property
    def period_rad(self) -> float:
        """Period of the curves, rad."""
        pitches = self.pitches if self.closed and self.pitches else self.period_pitches
        return pitches * self.pairing.pitch_rad

    def contact(self, scene: Scene, compliances: Compliances) -> TrainContact:
        """The contact of both meshes."""
        train = scene.train
        assert train is not None
        radius_mm = self.bodies[2].base_radius_mm or 1.0
        return TrainContact(
            bodies=self.bodies,
            compliances=compliances,
            pairing=self.pairing,
            meshes=self.meshes,
            errors=TrainErrors(train.timing_error_um / 1000.0 / radius_mm),
            supports=TrainSupports(train.bearing_N_per_mm, train.floating),
            grid=self.discretization.grid,
            level=scene.effects.contact,
            coupled=scene.effects.mesh_coupling,
        )


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
        one, two, three = bodies_of(
            scene, discretization, NAMES, parts=parts, modified_elements=modified_elements
        )
        bodies = one, two, three
        if not effects.tip_contact:
            bodies = without_ends(one), without_ends(two), without_ends(three)
        period = repeating_pitches(bodies)
        position_rad, pitches = positions_of_meshes(scene, one.teeth, period)
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
        face_width_mm=scene.pair.face_width_mm,
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
    notes = [*question_notes(scene)]
    notes += [
        f"{name}: {note}" for name, body in zip(NAMES, bodies, strict=True) for note in body.notes
    ]
    notes += [*rim_notes(NAMES, bodies), *pairing.warnings]
    if pitches is not None and pitches % period:
        notes.append(
            f"with pitch errors the curves repeat after {period} pitches of body 1; these "
            f"positions cover {pitches} (positions.pitches = 'hunting' covers all)"
        )
    if pairing.is_idler and any(bodies[2].pitch_errors_um):
        notes.append("body_3.pitch_errors_um apply to the flanks in mesh with body 1")
    return tuple(notes)
