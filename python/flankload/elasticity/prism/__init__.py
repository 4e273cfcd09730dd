"""Elastic bodies in three dimensions: prisms, straight or twisted."""

from flankload.elasticity.prism.flank_surface import flank_surface
from flankload.elasticity.prism.prism import Prism

__all__ = ["Prism", "flank_surface"]
