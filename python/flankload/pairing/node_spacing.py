"""Spacing of flank nodes relative to the contact width."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.number_text import percent
from flankload.base.torque import in_newton_metres

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies import Body

#: Relative arc lengths at which the curvature of a flank is evaluated, away from its ends.
MIDDLE = np.linspace(0.3, 0.7, 9)

#: Distance of nodes with forces in Hertz half-widths, with the whole load on one flank. Errors on
#: the FZG type C pair: 0.07 to 0.2 % of the rotation away from tip corners, 0.3 to 15 % of the
#: largest pressure (largest on lightly loaded flanks); with a third 0.2 to 0.8 and up to 40 %, with
#: a tenth 0.03 to 0.08 and 1 %. The cost of elements grows as the square of the nodes.
NODE_SPACING = 0.2
#: Distance of nodes in half-widths above which there is a warning.
WIDE_SPACING = 0.6
#: Number of nodes along a conforming flank.
CONFORMING_NODES = 40


@dataclass(frozen=True)
class HertzContact:
    """Contact of two flanks at mid-height under one force.

    `flattening_mm` is the distance of the unloaded flanks at the ends of the contact.
    """

    half_width_mm: float
    flattening_mm: float


def _hertz_contact(
    bodies: tuple[Body, Body], torque_Nmm: float, face_width_mm: float
) -> HertzContact | None:
    """Hertz contact at mid-height with the whole torque on one flank.

    None without force, and for conforming flanks.
    """
    force_N_per_mm = torque_Nmm / bodies[0].reference_radius_mm / face_width_mm
    curvature = sum(_middle_curvature(body) for body in bodies)
    compliance = sum(
        (1 - body.material.poisson_ratio**2) / body.material.young_modulus_MPa
        for body in bodies
        if not body.rigid
    )
    if curvature <= 0.0 or force_N_per_mm <= 0.0 or compliance == 0.0:
        return None
    half_width = sqrt(4 * force_N_per_mm * compliance / (pi * curvature))
    return HertzContact(half_width, 0.5 * half_width**2 * curvature)


def spacing_notes(
    bodies: tuple[Body, Body], torques_Nmm: tuple[float, ...], face_width_mm: float
) -> Iterator[str]:
    """Notes on the node spacing of curves through nodes, relative to the narrowest contact."""
    loads = [torque for torque in torques_Nmm if torque > 0]
    if not loads or not any(body.flank_nodes for body in bodies):
        return
    contact = _hertz_contact(bodies, min(loads), face_width_mm)
    if contact is None:
        return
    where = f"with {in_newton_metres(min(loads)):g} N m on one flank"
    for name, body in zip(("body_1", "body_2"), bodies, strict=True):
        nodes = body.flank_nodes
        if nodes is None:
            continue
        note = (
            f"{name}: flank nodes up to {nodes.spacing_mm:.3g} mm apart, "
            f"{nodes.spacing_mm / contact.half_width_mm:.2g} Hertz half-widths "
            f"({contact.half_width_mm:.3g} mm {where})"
        )
        if np.isfinite(nodes.deviation_mm):
            part = nodes.deviation_mm / contact.flattening_mm
            note += f"; the curve deviates by about {percent(part)} of the flattening there"
        yield note


def spacing_for_loads(
    bodies: tuple[Body, Body], torques_Nmm: tuple[float, ...], face_width_mm: float
) -> float | None:
    """Distance of nodes for nodal forces, mm; None without torque.

    A fifth of the Hertz half-width with the whole of the largest torque on one unmodified flank;
    for conforming flanks a fraction of their length.
    """
    torque, bodies = max(torques_Nmm), (bodies[0].unmodified, bodies[1].unmodified)
    if torque <= 0.0 or all(body.rigid for body in bodies):
        return None
    contact = _hertz_contact(bodies, torque, face_width_mm)
    low, high = bodies[0].mode_range_mm
    widest = (high - low) / CONFORMING_NODES
    return widest if contact is None else min(widest, NODE_SPACING * contact.half_width_mm)


def wide_nodes_notes(
    bodies: tuple[Body, Body],
    nodes_mm: tuple[NDArray[np.float64] | None, NDArray[np.float64] | None],
    torque_Nmm: float,
    face_width_mm: float,
) -> Iterator[str]:
    """Notes on nodes with forces, at arc lengths (n,), with too large distances."""
    contact = _hertz_contact(bodies, torque_Nmm, face_width_mm)
    for name, nodes in zip(("body_1", "body_2"), nodes_mm, strict=True):
        if contact is None or nodes is None:
            continue
        parts = float(np.diff(nodes).max()) / contact.half_width_mm
        if parts > WIDE_SPACING:
            yield (
                f"{name}: nodes up to {parts * contact.half_width_mm:.2g} mm apart, {parts:.2g} "
                "Hertz half-widths with all of the torque on one flank: forces at nodes require "
                f"{NODE_SPACING:g} of one; these leave errors of percents in the rotation, and "
                "larger ones in the pressure"
            )


def _middle_curvature(body: Body) -> float:
    low, high = body.mode_range_mm
    return float(np.median(body.curve.curvature(low + (high - low) * MIDDLE)))
