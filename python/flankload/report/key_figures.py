"""Key figures of each torque with their estimated errors, as rows of a table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any

from flankload.base import number_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from flankload.result import Result

    CellOf = Callable[[Result], "Cell | None"]
    #: Name, symbol, unit, and the cell of a torque.
    Figure = tuple[str, str, str, CellOf]

#: Entries of the summary that need several positions.
OF_SEVERAL = ("transmission_error_peak_to_peak_um",)


@dataclass(frozen=True)
class Cell:
    """A number of a table: with all digits (text where it is not a number) and as printed.

    `error` is its estimated relative error, `note` the text behind it: where and on which pair.
    """

    value: float | int | str
    text: str
    error: float | None = None
    note: str = ""


@dataclass(frozen=True)
class Row:
    """A key figure, with a cell per torque; None where the figure is unknown."""

    name: str
    symbol: str
    unit: str
    cells: tuple[Cell | None, ...]


def key_rows(results: Sequence[Result]) -> tuple[Row, ...]:
    """Key figures that at least one torque has."""
    rows = [
        Row(name, symbol, unit, tuple(cell(result) for result in results))
        for name, symbol, unit, cell in _figures(results)
    ]
    return tuple(row for row in rows if any(cell is not None for cell in row.cells))


def percent(error: float | None) -> str:
    """Relative error as text with two digits; empty if there is none."""
    if error is None or not isfinite(error):
        return ""
    return number_text.percent(error)


def _figures(results: Sequence[Result]) -> Iterator[Figure]:
    """Key figures: name, symbol, unit and cell of each torque."""
    yield from _of_motion(results)
    yield from _of_contact(results)
    yield from (
        (
            "face load factor",
            "K_Hβ",
            "",
            _entry("face_load_factor", ".3f", error="face_load_factor"),
        ),
        ("the same by ISO 6336-1, for comparison", "K_Hβ", "", _entry("k_h_beta_iso", ".3f")),
        ("line load factor", "", "", _entry("line_load_factor", ".3f", error="line_load_factor")),
        ("axial position of the largest line load", "", "mm", _entry("peak_line_load_z_mm", ".2f")),
        ("axial force, largest", "F_x", "N", _entry("axial_force_N", ".1f")),
        ("tilting moment, largest", "", "N m", _entry("tilting_moment_Nm", ".3f")),
        (
            "tilt of the teeth by the shafts, mean",
            "",
            "µm/mm",
            _entry("tilt_mean_um_per_mm", ".4f"),
        ),
    )
    for z in (1, 2):
        for side in ("tension", "compression"):
            name = f"root stress of body {z}, largest {side}"
            yield name, "σ_F", "MPa", partial(_root, z=z, side=side)
    sliding = _entry("largest_sliding_mm_per_rad", ".2f")
    yield from (
        ("power", "P", "W", _entry("power_W", ".1f")),
        ("power loss by friction", "P_V", "W", _entry("power_loss_W", ".1f")),
        ("efficiency", "η", "%", _value(_efficiency, ".3f")),
        ("sliding, largest, per rad of rotation", "", "mm", sliding),
        ("force of a coast flank, largest", "", "N", _entry("coast_force_N", ".4g")),
        ("gap of the coast flanks, least", "", "µm", _entry("coast_flank_gap_min_um", ".1f")),
    )


def _of_motion(results: Sequence[Result]) -> Iterator[Figure]:
    for name, symbol, part in (("mean", "", "mean"), ("peak to peak", "PPTE", "peak_to_peak")):
        key = f"transmission_error_{part}"
        yield f"transmission error, {name}", symbol, "µm", _entry(f"{key}_um", ".2f", error=key)
    if any(_beyond(result) for result in results):
        by_load = _entry("transmission_error_by_load_mean_um", ".2f")
        yield "part of the mean by load", "", "µm", by_load
    count = max(len(one.summary["transmission_error_mesh_harmonics_um"] or ()) for one in results)
    for k in range(count):
        yield f"amplitude of mesh order {k + 1}", "", "µm", _value(partial(_harmonic, k=k), ".3f")


def _beyond(result: Result) -> bool:
    """Whether the state without load is a notable part of the mean."""
    mean, by_load = (
        result.summary[f"transmission_error_{kind}mean_um"] for kind in ("", "by_load_")
    )
    return bool(abs(by_load - mean) > 1e-3 * abs(mean))


def _of_contact(results: Sequence[Result]) -> Iterator[Figure]:
    yield f"loaded {results[0].words_for_sites[1]}", "", "", _loaded
    ratio = _entry("contact_ratio_under_load", ".3f", positive=True)
    yield "contact ratio under load", "", "", ratio
    total = "ε_γ" if results[0].summary["overlap_ratio"] else "ε_α"
    yield "contact ratio by geometry", total, "", _entry("contact_ratio_total", ".3f")
    key = "peak_pressure"
    pressure = _entry(f"{key}_MPa", ".0f", error="largest_pressure", place=key, positive=True)
    yield "largest pressure", "p_max", "MPa", pressure
    if results[0].engagement.has_pressures:
        key = "peak_line_load"
        line_load = _entry(f"{key}_N_per_mm", ".1f", error=key, place=key, positive=True)
        yield "largest line load", "w_max", "N/mm", line_load
    else:
        force = _value(lambda one: float(one.site_force_N.max()), ".4g")
        yield "largest force of one of them", "", "N", force
    share = _value(lambda one: 100 * one.summary["load_share_max"], ".2f", "load_share")
    yield "largest share of the force", "", "%", share
    yield "mesh load factor, largest", "K_γ", "", _entry("mesh_load_factor_max", ".4f")
    for kind in ("sun", "ring"):
        factor = _entry(f"{kind}_mesh_face_load_factor_max", ".3f")
        yield f"face load factor of the meshes with the {kind}, largest", "K_Hβ", "", factor
    yield "tilt of a planet, largest", "", "µrad", _entry("planet_tilt_max_urad", ".4g")
    yield "largest force on a pin", "", "N", _entry("pin_force_max_N", ".4g")
    line = _entry("pin_line_force_max_N_per_mm", ".4g")
    yield "largest force on a pin per mm of its bearing", "", "N/mm", line
    yield "displacement of the sun, largest", "", "µm", _entry("sun_orbit_max_um", ".2f")
    rim = _entry("ring_deflection_max_um", ".2f", positive=True)
    yield "deflection of the rim of the ring, largest", "", "µm", rim
    yield "torque on the ring, mean", "", "N m", _entry("ring_torque_mean_Nm", ".5g")
    yield "torque on the carrier, mean", "", "N m", _entry("carrier_torque_mean_Nm", ".5g")
    for k in (1, 2):
        factor = _entry("mesh_face_load_factors", ".3f", of=k)
        yield f"face load factor of {results[0].engagement.site_word} {k}", "K_Hβ", "", factor
    for k in (1, 2, 3):
        force = _entry("bearing_force_max_N", ".5g", of=k)
        yield f"force on the bearings of body {k}, largest", "", "N", force
    along = _entry("axial_motion_peak_to_peak_um", ".2f")
    yield "axial motion of body 1, peak to peak", "", "µm", along
    for kind in ("tangent", "secant"):
        key = f"stiffness_{kind}"
        stiffness = _entry(f"{key}_mean_N_per_um", ".2f", error=key)
        yield f"mesh stiffness, {kind}, mean", "", "N/µm", stiffness


def _entry(key: str, form: str, **options: Any) -> CellOf:
    return partial(_number, key=key, form=form, **options)


def _number(
    result: Result,
    key: str,
    form: str,
    *,
    of: int = 0,
    error: str = "",
    place: str = "",
    positive: bool = False,
) -> Cell | None:
    """Cell of an entry of the summary; `place` is the prefix of its position and pair.

    In a list, `of` is the number of the entry, from 1.
    """
    value = result.summary.get(key)
    if of and value is not None:
        value = value[of - 1] if of <= len(value) else None
    if value is None or (positive and value <= 0):
        return None
    if key in OF_SEVERAL and result.position_rad.size == 1:
        return None
    known = (result.estimate or {}).get(error) if error else None
    note = ""
    if place and result.summary.get(f"{place}_pair") is not None:
        pair, at = (result.summary[f"{place}_{what}"] for what in ("pair", "position_rad"))
        note = f"{result.words_for_sites[0]} {pair} at {degrees(at):.2f}°"
    return Cell(value, format(value, form), known, note)


def _value(of: Callable[[Result], float | None], form: str, error: str = "") -> CellOf:
    """Cells of a number that the summary does not have in this form."""

    def cell(result: Result) -> Cell | None:
        value = of(result)
        known = (result.estimate or {}).get(error)
        return None if value is None else Cell(value, format(value, form), known)

    return cell


def _loaded(result: Result) -> Cell:
    least, most = (result.summary[f"loaded_pairs_{end}"] for end in ("min", "max"))
    text = f"{least}" if least == most else f"{least} to {most}"
    return Cell(text, text)


def _harmonic(result: Result, k: int) -> float | None:
    found = result.summary["transmission_error_mesh_harmonics_um"]
    return found[k] if found else None


def _efficiency(result: Result) -> float | None:
    efficiency = None if result.friction is None else result.friction.efficiency
    return None if efficiency is None else 100 * efficiency


def _root(result: Result, z: int, side: str) -> Cell | None:
    found = result.summary.get(f"root_stress_{z}")
    if found is None:
        return None
    extreme = found[side]
    note = f"pair {extreme['pair']} at {degrees(extreme['position_rad']):.2f}°"
    if "z_mm" in extreme:
        note += f", z {extreme['z_mm']:.2f} mm"
    return Cell(extreme["stress_MPa"], f"{extreme['stress_MPa']:.0f}", None, note)
