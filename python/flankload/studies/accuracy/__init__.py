"""Accuracy study: refinement of all discretization parameters, and the cheapest discretizations."""

from flankload.studies.accuracy.run_study import accuracy
from flankload.studies.accuracy.study import Row, Study

__all__ = ["Row", "Study", "accuracy"]
