"""Verification of a position with CalculiX: input deck of a nonlinear contact problem, comparison.

Scene → whole bodies in triangles, fine near possible contacts → deck → CalculiX → comparison.
"""

from flankload.studies.verification.calculix import Answer, files_of_deck
from flankload.studies.verification.comparison import Verification, verify

__all__ = ["Answer", "Verification", "files_of_deck", "verify"]
