"""The protocol that every kind of drive implements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence

    from flankload.bodies import SectorMesh, WholeMesh
    from flankload.cost import Account
    from flankload.mechanisms.data_sheet import DataSheet
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import StageClock
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


class States(Protocol):
    """States of a drive at all positions."""

    @property
    def found(self) -> tuple[Any, ...]:
        """States in the form of the drive, one entry per torque."""


class Mechanism(Protocol):
    """A kind of drive, stage by stage.

    Each drive has its own types for assembly, compliances and states; later methods receive what
    earlier methods return.

    Attributes
    ----------
    no_flanks_reason : str or None
        None if both bodies are `Body` objects with flanks and elements; otherwise the kind of body
        2 and the reason why they have none, as error lines show them after "found".
    """

    @property
    def no_flanks_reason(self) -> str | None:
        """Kind of body 2 and the reason why the bodies have no flanks; None if they have."""

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None,
        account: Account,
        parts: Parts | None = None,
    ) -> Any:
        """Assemble the bodies without solving elements; a SceneError names an impossible input.

        Parts of earlier runs may be reused where a call would have the same arguments.
        """

    def work(self, scene: Scene, assembly: Any) -> Counted:
        """Counters by stage that are known before a run."""

    def sweeps(self, scene: Scene) -> int:
        """Largest number of sweeps over all positions, including those of the estimate."""

    def compliances(
        self,
        scene: Scene,
        assembly: Any,
        clock: StageClock,
        kept: MutableMapping[int, tuple[Any, Account]],
        parts: Parts | None = None,
    ) -> tuple[Any, Any]:
        """Solve the elements of both bodies not in `kept`; return the completed assembly too.

        A compliance that is found in `parts` has no stage and no cost.
        """

    def states(
        self,
        scene: Scene,
        assembly: Any,
        compliances: Any,
        clock: StageClock,
        similar: States | None = None,
        *,
        unloaded: bool = True,
    ) -> tuple[Any, States]:
        """States under all torques, and the assembly at all their positions.

        Those of a scene that differs by a small step may be continued. Without `unloaded`, the
        state without torque is not solved.
        """

    def broken_by_geometry(self, assembly: Any) -> Iterable[Broken]:
        """Premises that the geometry violates without load."""

    def broken_by_load(
        self, scene: Scene, assembly: Any, states: Any, number: int
    ) -> Iterable[Broken]:
        """Premises that the torque with this index violates."""

    def estimates(
        self, scene: Scene, assembly: Any, compliances: Any, states: Any, clock: StageClock
    ) -> Sequence[Mapping[str, object] | None]:
        """Error estimates, one per torque; None without torque."""

    def results(
        self,
        scene: Scene,
        assembly: Any,
        compliances: Any,
        states: Any,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque; `cost` contains the part of this torque."""

    def describe(self, scene: Scene) -> Description:
        """Describe the interpreted scene."""

    def data_sheet(self, scene: Scene) -> DataSheet:
        """Drawing data of the bodies, computed from them."""

    def meshes(self, scene: Scene) -> Iterator[MeshFile]:
        """Meshes of the bodies at position zero."""
