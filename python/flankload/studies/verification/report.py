"""A verification as text and as JSON."""

from __future__ import annotations

import json
from itertools import pairwise
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.plain import plain
from flankload.base.torque import in_newton_metres

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats
    from flankload.studies.verification.compared import Layers, Verification


#: Names of values in a tree: of the position, and of flankload's solution.
OF_POSITION = ("name", "position", "position_rad", "torque_Nm", "sites", "corner_contact")
OF_FLANKLOAD = (
    *("rotation_rad", "site_force_N", "peak_pressure_MPa"),
    *("job_cpu_s", "positions", "position_cpu_s"),
)


def json_of(v: Verification) -> str:
    """Return everything as strict JSON (null for what is not a number)."""
    return json.dumps(plain(tree_of(v)), indent=2, allow_nan=False) + "\n"


def text_of(v: Verification) -> str:
    """Return the results of both programs side by side."""
    return "\n".join(line.rstrip() for line in _lines(v))


def tree_of(v: Verification) -> dict[str, Any]:
    """Return all results by name, with units; loads of the whole width."""
    tree: dict[str, Any] = {name: getattr(v, name) for name in OF_POSITION}
    tree["flankload"] = {name: getattr(v, name) for name in OF_FLANKLOAD}
    tree["deck"] = {"file": None if v.deck is None else str(v.deck)}
    tree["deck"] |= {name: getattr(v, name) for name in ("nodes", "elements", "finest_mm")}
    tree["calculix"] = None
    if v.layers is not None:
        tree["deck"] |= {"unknowns": v.layers.unknowns, "layer_ends_mm": v.layers.edges_mm}
        tree["flankload"] |= _line_load(v.layers, v.layers.line_load_N_per_mm)
    if v.calculix is not None:
        answer = v.calculix
        tree["calculix"] = {
            "version": answer.version,
            "rotation_rad": answer.rotation_rad,
            "site_force_N": answer.force_N_per_mm * v.face_width_mm,
            "peak_pressure_MPa": answer.pressure_MPa,
            "torque_found_Nm": in_newton_metres(answer.moment_N * v.face_width_mm),
            **{name: getattr(answer, name) for name in ("iterations", "cpu_s", "wall_s")},
        }
        if v.layers is not None and answer.line_load_N_per_mm is not None:
            tree["calculix"] |= _line_load(v.layers, answer.line_load_N_per_mm)
        tree["rotation_difference"] = v.rotation_difference
        tree["share_difference"] = v.share_difference
    return tree


def _line_load(layers: Layers, line_load_N_per_mm: Floats) -> dict[str, Any]:
    """Line load in the layers and its distribution over the width."""
    return {
        "line_load_N_per_mm": line_load_N_per_mm,
        "line_load_factor": layers.line_load_factor(line_load_N_per_mm),
    }


def _lines(v: Verification) -> Iterator[str]:
    theirs = tree_of(v)["calculix"] or {}

    def other(name: str, *place: int) -> float | None:
        return float(np.asarray(theirs[name])[place]) if name in theirs else None

    where = f"position {v.position} ({degrees(v.position_rad):.3f} deg)"
    yield f"{v.name}: {v.torque_Nm:g} N m, {where}"
    yield ""
    title = f"CalculiX {theirs['version']}" if theirs else "CalculiX"
    yield f"{'':<24}{'flankload':>14}{title:>16}{'difference':>16}"
    turned, um = other("rotation_rad"), 1000.0 * v.reference_radius_mm
    yield _row("rotation, rad", v.rotation_rad, turned, ".6e")
    error = None if turned is None else um * turned
    yield _row("transm. error, um", um * v.rotation_rad, error, ".3f")
    yield _row("torque of forces, N m", v.torque_Nm, other("torque_found_Nm"), ".2f")
    for s, site in enumerate(v.sites.tolist()):
        force = other("site_force_N", s)
        if not (v.site_force_N[s] or force):
            continue
        yield _row(f"pair {site}: load, N", v.site_force_N[s], force, ".1f", v.site_force_N.sum())
        if v.layers is None:
            mark, pressure = "*" if v.corner_contact[s] else "", other("peak_pressure_MPa", s)
            yield _row("  pressure, MPa" + mark, v.peak_pressure_MPa[s], pressure, ".1f")
    if v.layers is not None:
        yield from _width_lines(v, v.layers)
    seconds, scope = f"{'-':>16}", f"all {v.positions} positions"
    if theirs:
        seconds = f"{theirs['cpu_s']:>16.3g}"
        scope += f" versus one; flankload needs {v.position_cpu_s:.2g} s for each position"
    yield f"{'CPU seconds':<24}{v.job_cpu_s:>14.3g}{seconds}{'':>4}({scope})"
    yield ""
    if v.corner_contact.any():
        yield "* on a sharp corner, where no finite pressure exists"
    deck = f"deck: {v.nodes} nodes, {v.elements} six-node triangles, finest {v.finest_mm:.3g} mm"
    if v.layers is not None:
        deck = (
            f"deck: {v.layers.unknowns} unknowns, {v.elements} 15-node wedges in "
            f"{v.layers.edges_mm.size - 1} layers, finest {v.finest_mm:.3g} mm across the flank "
            f"(half-width of the contact {v.layers.half_width_mm:.3g} mm)"
        )
    yield f"{deck}; {theirs['iterations']} iterations" if theirs else deck
    if v.deck is not None:
        yield f"kept as {v.deck}"


def _width_lines(v: Verification, layers: Layers) -> Iterator[str]:
    """Line loads in the layers, in % of the mean of the most loaded pair; their distribution."""
    ours = layers.line_load_N_per_mm
    theirs = None if v.calculix is None else v.calculix.line_load_N_per_mm
    scale = v.site_force_N.max() / float(np.ptp(layers.edges_mm))
    for s, site in enumerate(v.sites.tolist()):
        if not ours[s].any() and (theirs is None or not theirs[s].any()):
            continue
        yield f"pair {site}: line load, N/mm"
        for k, (low, high) in enumerate(pairwise(layers.edges_mm)):
            other = None if theirs is None else theirs[s, k]
            yield _row(f"  z {low:.2f} to {high:.2f} mm", ours[s, k], other, ".1f", scale, "mean")
    factor = None if theirs is None else layers.line_load_factor(theirs)
    yield _row("line load factor", layers.line_load_factor(ours), factor, ".4f")


def _row(
    what: str,
    ours: float,
    theirs: float | None,
    form: str,
    scale: float | None = None,
    of: str = "all",
) -> str:
    """A line; the difference is relative to the second value, or to a total if there is one."""
    text = f"{what:<24}{ours:>14{form}}"
    if theirs is None:
        return f"{text}{'-':>16}{'-':>16}"
    base = theirs if scale is None else scale
    difference = f"{100 * (ours - theirs) / base:+.3f} %" if base else "-"
    return f"{text}{theirs:>16{form}}{difference:>16}" + (f" of {of}" if scale and base else "")
