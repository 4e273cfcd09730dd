"""One body's compliance at its flanks, from one finite-element job or from none."""

from flankload.elasticity.compliance.body_compliance import (
    AxialModes,
    BodyCompliance,
    RootResponse,
    no_compliance,
)
from flankload.elasticity.compliance.job import flank_compliance, flank_compliances

__all__ = [
    "AxialModes",
    "BodyCompliance",
    "RootResponse",
    "flank_compliance",
    "flank_compliances",
    "no_compliance",
]
