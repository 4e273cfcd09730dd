"""Comparison with reference results of other programs and closed forms: the open benchmark set.

Case files → values of this program, or answers of another one → comparison.
"""

from flankload.studies.benchmark.answers import Answers, answers_of, check_answers, read_answers
from flankload.studies.benchmark.case import Case, Quantity, read_cases
from flankload.studies.benchmark.comparison import Comparison, compare

__all__ = [
    "Answers",
    "Case",
    "Comparison",
    "Quantity",
    "answers_of",
    "check_answers",
    "compare",
    "read_answers",
    "read_cases",
]
