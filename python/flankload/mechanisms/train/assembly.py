"""Assembly of a gear train: all data known before finite elements are solved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.free_corner import forces_turn
from flankload.bodies.shaft import end_of_cantilever, twist_of_shaft
from flankload.contact.train_supports import TrainErrors, TrainSupports
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import slices_of_mesh
from flankload.mechanisms.scene_bodies import with_file_of
from flankload.mechanisms.several.assembly import (
    MeshesAssembly,
    bodies_of_meshes,
    note_of_period,
    notes_of_meshes,
    positions_of_meshes,
)
from flankload.pairing.body_pair import BodyJob
from flankload.pairing.slices import Slices, gap_by_misalignment
from flankload.pairing.train import (
    NAMES,
    TrainPairing,
    double_helical_pairing,
    idler_pairing,
    repeating_pitches,
    two_pinions_pairing,
)
from flankload.scene.discretization import Discretization, choose_discretization
from flankload.scene.effects import effects_of

if TYPE_CHECKING:
    from flankload.bodies import Body
    from flankload.cost import Account
    from flankload.mechanisms.reuse import Parts
    from flankload.pairing.placed_mesh import PlacedMesh
    from flankload.scene import Scene
    from flankload.scene.train import Train

PAIRINGS = {
    "idler": idler_pairing,
    "two_pinions": two_pinions_pairing,
    "double_helical": double_helical_pairing,
}


@dataclass(frozen=True)
class TrainAssembly(MeshesAssembly[TrainPairing, TrainSupports, TrainErrors]):
    """A gear train with the options of a run."""

    all_names = NAMES

    @property
    def different_meshes(self) -> tuple[tuple[str, str, PlacedMesh], ...]:
        """Both; the halves of double helical gears are alike."""
        keys = ("pair.center_distance_mm", "train.center_distance_2_mm")[: len(self.bodies) - 1]
        return tuple(
            (self.pairing.title(m), key, self.pairing.meshes[m]) for m, key in enumerate(keys)
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
        names = tuple(name for name in NAMES if getattr(scene, name) is not None)
        bodies = bodies_of_meshes(
            scene, discretization, effects, names, parts, modified_elements=modified_elements
        )
        _check_groove(train, bodies[0])
        period = repeating_pitches(bodies)
        position_rad, pitches = positions_of_meshes(scene, bodies[0].teeth, period)
        distance = scene.pair.axes_apart_mm
        distances = distance, train.center_distance_2_mm or distance
        pairing = PAIRINGS[train.kind](bodies, train.angle_deg, distances, position_rad)
    except SceneError as error:
        raise with_file_of(scene, error) from None
    # in the plane, the coast flanks of a driven gear are the working flanks of its mirror image
    plane, opening = bodies[0].axial.plane, _opening(scene, pairing)
    on_coast = ("body_3",) if plane else ("body_3", "body_2")
    slices = _slices(scene, bodies, pairing, opening)
    arm_mm = 0.5 * ((train.groove_width_mm or 0.0) + float(slices[0].width_mm.sum()))
    radial, tilting, axial = train.stiffnesses.values()
    free = train.is_double_helical and train.axial_stiffness_N_per_um is None
    return TrainAssembly(
        bodies=bodies,
        jobs=tuple(
            BodyJob(
                not body.rigid,
                coast_flanks=train.kind == "idler" and name in on_coast,
                turns=forces_turn(bodies),
            )
            for name, body in zip(names, bodies, strict=True)
        ),
        pairing=pairing,
        errors=_errors(train, bodies, pairing, opening * arm_mm),
        supports=_in_groove(
            train,
            bodies[0],
            TrainSupports(radial, tilting, axial, train.floating or free, arm_mm),
        ),
        slices=slices,
        discretization=discretization,
        effects=effects,
        position_rad=position_rad,
        pitches=pitches,
        period_pitches=period,
        notes=_notes(scene, bodies, pairing, pitches, period),
    )


def _check_groove(train: Train, pinion: Body) -> None:
    """Refuse a groove whose diameter exceeds that of the tips."""
    diameter, tip_diameter = train.groove_diameter_mm, 2.0 * (pinion.tip_radius_mm or np.inf)
    if diameter is not None and diameter > tip_diameter:
        raise SceneError(
            key="train.groove_diameter_mm",
            expected=f"at most the tip diameter of body_1, {tip_diameter:g} mm",
            found=f"{diameter:g} mm",
        )


def _in_groove(train: Train, pinion: Body, supports: TrainSupports) -> TrainSupports:
    """The supports with bending and twist of a double helical pinion in its groove."""
    diameter, width = train.groove_diameter_mm, train.groove_width_mm
    if diameter is None or width is None:
        return supports
    half, material = 0.5 * width, pinion.material
    return replace(
        supports,
        groove=end_of_cantilever(material, diameter, half, supports.arm_mm - half),
        twist_rad_per_Nmm=twist_of_shaft(material, diameter, width),
    )


def _errors(
    train: Train, bodies: tuple[Body, ...], pairing: TrainPairing, apart_mm: float
) -> TrainErrors:
    """Rotation of the second pinion, or of the halves of a double helical one.

    `apart_mm`: gap of the half of larger z by a misalignment, which closes the other one.
    """
    turned = np.zeros(len(pairing.tables))
    turned[1 if train.is_double_helical else 2] = train.timing_error_um / 1000.0
    if train.is_double_helical:
        turned[:2] += apart_mm * np.array([-1.0, 1.0])
    return TrainErrors(turned / [bodies[table].base_radius_mm or 1.0 for table in pairing.tables])


def _opening(scene: Scene, pairing: TrainPairing) -> float:
    """Growth of the gap along z by a misalignment of double helical gears."""
    angles = scene.pair.inclination_um_per_mm, scene.pair.deviation_um_per_mm
    return gap_by_misalignment(*angles, pairing.meshes[0].gears.pressure_angle_rad)


def _slices(
    scene: Scene, bodies: tuple[Body, ...], pairing: TrainPairing, opening: float
) -> tuple[Slices, ...]:
    """Slices of both meshes; the only one of a plane train."""
    found = []
    for m, mesh in enumerate(pairing.meshes):
        one, two = (bodies[pairing.tables[b]].axial for b in mesh.members)
        if pairing.is_image(m):
            one, two = one.in_mirror_image(), two.in_mirror_image()
        # z of half 2 of double helical gears counts in the other direction
        found.append(slices_of_mesh(scene, (one, two), (-opening if m else opening, 0.0)))
    return tuple(found)


def _notes(
    scene: Scene,
    bodies: tuple[Body, ...],
    pairing: TrainPairing,
    pitches: int | None,
    period: int,
) -> tuple[str, ...]:
    """Remarks for the user."""
    notes = notes_of_meshes(scene, NAMES[: len(bodies)], bodies, pairing.warnings)
    notes += note_of_period(pitches, period, "pitch errors", "body 1")
    if pairing.is_idler and any(bodies[2].pitch_errors_um):
        notes.append("body_3.pitch_errors_um apply to the flanks in mesh with body 1")
    return tuple(notes)
