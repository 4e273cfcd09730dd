"""A position by another program: the deck of a nonlinear contact problem for CalculiX, its answer
beside flankload's.

Scene → whole bodies in triangles, fine where flanks may touch → deck → CalculiX → comparison.
"""

from flankload.studies.verification.calculix import Answer, files_of_deck
from flankload.studies.verification.comparison import Verification, verify

__all__ = ["Answer", "Verification", "files_of_deck", "verify"]
