"""Verification of a position with CalculiX: input deck of a nonlinear contact problem, comparison.

Scene → whole bodies in triangles, fine near possible contacts → deck → CalculiX → comparison.
"""

from flankload.studies.verification.calculix import Answer, files_of_deck
from flankload.studies.verification.compared import Verification
from flankload.studies.verification.comparison import verify
from flankload.studies.verification.size import FEWEST_SOLID, MOST_UNKNOWNS

__all__ = ["FEWEST_SOLID", "MOST_UNKNOWNS", "Answer", "Verification", "files_of_deck", "verify"]
