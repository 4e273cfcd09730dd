"""Optimisation of a scene with gradients: objective and constraints of key figures.

Scene and tables → points with gradients of all nearly extremal numbers → steps of linear models →
rounding to steps of the machine → comparison with the given scene.
"""

from flankload.studies.optimisation.optimum import Limit, OptimisedVariable, Optimum
from flankload.studies.optimisation.problem import OptimisationFile
from flankload.studies.optimisation.run_optimisation import optimise

__all__ = ["Limit", "OptimisationFile", "OptimisedVariable", "Optimum", "optimise"]
