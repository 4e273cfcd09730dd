"""Premises of the model: a scene that violates one is refused, or its result is marked.

The model assumes small deformations of bodies that touch on their working flanks. Each premise is
one record with its limit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import PremiseError
from flankload.result.notes import OUTSIDE
from flankload.scene.usual import questions

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from flankload.base.arrays import Floats
    from flankload.result import Result
    from flankload.scene import Scene


@dataclass(frozen=True)
class Premise:
    """A condition that the model requires.

    Attributes
    ----------
    name : str
        Name in `result.outside_limits`.
    expected : str
        Expected condition, with the limit.
    """

    name: str
    limit: float
    expected: str


#: For drives without a module; for a cam's follower the limit is in radians.
ROTATION = Premise(
    "rotation", 0.1, "a rotation of body 1 under load of at most 0.1 of a pitch, or of a radian"
)


@dataclass(frozen=True)
class Broken:
    """A premise that is violated.

    Attributes
    ----------
    key : str
        Key that causes the violation.
    found : str
        Number found, as text.
    """

    premise: Premise
    key: str
    found: str

    def error(self, scene: Scene) -> PremiseError:
        """Error that refuses the scene."""
        return PremiseError(
            file=scene.file,
            key=self.key,
            expected=f"{self.premise.expected} (or effects.beyond_limits = true)",
            found=self.found,
        )

    @property
    def note(self) -> str:
        """Warning in the result."""
        return f"{OUTSIDE}: {self.key}: expected {self.premise.expected}, found {self.found}"


def require_premises(scene: Scene, broken: Iterable[Broken]) -> tuple[Broken, ...]:
    """Raise a PremiseError for the first violation, unless the scene allows them; return them."""
    violations = tuple(broken)
    if violations and not scene.effects.beyond_limits:
        raise violations[0].error(scene)
    return violations


def with_violations(result: Result, broken: Sequence[Broken]) -> Result:
    """A result with its violated premises, in the estimate and before other warnings."""
    if not broken:
        return result
    names, estimate = tuple(one.premise.name for one in broken), result.estimate
    if estimate is not None:
        estimate = {**estimate, "outside_limits": names}
    return replace(
        result,
        outside_limits=names,
        estimate=estimate,
        warnings=(*(one.note for one in broken), *result.warnings),
    )


def broken_by_turn(turned_rad: float, pitch_rad: float, torque: Torque) -> Iterator[Broken]:
    """Violation by too large a rotation of body 1 under load."""
    unit = min(pitch_rad, 1.0)
    if turned_rad > ROTATION.limit * unit:
        of = "a pitch" if unit < 1.0 else "a radian"
        yield torque.broken(ROTATION, f"{turned_rad / unit:.3g} of {of}")


class Torque:
    """A torque of a scene, as messages name it."""

    def __init__(self, scene: Scene, number: int, part: float = 1.0) -> None:
        self._scene, self._number = scene, number
        whole = scene.torques_Nm[number]
        self.under = f"under {whole:g} N m"
        if part < 1.0:
            self.under = f"already under {part * whole:.3g} N m, a part of {whole:g} N m"

    def broken(self, premise: Premise, found: str) -> Broken:
        """Violation by an unusual modulus if there is one, otherwise by the torque."""
        unusual = questions(self._scene)
        for key in ("body_1.young_modulus_MPa", "body_2.young_modulus_MPa"):
            if key in unusual:
                return Broken(premise, key, f"{found} {self.under}, with {unusual[key]}")
        listed = f"[{self._number}]" if self._scene.has_torque_list else ""
        return Broken(premise, f"load.torque_Nm{listed}", f"{found} {self.under}")


def largest_turn(turned_rad: Floats) -> float:
    """Lower bound of the rotation of body 1 by a torque: contacts get stiffer under load."""
    return float(np.max(turned_rad, where=np.isfinite(turned_rad), initial=0.0))
