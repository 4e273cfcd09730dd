"""Input of the program: scenes from TOML files or dictionaries, checked once and frozen.

This package checks the form of the input (types, keys, ranges, combinations of keys). Whether the
geometry is possible is checked by the packages `bodies` and `pairing`.
"""

from flankload.scene.accuracy import Accuracy
from flankload.scene.belt import Belt, Pulley
from flankload.scene.cam import Cam, Follower
from flankload.scene.carrier import Carrier
from flankload.scene.chain import Chain, Sprocket
from flankload.scene.effects.keys import EffectsAsked as Effects
from flankload.scene.gear import Gear, Ring
from flankload.scene.mesh import ComplianceBody, MeshBody, Profile
from flankload.scene.pair import Load, Positions
from flankload.scene.planet_flank import PlanetFlank
from flankload.scene.reader import SceneLike, read_scene, scene_of
from flankload.scene.scene import BodySpec, Scene
from flankload.scene.schema import scene_paths, scene_schema
from flankload.scene.shaft import Shaft
from flankload.scene.spline import SplineHub, SplineShaft
from flankload.scene.typed_pairs import (
    BeltAndPulley,
    CamAndFollower,
    ChainAndSprocket,
    DoubleHelicalPair,
    GearPair,
    IdlerTrain,
    PlanetaryStage,
    Spline,
    TwoPinions,
)

__all__ = [
    "Accuracy",
    "Belt",
    "BeltAndPulley",
    "BodySpec",
    "Cam",
    "CamAndFollower",
    "Carrier",
    "Chain",
    "ChainAndSprocket",
    "ComplianceBody",
    "DoubleHelicalPair",
    "Effects",
    "Follower",
    "Gear",
    "GearPair",
    "IdlerTrain",
    "Load",
    "MeshBody",
    "PlanetFlank",
    "PlanetaryStage",
    "Positions",
    "Profile",
    "Pulley",
    "Ring",
    "Scene",
    "SceneLike",
    "Shaft",
    "Spline",
    "SplineHub",
    "SplineShaft",
    "Sprocket",
    "TwoPinions",
    "read_scene",
    "scene_of",
    "scene_paths",
    "scene_schema",
]
