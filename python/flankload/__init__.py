"""flankload: load distribution on the flanks of two elastic bodies that turn about parallel axes.

Each public name is imported from its package at first use, so that `import flankload` costs next to
nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flankload import errors
    from flankload.analysis.stage_modes import StageModes
    from flankload.api import Prepared, explore, natural_modes, prepare, sensitivity, solve
    from flankload.contact import (
        ContactState,
        solve_contact,
        solve_contact_general,
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
    from flankload.explorer import Explorer
    from flankload.export import write_vtu
    from flankload.result import Result
    from flankload.scene import (
        Accuracy,
        Belt,
        BeltAndPulley,
        Cam,
        CamAndFollower,
        Carrier,
        Chain,
        ChainAndSprocket,
        ComplianceBody,
        DoubleHelicalPair,
        Effects,
        Follower,
        Gear,
        GearPair,
        IdlerTrain,
        MeshBody,
        PlanetaryStage,
        PlanetFlank,
        Positions,
        Profile,
        Pulley,
        Ring,
        Scene,
        Shaft,
        Spline,
        SplineHub,
        SplineShaft,
        Sprocket,
        TwoPinions,
        read_scene,
    )
    from flankload.scene.iso_1328 import FlankTolerances, iso_1328
    from flankload.studies.accuracy import AccuracyStudy, accuracy
    from flankload.studies.design import DesignStudy, study
    from flankload.studies.optimisation import Optimum, optimise
    from flankload.studies.plan import Plan, plan
    from flankload.studies.robustness import Robust, robust
    from flankload.studies.sensitivity import Sensitivity
    from flankload.studies.verification import Verification, verify

__all__ = [
    "Accuracy",
    "AccuracyStudy",
    "Belt",
    "BeltAndPulley",
    "Cam",
    "CamAndFollower",
    "Carrier",
    "Chain",
    "ChainAndSprocket",
    "ComplianceBody",
    "ContactState",
    "DesignStudy",
    "DoubleHelicalPair",
    "Effects",
    "Explorer",
    "FlankTolerances",
    "FlankloadError",
    "Follower",
    "Gear",
    "GearPair",
    "IdlerTrain",
    "InputError",
    "MeshBody",
    "MeshError",
    "NegativeForce",
    "NoContactState",
    "Optimum",
    "OtherProgramError",
    "PivotLimit",
    "Plan",
    "PlanetFlank",
    "PlanetaryStage",
    "Positions",
    "PremiseError",
    "Prepared",
    "Profile",
    "Pulley",
    "Result",
    "Ring",
    "Robust",
    "Scene",
    "SceneError",
    "Sensitivity",
    "Shaft",
    "SingularContact",
    "Spline",
    "SplineHub",
    "SplineShaft",
    "Sprocket",
    "StageModes",
    "TwoPinions",
    "Verification",
    "__version__",
    "accuracy",
    "errors",
    "explore",
    "iso_1328",
    "natural_modes",
    "optimise",
    "plan",
    "prepare",
    "read_scene",
    "robust",
    "sensitivity",
    "solve",
    "solve_contact",
    "solve_contact_general",
    "solve_contact_sequence",
    "solve_contact_torques",
    "study",
    "verify",
    "write_vtu",
]

_MODULE_OF_NAME = {
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
    "Accuracy": "scene",
    "Belt": "scene",
    "BeltAndPulley": "scene",
    "Cam": "scene",
    "CamAndFollower": "scene",
    "Carrier": "scene",
    "Chain": "scene",
    "ChainAndSprocket": "scene",
    "ComplianceBody": "scene",
    "Effects": "scene",
    "Follower": "scene",
    "Gear": "scene",
    "GearPair": "scene",
    "MeshBody": "scene",
    "PlanetFlank": "scene",
    "PlanetaryStage": "scene",
    "IdlerTrain": "scene",
    "DoubleHelicalPair": "scene",
    "TwoPinions": "scene",
    "Positions": "scene",
    "Profile": "scene",
    "Pulley": "scene",
    "Ring": "scene",
    "Shaft": "scene",
    "Spline": "scene",
    "SplineHub": "scene",
    "SplineShaft": "scene",
    "Sprocket": "scene",
    "Scene": "scene",
    "read_scene": "scene",
    "FlankTolerances": "scene.iso_1328",
    "iso_1328": "scene.iso_1328",
    "ContactState": "contact",
    "solve_contact": "contact",
    "solve_contact_general": "contact",
    "solve_contact_sequence": "contact",
    "solve_contact_torques": "contact",
    "Plan": "studies.plan",
    "plan": "studies.plan",
    "Result": "result",
    "Optimum": "studies.optimisation",
    "Prepared": "api",
    "optimise": "studies.optimisation",
    "explore": "api",
    "natural_modes": "api",
    "prepare": "api",
    "sensitivity": "api",
    "solve": "api",
    "DesignStudy": "studies.design",
    "study": "studies.design",
    "Robust": "studies.robustness",
    "robust": "studies.robustness",
    "Sensitivity": "studies.sensitivity",
    "AccuracyStudy": "studies.accuracy",
    "accuracy": "studies.accuracy",
    "Verification": "studies.verification",
    "verify": "studies.verification",
    "Explorer": "explorer",
    "write_vtu": "export",
    "StageModes": "analysis.stage_modes",
}


def __getattr__(name: str) -> Any:
    if name == "errors":
        return import_module("flankload.errors")
    if name == "__version__":
        from importlib.metadata import version

        return version("flankload")
    if name == "Study":
        import warnings

        new = "AccuracyStudy, which accuracy returns (study returns a DesignStudy)"
        words = f"flankload.Study is {new}; the old name ends with 1.0"
        warnings.warn(words, DeprecationWarning, stacklevel=2)
        name = "AccuracyStudy"
    if name not in _MODULE_OF_NAME:
        raise AttributeError(f"module 'flankload' has no attribute {name!r}")
    return getattr(import_module(f"flankload.{_MODULE_OF_NAME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
