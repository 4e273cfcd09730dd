"""The axis of torques of a result: quantities of one torque, joined for a list of torques."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np

from flankload.base.read_only import KeepsReadOnly, frozen

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.result.result import Result

T = TypeVar("T")


class PerTorque(cached_property[T]):
    """A quantity of one torque, computed on first use; of a list, `the result` joins it.

    Properties without this decorator are common to all torques.
    """

    @overload
    def __get__(self, result: None, owner: type[Any] | None = None) -> PerTorque[T]: ...
    @overload
    def __get__(self, result: object, owner: type[Any] | None = None) -> T: ...
    def __get__(self, result: Any, owner: type[Any] | None = None) -> Any:
        if result is None or not result.has_torque_list:
            return super().__get__(result, owner)
        assert self.attrname is not None
        vars(result)[self.attrname] = found = result._over_torques(self.attrname)
        return found


per_torque = PerTorque


class TorqueAxis(KeepsReadOnly):
    """A result, whose torques are always stored one by one."""

    @property
    def by_torque(self) -> tuple[Result, ...]:
        """The results of single torques: one per torque of a list, otherwise this one alone."""
        found: tuple[Result, ...] = vars(self).get("_by_torque", (self,))
        return found

    @property
    def has_torque_list(self) -> bool:
        """Whether arrays have an axis of torques, since the scene has a list of torques."""
        return "_by_torque" in vars(self)

    @property
    def torques_Nm(self) -> Floats:
        """(T,) Torques on body 1, N m; T = 1 unless the scene has a list of torques."""
        return frozen(np.array([one.torque_Nm for one in self.by_torque]))
