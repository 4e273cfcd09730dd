"""What accuracy costs: ladders of all knobs, levels, combinations, the cheapest settings."""

from flankload.accuracy.making import accuracy
from flankload.accuracy.study import Row, Study

__all__ = ["Row", "Study", "accuracy"]
