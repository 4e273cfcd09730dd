"""Compliance of the flanks of one body."""

from flankload.elasticity.compliance.body_compliance import (
    AxialModes,
    BodyCompliance,
    RootResponse,
    no_compliance,
)
from flankload.elasticity.compliance.job import JobOptions, flank_compliance, flank_compliances

__all__ = [
    "AxialModes",
    "BodyCompliance",
    "JobOptions",
    "RootResponse",
    "flank_compliance",
    "flank_compliances",
    "no_compliance",
]
