"""What was found: frozen results, their tables and their files."""

from flankload.result.export import (
    results_to_csv,
    results_to_json,
    write_atomically,
)
from flankload.result.friction import FrictionResult
from flankload.result.pairs import PairDrawing, PairTable
from flankload.result.result import Result, make_result

__all__ = [
    "FrictionResult",
    "PairDrawing",
    "PairTable",
    "Result",
    "make_result",
    "results_to_csv",
    "results_to_json",
    "write_atomically",
]
