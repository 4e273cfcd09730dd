"""Elastic bodies in three dimensions: prisms, straight or twisted."""

from flankload.elasticity.prism.compliance import (
    Prism,
    flank_surface,
    prism_compliance,
    prism_unknowns,
)

__all__ = ["Prism", "flank_surface", "prism_compliance", "prism_unknowns"]
