"""Elastic bodies in three dimensions: prisms, straight or twisted."""

from flankload.elasticity.prism.compliance import flank_surface, prism_compliance
from flankload.elasticity.prism.prism import Prism

__all__ = ["Prism", "flank_surface", "prism_compliance"]
