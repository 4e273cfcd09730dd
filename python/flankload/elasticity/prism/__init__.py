"""Elastic bodies in three dimensions: prisms, straight or twisted."""

from flankload.elasticity.prism.compliance import (
    Prism,
    carried_and_held,
    flank_surface,
    prism_compliance,
    prism_unknowns,
)

__all__ = ["Prism", "carried_and_held", "flank_surface", "prism_compliance", "prism_unknowns"]
