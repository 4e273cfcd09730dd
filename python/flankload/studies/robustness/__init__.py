"""Robust design: scatter of results by tolerances, to first order and by Monte Carlo."""

from flankload.studies.robustness.first_order import FirstOrder
from flankload.studies.robustness.samples import Failures, Samples
from flankload.studies.robustness.scatter import Robust, robust

__all__ = ["Failures", "FirstOrder", "Robust", "Samples", "robust"]
