"""Kinds of drive behind one protocol: flank pairs, belts and chains.

A kind of drive is one room here and one line of `REGISTRY`. `runner.run` solves a scene of any kind
stage by stage; the rooms know nothing of each other.
"""

from flankload.mechanisms.protocol import Description, Mechanism, MeshFile, States
from flankload.mechanisms.registry import REGISTRY, mechanism_of
from flankload.mechanisms.runner import run_once
from flankload.mechanisms.stage_clock import Kept, Progress

__all__ = [
    "REGISTRY",
    "Description",
    "Kept",
    "Mechanism",
    "MeshFile",
    "Progress",
    "States",
    "mechanism_of",
    "run_once",
]
