"""Input of the program: a scene from a TOML file or a dictionary, checked once and frozen.

This package checks the form of the input (types, keys, ranges, combinations of keys). Whether the
geometry is possible is checked by the packages `bodies` and `pairing`.
"""

from flankload.scene.belt import Belt, Pulley
from flankload.scene.cam import Cam, Follower
from flankload.scene.chain import Chain, Sprocket
from flankload.scene.gear import Gear, Ring, SplineHub, SplineShaft
from flankload.scene.mesh import ComplianceBody, MeshBody, Profile
from flankload.scene.pair import Load
from flankload.scene.reader import SceneLike, read_scene, scene_of
from flankload.scene.scene import Scene
from flankload.scene.scene_file import BodySpec
from flankload.scene.schema import scene_paths, scene_schema

__all__ = [
    "Belt",
    "BodySpec",
    "Cam",
    "Chain",
    "ComplianceBody",
    "Follower",
    "Gear",
    "Load",
    "MeshBody",
    "Profile",
    "Pulley",
    "Ring",
    "Scene",
    "SceneLike",
    "SplineHub",
    "SplineShaft",
    "Sprocket",
    "read_scene",
    "scene_of",
    "scene_paths",
    "scene_schema",
]
