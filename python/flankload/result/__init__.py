"""Results of a run: immutable objects with their tables and files."""

from flankload.base.files import write_atomically
from flankload.result.export import CsvForm, results_to_csv, results_to_json
from flankload.result.friction import FrictionResult
from flankload.result.pairs import PairDrawing, PairTable
from flankload.result.result import Result
from flankload.result.stiffness_table import StiffnessTable, stiffness_table
from flankload.result.table import texts_of as results_to_text
from flankload.result.workbook import results_to_xlsx

__all__ = [
    "CsvForm",
    "FrictionResult",
    "PairDrawing",
    "PairTable",
    "Result",
    "StiffnessTable",
    "results_to_csv",
    "results_to_json",
    "results_to_text",
    "results_to_xlsx",
    "stiffness_table",
    "write_atomically",
]
