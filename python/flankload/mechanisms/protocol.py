"""The protocol that every kind of drive implements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from flankload.analysis.stage_modes import StageModes
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies import Body, SectorMesh, WholeMesh
    from flankload.contact.core_call import KnownContacts
    from flankload.cost import Account
    from flankload.mechanisms.data_sheet import DataSheet
    from flankload.mechanisms.parameters import Parameters
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization

    Counted = Mapping[str, Mapping[str, int]]
    Rows = list[tuple[str, str]]


@dataclass(frozen=True)
class Description:
    """Output of `flankload check`.

    Attributes
    ----------
    rows : dict of str to list of (str, str)
        Name and value of each row, by title.
    notes : tuple of str
        Warnings.
    """

    rows: dict[str, Rows]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class MeshFile:
    """Mesh of a body at position zero, as written by `flankload mesh`.

    Attributes
    ----------
    name : str
        Name of the body.
    mesh : SectorMesh, WholeMesh or None
        None if the body has no mesh.
    words : str
        Part of the body that is meshed, or the reason for no mesh.
    turn_rad : float
        Rotation of the body about its axis.
    """

    name: str
    mesh: SectorMesh | WholeMesh | None
    words: str
    turn_rad: float = 0.0


@dataclass(frozen=True)
class ComplianceFile:
    """Compliance of a body, as written by `flankload compliance`.

    Attributes
    ----------
    name : str
        Name of the body.
    arrays : mapping of str to array, or None
        Content of the file; None if the body has no compliance.
    words : str
        Summary of the file, or the reason for no file.
    """

    name: str
    arrays: Mapping[str, NDArray[Any]] | None
    words: str


@dataclass(frozen=True, eq=False)
class NodalFields:
    """Fields at the M nodes of a body at one position, in the world frame.

    Attributes
    ----------
    points_mm : (M, 3) array
        Undeformed positions, in the plane at z = 0.
    displacement_mm : (M, 3) array
        Due to the contact forces; not to temperature, speed, a press fit or shafts.
    stress_MPa : (M, 6) array
        xx, yy, zz, xy, yz, xz; averaged over the elements of a node.
    contact_pressure_MPa : (M,) array
        Normal force of a flank node divided by its area; 0 elsewhere.
    force_N : (M, 3) array
        Consistent nodal forces of the contacts, over the face width.
    """

    points_mm: Floats
    displacement_mm: Floats
    stress_MPa: Floats
    contact_pressure_MPa: Floats
    force_N: Floats

    @property
    def von_mises_MPa(self) -> Floats:
        """(M,) Equivalent stress."""
        xx, yy, zz, *shear = self.stress_MPa.T
        apart = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.asarray(np.sqrt(0.5 * apart + 3.0 * sum(part**2 for part in shear)))


class FieldsOfBody(Protocol):
    """Elements of a body, and their fields under the contact forces of results."""

    @property
    def cells(self) -> tuple[tuple[str, Numbers], ...]:
        """Elements, by index of the points of the fields."""

    @property
    def section_nodes(self) -> int:
        """Number of nodes of a section."""

    def at(self, result: Result, p: int) -> NodalFields:
        """Fields of a result of the scene at position p."""


class Assembly(Protocol):
    """A drive before its elements are solved."""

    @property
    def position_rad(self) -> Floats:
        """(P,) Angles of body 1."""

    @property
    def bodies(self) -> tuple[Body, ...]:
        """Bodies in the order of `Mechanism.body_names`; empty if they have no flanks."""

    @property
    def meshes(self) -> tuple[GearMesh, ...]:
        """Contacts of two bodies each; empty if they have no flanks."""


class States(Protocol):
    """States of a drive at all positions."""

    @property
    def found(self) -> tuple[Any, ...]:
        """States in the form of the drive, one entry per torque."""

    @property
    def known(self) -> KnownContacts | None:
        """Pairs in contact, from which similar states are continued; None if these are not."""


#: Types of a kind of drive: its assembly, the compliances of its bodies, its states.
A = TypeVar("A", bound=Assembly)
C = TypeVar("C")
S = TypeVar("S", bound=States)


@dataclass(frozen=True)
class Displaced(Generic[A, C, S]):
    """States of scenes that differ by known displacements of their bodies only.

    Attributes
    ----------
    alike : callable
        alike(one, other): whether two scenes do.
    states : callable
        states(scenes, assembly, compliances, clock): assembly and states of each scene.
    """

    alike: Callable[[Scene, Scene], bool]
    states: Callable[[Sequence[Scene], A, C, StageClock], Sequence[tuple[A, S]]]


class Mechanism(Protocol[A, C, S]):
    """A kind of drive, stage by stage; later methods receive what earlier methods return."""

    @property
    def body_names(self) -> tuple[str, ...]:
        """Tables of the bodies in the scene; stages and kept compliances have these names."""

    @property
    def modes(self) -> Callable[[Scene], tuple[StageModes, ...]] | None:
        """Natural modes of a scene, one entry per torque; None if the kind of drive has none."""

    @property
    def no_flanks_reason(self) -> str | None:
        """Kind of body 2 and the reason why the bodies have no flanks and elements, or None.

        As error lines show them after "found".
        """

    @property
    def displaced(self) -> Displaced[A, C, S] | None:
        """States of scenes that differ by known displacements; None: solved one by one."""

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None = None,
        parts: Parts | None = None,
        *,
        account: Account | None = None,
        modified_elements: bool = False,
    ) -> A:
        """Assemble the bodies without solving elements; a SceneError names an impossible input.

        Parts of earlier runs may be reused where a call would have the same arguments. With
        `modified_elements`, elements follow the modified flanks, for another program.
        """

    def work(self, scene: Scene, assembly: A) -> Counted:
        """Counters by stage that are known before a run."""

    def sweeps(self, scene: Scene) -> int:
        """Largest number of sweeps over all positions, including those of the estimate."""

    def compliances(
        self,
        scene: Scene,
        assembly: A,
        clock: StageClock,
        kept: Kept,
        parts: Parts | None = None,
    ) -> tuple[A, C]:
        """Solve the elements of the bodies not in `kept`; return the completed assembly too.

        A compliance that is found in `parts` has no stage and no cost.
        """

    def states(
        self,
        scene: Scene,
        assembly: A,
        compliances: C,
        clock: StageClock,
        similar: States | None = None,
        *,
        unloaded: bool = True,
    ) -> tuple[A, S]:
        """States under all torques, and the assembly at all their positions.

        The states of a scene that differs by a small step may be continued. Without `unloaded`, the
        state without torque is not solved.
        """

    def broken_by_geometry(self, assembly: A) -> Iterable[Broken]:
        """Premises that the geometry violates without load."""

    def broken_by_load(self, scene: Scene, assembly: A, states: S, number: int) -> Iterable[Broken]:
        """Premises that the torque with this index violates."""

    def estimates(
        self, scene: Scene, assembly: A, compliances: C, states: S, clock: StageClock
    ) -> Sequence[Mapping[str, object] | None]:
        """Error estimates, one per torque; None without torque."""

    def results(
        self,
        scene: Scene,
        assembly: A,
        compliances: C,
        states: S,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque; `cost` contains the part of this torque."""

    def parameters(self, scene: Scene, parts: Parts | None = None) -> Parameters:
        """Discretization parameters; bodies are built only if their files determine these."""

    def describe(self, scene: Scene) -> Description:
        """Describe the interpreted scene."""

    def data_sheet(self, scene: Scene) -> DataSheet:
        """Drawing data of the bodies, computed from them."""

    def mesh_files(self, scene: Scene) -> Iterator[MeshFile]:
        """Meshes of the bodies at position zero."""

    def compliance_files(self, scene: Scene) -> Iterator[ComplianceFile]:
        """Compliances of the bodies; a SceneError if no file can hold them."""

    def record_files(self, scene: Scene) -> Mapping[str, Floats]:
        """Records of bodies, meshes and motions for the core, by name."""

    def fields_of_bodies(self, scene: Scene) -> Mapping[str, FieldsOfBody | str]:
        """Bodies with elements for the contact forces of results; otherwise the reason for none."""
