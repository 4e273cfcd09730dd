"""Compliance of the flanks of one body."""

from flankload.elasticity.compliance.body_compliance import BodyCompliance, no_compliance
from flankload.elasticity.compliance.contributions import (
    AxialModes,
    Expansion,
    FlankModes,
    NearField,
    RootResponse,
)
from flankload.elasticity.compliance.job import JobOptions, flank_compliance

__all__ = [
    "AxialModes",
    "BodyCompliance",
    "Expansion",
    "FlankModes",
    "JobOptions",
    "NearField",
    "RootResponse",
    "flank_compliance",
    "no_compliance",
]
