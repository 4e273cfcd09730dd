"""Accuracy study: refinement of all discretization parameters, and the cheapest discretizations."""

from flankload.studies.accuracy.run_study import accuracy
from flankload.studies.accuracy.study import AccuracyStudy, Row

__all__ = ["AccuracyStudy", "Row", "accuracy"]
