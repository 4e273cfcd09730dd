"""Accuracy study: refinement of all discretization parameters, and the cheapest settings."""

from flankload.studies.accuracy.making import accuracy
from flankload.studies.accuracy.study import Row, Study

__all__ = ["Row", "Study", "accuracy"]
