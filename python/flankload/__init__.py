"""flankload: load distribution on the flanks of two elastic bodies that turn about parallel axes.

The public names stand in pipeline order. Each is fetched from its room at first use, so that
`import flankload` costs next to nothing.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flankload import errors
    from flankload.api import solve
    from flankload.contact import (
        ContactState,
        solve_contact,
        solve_contact_general,
        solve_contact_on_demand,
        solve_contact_sequence,
        solve_contact_torques,
    )
    from flankload.errors import (
        FlankloadError,
        InputError,
        MeshError,
        NegativeForce,
        NoContactState,
        OtherProgramError,
        PivotLimit,
        PremiseError,
        SceneError,
        SingularContact,
    )
    from flankload.result import Result
    from flankload.scene import Scene, read_scene
    from flankload.studies.accuracy import Study, accuracy
    from flankload.studies.plan import Plan, plan
    from flankload.studies.verification import Verification, verify

__all__ = [
    "ContactState",
    "FlankloadError",
    "InputError",
    "MeshError",
    "NegativeForce",
    "NoContactState",
    "OtherProgramError",
    "PivotLimit",
    "Plan",
    "PremiseError",
    "Result",
    "Scene",
    "SceneError",
    "SingularContact",
    "Study",
    "Verification",
    "__version__",
    "accuracy",
    "errors",
    "plan",
    "read_scene",
    "solve",
    "solve_contact",
    "solve_contact_general",
    "solve_contact_on_demand",
    "solve_contact_sequence",
    "solve_contact_torques",
    "verify",
]

_ROOM_OF_NAME = {
    "FlankloadError": "errors",
    "InputError": "errors",
    "MeshError": "errors",
    "NegativeForce": "errors",
    "NoContactState": "errors",
    "OtherProgramError": "errors",
    "PivotLimit": "errors",
    "PremiseError": "errors",
    "SceneError": "errors",
    "SingularContact": "errors",
    "Scene": "scene",
    "read_scene": "scene",
    "ContactState": "contact",
    "solve_contact": "contact",
    "solve_contact_general": "contact",
    "solve_contact_on_demand": "contact",
    "solve_contact_sequence": "contact",
    "solve_contact_torques": "contact",
    "Plan": "studies.plan",
    "plan": "studies.plan",
    "Result": "result",
    "solve": "api",
    "Study": "studies.accuracy",
    "accuracy": "studies.accuracy",
    "Verification": "studies.verification",
    "verify": "studies.verification",
}


def __getattr__(name: str) -> Any:
    if name == "errors":
        return import_module("flankload.errors")
    if name == "__version__":
        from importlib.metadata import version

        return version("flankload")
    if name not in _ROOM_OF_NAME:
        raise AttributeError(f"module 'flankload' has no attribute {name!r}")
    return getattr(import_module(f"flankload.{_ROOM_OF_NAME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))


class _Package(ModuleType):
    """The package itself: `solve` is a room and a function, and the function keeps the name."""

    def __setattr__(self, name: str, value: Any) -> None:
        # Loading a room binds it to its name here; a public function of that name must stay.
        if name not in _ROOM_OF_NAME or not isinstance(value, ModuleType):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
