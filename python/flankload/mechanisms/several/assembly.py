"""Assembly of a drive with several gear meshes: all data known before elements are solved."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

import numpy as np

from flankload.contact.meshes_contact import Errors, MeshesContact, PairingT, SupportsT
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import without_ends
from flankload.mechanisms.flank_pair.rims import rim_notes
from flankload.mechanisms.scene_bodies import bodies_of
from flankload.pairing.gear_mesh import GearMesh
from flankload.scene.usual import question_notes

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies import Body
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.reuse import Parts
    from flankload.pairing.body_pair import BodyJob
    from flankload.pairing.placed_mesh import PlacedMesh
    from flankload.pairing.slices import Slices
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization
    from flankload.scene.effects import Effects

    Bodies = tuple[Body, ...]
    Compliances = tuple[BodyCompliance, ...]

ErrorsT = TypeVar("ErrorsT", bound=Errors)
#: Largest number of positions of a scene.
MOST_POSITIONS = 100_000


@dataclass(frozen=True)
class MeshesAssembly(ABC, Generic[PairingT, SupportsT, ErrorsT]):
    """A drive with several gear meshes, with the options of a run.

    Attributes
    ----------
    bodies : tuple of Body
        By their tables, `names`.
    jobs : tuple of BodyJob
    pairing : PlacedMeshes
    errors : Errors
    supports : Supports
    slices : tuple of Slices
        Slices of each mesh; in the mirror image for meshes that are in it.
    discretization : Discretization
    effects : Effects
    position_rad : (P,) array
    pitches : int or None
        Tooth pitches of body 1 that the positions cover; None for explicit angles.
    period_pitches : int
        Tooth pitches after which everything repeats.
    notes : tuple of str
    """

    bodies: Bodies
    jobs: tuple[BodyJob, ...]
    pairing: PairingT
    errors: ErrorsT
    supports: SupportsT
    slices: tuple[Slices, ...]
    discretization: Discretization
    effects: Effects
    position_rad: Floats
    pitches: int | None
    period_pitches: int
    notes: tuple[str, ...]

    all_names: ClassVar[tuple[str, ...]]

    @property
    @abstractmethod
    def different_meshes(self) -> tuple[tuple[str, str, PlacedMesh], ...]:
        """Words, key of the centre distance, and mesh, of those that are not alike."""

    @property
    def names(self) -> tuple[str, ...]:
        """Tables of the bodies."""
        return self.all_names[: len(self.bodies)]

    @cached_property
    def meshes(self) -> tuple[GearMesh, ...]:
        """Gear meshes, in the frames and mirror images of the pairing."""
        images = [body.in_mirror_image() for body in self.bodies]
        found = []
        for m, (mesh, slices) in enumerate(zip(self.pairing.meshes, self.slices, strict=True)):
            bodies = images if self.pairing.is_image(m) else self.bodies
            one, two = (bodies[self.pairing.tables[b]] for b in mesh.members)
            found.append(GearMesh((one, two), mesh.pairing, slices, names=mesh.names))
        return tuple(found)

    @property
    def is_plane(self) -> bool:
        """Whether the bodies have no width of their own."""
        return self.slices[0].plane

    @property
    def face_width_mm(self) -> float:
        """Common face width of the first mesh."""
        return self.meshes[0].face_width_mm

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

    def contact(self, scene: Scene, compliances: Compliances) -> MeshesContact[PairingT, SupportsT]:
        """The contact of all meshes."""
        return MeshesContact(
            bodies=self.bodies,
            compliances=compliances,
            pairing=self.pairing,
            meshes=self.meshes,
            errors=self.errors,
            supports=self.supports,
            grid=self.discretization.grid,
            level=scene.effects.contact,
            coupled=scene.effects.mesh_coupling,
        )


def bodies_of_meshes(
    scene: Scene,
    discretization: Discretization,
    effects: Effects,
    names: tuple[str, ...],
    parts: Parts | None,
    *,
    modified_elements: bool,
) -> Bodies:
    """The bodies of these tables."""
    bodies = bodies_of(
        scene, discretization, names, parts=parts, modified_elements=modified_elements
    )
    return bodies if effects.tip_contact else tuple(without_ends(body) for body in bodies)


def positions_of_meshes(scene: Scene, teeth: int, period: int) -> tuple[Floats, int | None]:
    """(P,) Angles of body 1 in the common frame, and the pitches that they cover."""
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float)), None
    pitches = period if wanted.pitches == "hunting" else int(wanted.pitches)
    if wanted.count * pitches > MOST_POSITIONS:
        raise SceneError(
            key="positions.pitches",
            expected=f"at most {MOST_POSITIONS // wanted.count}, so that there are at most "
            f"{MOST_POSITIONS} positions",
            found=f"{pitches} pitches of {wanted.count} positions",
        )
    return 2 * pi / teeth * np.arange(wanted.count * pitches) / wanted.count, pitches


def notes_of_meshes(
    scene: Scene, names: tuple[str, ...], bodies: Bodies, warnings: tuple[str, ...]
) -> list[str]:
    """Remarks for the user on questions, bodies and meshes."""
    notes = [*question_notes(scene)]
    notes += [
        f"{name}: {note}" for name, body in zip(names, bodies, strict=True) for note in body.notes
    ]
    return [*notes, *rim_notes(names, bodies), *warnings]


def note_of_period(pitches: int | None, period: int, causes: str, body: str) -> list[str]:
    """Remark on positions that do not cover whole periods of a body; `causes` of the period."""
    if pitches is None or pitches % period == 0:
        return []
    note = f"with {causes} the curves repeat after {period} pitches of {body}; these positions "
    return [f"{note}cover {pitches} (positions.pitches = 'hunting' covers all)"]
