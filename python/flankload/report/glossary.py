"""Terms and symbols of a report; symbols of gears after ISO 21771 and ISO 6336."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

#: Symbol or term, and its meaning.
TERMS = {
    "transmission error": "rotation of body 1 beyond that of ideal rigid bodies, times the "
    "reference radius (gears: the base radius)",
    "PPTE": "peak to peak of the transmission error over the positions",
    "mesh order": "number of waves of the transmission error in one tooth pitch",
    "load share": "force of a pair divided by the sum of the forces of all pairs",
    "pair": "two flanks that meet; pair 0 meets at the pitch point at position 0, pairs with "
    "greater numbers are further into recess",
    "p_max": "largest pressure of a contact, off sharp corners",
    "w_max": "largest force per face width",
    "mesh stiffness": "of all pairs along the line of action, for the whole face width: slope of "
    "force over deflection (tangent), or force over deflection (secant)",
    "K_Hβ": "face load factor (ISO 6336-1): largest load over the face width, averaged over the "
    "mesh period, divided by its mean",
    "line load factor": "largest line load of all pairs together, at any position, divided by its "
    "mean",
    "σ_F": "stress along the surface of the tooth root",
    "P": "power of the torque on body 1 at the speed of the scene",
    "P_V": "power of the friction between the flanks, mean over the period",
    "η": "efficiency of the contacts alone",
    "z": "number of teeth",
    "m_n": "normal module",
    "m_t": "transverse module",
    "α_n": "normal pressure angle",
    "α_t": "transverse pressure angle",
    "α_wt": "working transverse pressure angle",
    "β": "helix angle on the reference cylinder",
    "x": "profile shift coefficient",
    "x_E": "profile shift coefficient of the flank with its tooth thickness allowance",
    "D": "pitch diameter of a spline",
    "d": "reference diameter (belts and chains: pitch diameter)",
    "d_b": "base diameter",
    "d_a": "tip diameter",
    "d_f": "root diameter",
    "d_Ff": "root form diameter: the involute begins",
    "d_Fa": "tip form diameter: a rounding or chamfer begins",
    "d_Na": "active tip diameter",
    "d_Nf": "active root diameter",
    "d_Ca": "diameter at which the tip relief begins",
    "d_w1": "working pitch diameter",
    "s_t": "transverse tooth thickness on the reference circle",
    "s_a": "tooth thickness on the tip circle",
    "W_k": "span measurement over k teeth of the finished gear",
    "C_αa": "tip relief",
    "C_αf": "root relief",
    "C_α": "profile crowning",
    "C_β": "lead crowning",
    "C_Hβ": "helix slope modification",
    "f_pt": "single pitch deviation, here per tooth along the base tangent",
    "f_Σδ": "misalignment of the axes in their plane",
    "f_Σβ": "misalignment of the axes across their plane",
    "b": "face width",
    "a": "centre distance",
    "u": "gear ratio",
    "p_bt": "transverse base pitch",
    "ε_α": "transverse contact ratio",
    "ε_β": "overlap ratio",
    "ε_γ": "total contact ratio",
    "j_wt": "circumferential backlash on the working pitch circles",
    "j_t": "circumferential backlash on the pitch circle",
    "j_bn": "normal backlash",
    "A to E": "points of the path of contact: A start, B and D ends of single contact, C pitch "
    "point, E end",
    "certificate": "proof, checked at each position, that forces and gaps satisfy the contact "
    "conditions",
    "estimated error": "estimate of the numerical error of the model, exceeded in about 1 of 20 "
    "cases; it does not cover what the model leaves out",
}
#: Terms of every report.
ALWAYS = (
    "transmission error",
    "load share",
    "pair",
    "mesh stiffness",
    "certificate",
    "estimated error",
)


def terms_of(symbols: Iterable[str], *, path: bool, orders: bool) -> tuple[tuple[str, str], ...]:
    """Terms that a report uses: of the symbols of its tables ("d_w1 / d_w2" are two), and others.

    `path` and `orders`: whether it shows the points of the path of contact, and mesh orders.
    """
    used = {part.strip(",") for symbol in symbols for part in symbol.split()}
    used |= {*ALWAYS, *(["A to E"] if path else []), *(["mesh order"] if orders else [])}
    return tuple((term, meaning) for term, meaning in TERMS.items() if term in used)
