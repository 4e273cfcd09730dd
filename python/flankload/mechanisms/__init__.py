"""Kinds of drive behind one protocol: flank pairs, belts and chains.

Each kind of drive is one package here and one line of `REGISTRY`. `runner.run_once` solves a scene
of any kind stage by stage; the packages do not import each other.
"""

from flankload.mechanisms.protocol import Description, Mechanism, MeshFile, States
from flankload.mechanisms.registry import REGISTRY, mechanism_of
from flankload.mechanisms.reuse import Parts
from flankload.mechanisms.runner import Earlier, prepare, run_once
from flankload.mechanisms.stage_clock import Kept, Progress

__all__ = [
    "REGISTRY",
    "Description",
    "Earlier",
    "Kept",
    "Mechanism",
    "MeshFile",
    "Parts",
    "Progress",
    "States",
    "mechanism_of",
    "prepare",
    "run_once",
]
