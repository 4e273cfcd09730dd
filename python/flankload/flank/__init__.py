"""Flanks as plane curves parametrised by arc length: root fillet, active flank and tip.

Every body provides its flank in this form: quintic polynomials over intervals of arc length s [mm]
from the root (s = 0) to the tip. In the direction of increasing s the material is on the right:
with the unit tangent t, n = (-t_y, t_x) is the unit normal that points out of the material.
"""

from flankload.flank.curve import ACTIVE, FlankCurve
from flankload.flank.fit import CurvePiece, Place, fit_flank_curve, fit_tolerance_mm
from flankload.flank.nodes import curve_through_nodes, nodes_deviation
from flankload.flank.spline import Spline, interpolating_spline
from flankload.flank.turned import turned_along

__all__ = [
    "ACTIVE",
    "CurvePiece",
    "FlankCurve",
    "Place",
    "Spline",
    "curve_through_nodes",
    "fit_flank_curve",
    "fit_tolerance_mm",
    "interpolating_spline",
    "nodes_deviation",
    "turned_along",
]
