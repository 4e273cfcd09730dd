"""Robust design: scatter of results by tolerances, to first order and by Monte Carlo."""

from flankload.studies.robustness.first_order import FirstOrder
from flankload.studies.robustness.robust import Robust, robust
from flankload.studies.robustness.samples import Samples

__all__ = ["FirstOrder", "Robust", "Samples", "robust"]
