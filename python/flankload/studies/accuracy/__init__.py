"""What accuracy costs: ladders of all knobs, levels, combinations, the cheapest settings."""

from flankload.studies.accuracy.making import accuracy
from flankload.studies.accuracy.study import Row, Study

__all__ = ["Row", "Study", "accuracy"]
