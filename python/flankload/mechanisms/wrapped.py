"""Common parts of belts and chains, which are wrapped around a wheel with teeth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np

from flankload.mechanisms.premises import Torque, broken_by_turn, largest_turn
from flankload.mechanisms.protocol import Description
from flankload.mechanisms.registry import require_flanks
from flankload.mechanisms.scene_bodies import PAIR
from flankload.result.result import Result
from flankload.scene.usual import question_notes

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies import Body
    from flankload.cost import Account
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.protocol import ComplianceFile, FieldsOfBody, MeshFile, Rows
    from flankload.mechanisms.reuse import Parts
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization


@dataclass(frozen=True)
class WrappedAssembly(ABC):
    """Positions of a wheel.

    Attributes
    ----------
    position_rad : (P,) array
        Angles of the wheel.
    pitches : int or None
        Pitches covered by the positions; None for single angles.
    """

    position_rad: Floats
    pitches: int | None

    @property
    @abstractmethod
    def pitch_rad(self) -> float:
        """Angle between adjacent teeth."""

    @property
    def bodies(self) -> tuple[Body, ...]:
        """None: a belt or a chain has no flanks, nor has its wheel."""
        return ()

    @property
    def meshes(self) -> tuple[GearMesh, ...]:
        """None, for the same reason."""
        return ()


@dataclass(frozen=True)
class WrappedStates:
    """States of a belt or a chain.

    Attributes
    ----------
    found : tuple of lists
        For each torque, the state at each position.
    known : None
        Similar states are not continued from these.
    """

    found: tuple[list[Any], ...]
    known: ClassVar[None] = None


def positions_of(scene: Scene, pitch_rad: float) -> tuple[Floats, int | None]:
    """(P,) Angles of the wheel, and the number of pitches they cover; None for single angles."""
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float)), None
    pitches = 1 if wanted.pitches == "hunting" else int(wanted.pitches)
    return pitch_rad * np.arange(wanted.count * pitches) / wanted.count, pitches


def slack_of(scene: Scene) -> float:
    """Tension of the slack strand, N."""
    slack = scene.load.slack_tension_N
    assert slack is not None
    return slack


def tight_tensions(scene: Scene, pitch_radius_mm: float) -> Floats:
    """Tension of the tight strand for each torque, N."""
    return np.array(scene.torques_Nmm) / pitch_radius_mm + slack_of(scene)


#: Types of a belt or a chain.
A = TypeVar("A", bound=WrappedAssembly)
S = TypeVar("S", bound=WrappedStates)


class Sites:
    """Teeth or rollers on the wheel at P positions, with common numbers.

    Parameters
    ----------
    first, count : sequences of P int
        First number, and number of teeth or rollers, at each position.

    Attributes
    ----------
    numbers : (S,) array
    """

    def __init__(self, first: Sequence[int], count: Sequence[int]) -> None:
        self._first = np.asarray(first)
        self.numbers = np.arange(self._first.min(), (self._first + count).max())

    def spread(self, values: Sequence[Floats], nothing: float = np.nan) -> Floats:
        """(P, S) Values of the sites at each position; `nothing` at absent sites."""
        found = np.full((len(values), self.numbers.size), nothing)
        for row, first, own in zip(found, self._first - self.numbers[0], values, strict=True):
            part = row[first : first + own.size]
            part[:] = own[: part.size]
        return found


def wrapped_result(
    scene: Scene,
    assembly: WrappedAssembly,
    number: int,
    sites: Sites,
    force_N: Sequence[Floats],
    warnings: tuple[str, ...],
    **own: Any,
) -> Result:
    """Result of all positions under the torque with this index.

    `force_N` are the forces of the sites of each position, `own` the fields of belts or chains.
    """
    force, pitches = sites.spread(force_N, nothing=0.0), assembly.pitches
    return Result(
        name=scene.name,
        torque_Nm=scene.torques_Nm[number],
        sites=sites.numbers,
        position_rad=assembly.position_rad,
        site_force_N=force,
        peak_pressure_MPa=np.zeros_like(force),
        corner_contact=np.zeros(force.shape, dtype=bool),
        pitch_rad=assembly.pitch_rad,
        period_rad=assembly.pitch_rad * (pitches or 1),
        closed=pitches is not None and assembly.position_rad.size > 1,
        warnings=(*question_notes(scene), *warnings),
        **own,
    )


class WrappedMechanism(ABC, Generic[A, S]):
    """Stages that are the same for belts and chains."""

    body_names = PAIR
    modes = None
    displaced = None

    @abstractmethod
    def assemble(self, scene: Scene) -> A:
        """Assembly of a scene, whose discretization follows from it."""

    @abstractmethod
    def stiffness(self, assembly: A, states: Sequence[Any]) -> Floats:
        """(P,) Tangent stiffness at the positions, N m/rad; NaN if nothing rotates."""

    @abstractmethod
    def result(
        self,
        scene: Scene,
        assembly: A,
        states: S,
        number: int,
        estimate: Mapping[str, object] | None,
    ) -> Result:
        """Result of the torque with this index."""

    @abstractmethod
    def rows(self, scene: Scene) -> dict[str, Rows]:
        """Name and value of each row of `flankload check`, by title."""

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None = None,
        parts: Parts | None = None,
        *,
        account: Account | None = None,
        modified_elements: bool = False,
    ) -> A:
        """Assemble wheel and strand; nothing is reused."""
        return self.assemble(scene)

    def sweeps(self, scene: Scene) -> int:
        """Number of sweeps: all positions, and the few positions of the estimate."""
        return 1

    def broken_by_geometry(self, assembly: A) -> Iterator[Broken]:
        """None: the geometry violates no premise."""
        yield from ()

    def broken_by_load(self, scene: Scene, assembly: A, states: S, number: int) -> Iterator[Broken]:
        """Premises that a torque violates: small displacements."""
        stiffness = self.stiffness(assembly, states.found[number])
        with np.errstate(divide="ignore", invalid="ignore"):
            turned_rad = largest_turn(scene.torques_Nm[number] / stiffness)
        yield from broken_by_turn(turned_rad, assembly.pitch_rad, Torque(scene, number))

    def results(
        self,
        scene: Scene,
        assembly: A,
        compliances: object,
        states: S,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque."""
        return tuple(
            self.result(scene, assembly, states, number, estimate)
            for number, estimate in enumerate(estimates)
        )

    def describe(self, scene: Scene) -> Description:
        """Describe wheel, strand, load and effects."""
        return Description(self.rows(scene), question_notes(scene))

    def mesh_files(self, scene: Scene) -> Iterator[MeshFile]:
        """Neither body has finite elements: a SceneError."""
        require_flanks(scene)
        yield from ()

    def compliance_files(self, scene: Scene) -> Iterator[ComplianceFile]:
        """Neither body has pressure modes: a SceneError."""
        require_flanks(scene)
        yield from ()

    def record_files(self, scene: Scene) -> dict[str, Floats]:
        """Neither body has flanks: a SceneError."""
        require_flanks(scene)
        return {}

    def fields_of_bodies(self, scene: Scene) -> dict[str, FieldsOfBody | str]:
        """Neither body has fields: a SceneError."""
        require_flanks(scene)
        return {}
