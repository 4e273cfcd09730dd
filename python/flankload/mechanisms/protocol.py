"""The protocol that every kind of drive follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from flankload.bodies import SectorMesh, WholeMesh
    from flankload.cost import Account
    from flankload.mechanisms.duration import Duration
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.screening import Screening
    from flankload.mechanisms.stage_clock import StageClock
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization

    Counted = Mapping[str, Mapping[str, int]]
    Rows = list[tuple[str, str]]


@dataclass(frozen=True)
class Description:
    """What `flankload check` prints.

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
    """Mesh of a body at position zero, as `flankload mesh` writes it.

    Attributes
    ----------
    name : str
        Of the body.
    mesh : SectorMesh, WholeMesh or None
        None where the body has no mesh.
    words : str
        Part of the body that the mesh is of, or why there is none.
    turn_rad : float
        Turn of the body about its axis.
    """

    name: str
    mesh: SectorMesh | WholeMesh | None
    words: str
    turn_rad: float = 0.0


class Assembly(Protocol):
    """Bodies of a drive put together, before elements are solved."""

    @property
    def position_rad(self) -> NDArray[np.float64]:
        """(P,) Angles of body 1 from position zero."""


class States(Protocol):
    """States of a drive at all its positions."""

    @property
    def found(self) -> tuple[Any, ...]:
        """States in the form of the drive, one entry per torque."""


class Mechanism(Protocol):
    """A kind of drive, stage by stage.

    Assembly, compliances and states are the drive's own: what one method returns the next takes.

    Attributes
    ----------
    without_flanks : str or None
        Why the bodies are no `Body` with flanks and elements; None where they are.
    """

    @property
    def without_flanks(self) -> str | None:
        """Why the bodies have no flanks."""

    def build(self, scene: Scene, discretization: Discretization | None, account: Account) -> Any:
        """Assemble the bodies; no elements are solved. A SceneError names what is impossible."""

    def work(self, scene: Scene, assembly: Any) -> Counted:
        """Counters of a run by stage, as far as they are known before it."""

    def sweeps(self, scene: Scene) -> int:
        """Sweeps over all positions at the most, the estimate's included."""

    def compliances(
        self,
        scene: Scene,
        assembly: Any,
        clock: StageClock,
        kept: MutableMapping[int, tuple[Any, Account]],
    ) -> tuple[Any, Any]:
        """Solve the elements of both bodies that `kept` lacks; the assembly with what they add."""

    def states(
        self, scene: Scene, assembly: Any, compliances: Any, clock: StageClock
    ) -> tuple[Any, States]:
        """States under all torques; the assembly at all their positions."""

    def broken_by_geometry(self, assembly: Any) -> Iterable[Broken]:
        """Premises of the model that hold under no load."""

    def broken_by_load(
        self, scene: Scene, assembly: Any, states: Any, number: int
    ) -> Iterable[Broken]:
        """Premises of the model that the torque of this number breaks."""

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
        """Results, one per torque; `cost` holds what is the torque's own."""

    def describe(self, scene: Scene) -> Description:
        """Describe what is understood of a scene."""

    def meshes(self, scene: Scene) -> Iterator[MeshFile]:
        """Meshes of the bodies at position zero."""

    def duration(self, scene: Scene, assembly: Any) -> Duration | None:
        """Predict the seconds of a run from counted work; None where they are next to nothing."""

    def screening(self, scene: Scene, *, levels: bool) -> Screening:
        """Solve a scene on a coarse discretization, with its effects and with each switched."""

    def default_element_mm(self, scene: Scene) -> float | None:
        """Length of flank elements by default; None where it differs from body to body."""
