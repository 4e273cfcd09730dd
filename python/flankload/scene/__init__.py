"""What is asked: a scene, from a TOML file or a dictionary, checked once and frozen.

Here stands the form of the input (types, keys, ranges, combinations of keys). Whether the geometry
is possible is for the bodies and the pairing to say.
"""

from flankload.scene.belt_tables import Belt, Pulley
from flankload.scene.cam_tables import Cam, Follower
from flankload.scene.chain_tables import Chain, Sprocket
from flankload.scene.gear_tables import Gear, Ring, SplineHub, SplineShaft
from flankload.scene.mesh_tables import ComplianceBody, MeshBody, Profile
from flankload.scene.pair_tables import Load
from flankload.scene.scene import Scene
from flankload.scene.scene_file import read_scene, scene_schema
from flankload.scene.tables import BodySpec

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
    "SplineHub",
    "SplineShaft",
    "Sprocket",
    "read_scene",
    "scene_schema",
]
