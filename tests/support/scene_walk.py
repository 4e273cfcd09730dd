"""Other values for every key of a scene, as far as a scene can have them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from msgspec import inspect

from flankload.scene import Scene
from flankload.scene.form import types_of
from flankload.scene.table import Table

#: Keys that need others beside them, or whose values are lists, by the last part of their path.
#: {} is the path of the table, {z} for the number of teeth.
TOGETHER: dict[str, tuple[dict[str, Any], ...]] = {
    # both gears have the same base pitch
    "module_mm": ({"body_1.module_mm": 4.51, "body_2.module_mm": 4.51},),
    "pressure_angle_deg": ({"body_1.pressure_angle_deg": 20.1, "body_2.pressure_angle_deg": 20.1},),
    "tip_relief_um": ({"{}.tip_relief_um": 7.0}, {"{}.tip_relief_um": 7.0, "{}.START": 0.4}),
    **dict.fromkeys(
        ("addendum_factor", "tip_alteration_factor"),
        (
            {
                **{"{}.tip_diameter_mm": None, "{}.addendum_factor": 0.98},
                **{"{}.tip_alteration_factor": 0.01},
            },
        ),
    ),
    **{
        f"{end}_relief_{key}": ({f"{{}}.{end}_relief_um": 7.0, f"{{}}.{end}_relief_{key}": value},)
        for end, key, value in (
            *(("tip", "length", "long"), ("root", "length", "short"), ("tip", "length_mm", 2.0)),
            *(("tip", "start_roll_angle_deg", 36.0), ("root", "start_roll_angle_deg", 15.0)),
        )
    },
    "normal_backlash_um": ({"{}.center_distance_mm": None, "{}.normal_backlash_um": 60.0},),
    "tip_relief_knee_um": (
        {
            **{"{}.tip_relief_um": 20.0, "{}.tip_relief_shape": "double_linear"},
            **{"{}.tip_relief_knee_um": 5.0, "{}.START": 0.8, "{}.KNEE": 0.4},
        },
    ),
    **dict.fromkeys(
        ("protuberance_mm", "protuberance_angle_deg", "grinding_stock_mm"),
        (
            {
                **{"{}.protuberance_mm": 0.2, "{}.protuberance_angle_deg": 10.0},
                **{"{}.grinding_stock_mm": 0.1},
            },
        ),
    ),
    "root_relief_um": ({"{}.root_relief_um": 7.0, "{}.ROOT": 1.1},),
    **dict.fromkeys(
        ("span_measurement_mm", "span_teeth"),
        ({"{}.span_measurement_mm": 21.48, "{}.span_teeth": 2},),
    ),
    **dict.fromkeys(
        ("ball_measurement_mm", "measuring_ball_mm"),
        ({"{}.ball_measurement_mm": 82.39, "{}.measuring_ball_mm": 7.3},),
    ),
    "pitch_errors_um": ({"{}.pitch_errors_um": [3.0]},),
    "tooth_helix_slope_um": ({"{}.tooth_helix_slope_um": [3.0]},),
    "web_width_mm": ({"{}.web_width_mm": 10.0, "{}.rim_thickness_mm": 8.0},),
    "face_width_mm": ({"{}.face_width_mm": 10.0},),
    "friction_coefficient": ({"{}.friction_coefficient": 0.07},),
    "torque_Nm": ({"{}.torque_Nm": [100.0, 200.0]},),
    "angles_deg": ({"positions": {"angles_deg": [0.0, 3.0]}},),
    "influence": ({"{}.influence": "finite"},),
    "contact": ({"{}.contact": "lumped"},),
    "segment_teeth": ({"{}.body": "segment", "{}.segment_teeth": 5},),
    "thermal_expansion_per_K": (
        {"{}.temperature_rise_K": 40.0, "{}.thermal_expansion_per_K": 1e-5},
    ),
    "support_expansion_per_K": (
        {"{}.temperature_rise_K": 40.0, "{}.support_expansion_per_K": 0.0},
    ),
    "density_kg_m3": ({"{}.speed_rpm": 3000.0, "{}.density_kg_m3": 7000.0},),
    "end_relief_um": ({"{}.end_relief_um": [3.0, 5.0], "{}.end_relief_length_mm": [4.0, 5.0]},),
    "shaft": (
        {
            "{}.shaft": {
                **{"diameters_mm": [35.0], "lengths_mm": [120.0], "gear_position_mm": 50.0},
                **{"bearing_positions_mm": [0.0, 120.0]},
                **{"radial_stiffness_N_per_um": [200.0, 200.0]},
                **{"axial_stiffness_N_per_um": [100.0, 0.0]},
            }
        },
    ),
    "max_count": ({"{}.adaptive": True, "{}.max_count": 12},),
    "adaptive": ({"{}.adaptive": True, "{}.max_count": 12},),
}
#: Keys that are changed together with the one that they belong to.
BESIDE = (
    *("tip_relief_start_diameter_mm", "tip_relief_knee_diameter_mm"),
    *("root_relief_start_diameter_mm", "end_relief_length_mm"),
)
#: Places of reliefs, as modules below the tip circle in `TOGETHER`.
PLACES = {
    "START": "tip_relief_start_diameter_mm",
    "KNEE": "tip_relief_knee_diameter_mm",
    "ROOT": "root_relief_start_diameter_mm",
}


def other_values(scene: Scene) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Changes of each key of a scene.

    Parameters
    ----------
    scene : Scene

    Yields
    ------
    path : str
    changes : list of dict
        To be tried in turn: not all of them are possible.
    """
    tables: dict[str, Table] = {
        **{"body_1": scene.body_1, "body_2": scene.body_2, "pair": scene.pair},
        **{"load": scene.load, "positions": scene.positions},
        **{"effects": scene.effects, "accuracy": scene.accuracy},
    }
    profiles = {f"{n}.profile": getattr(t, "profile", None) for n, t in tables.items()}
    tables |= {name: table for name, table in profiles.items() if isinstance(table, Table)}
    for name, table in tables.items():
        for key, kind in types_of(type(table)).items():
            if key == "profile":
                continue
            changes = [_filled(some, name, table) for some in TOGETHER.get(key, ())]
            old = getattr(table, key)
            changes += [{f"{name}.{key}": value} for value in _values(kind, old)]
            yield f"{name}.{key}", changes


def _filled(changes: dict[str, Any], name: str, table: Table) -> dict[str, Any]:
    """Changes with the path of their table and the paths that depend on it."""
    found = {path.replace("{}", name): value for path, value in changes.items()}
    for mark, key in PLACES.items():
        modules = found.pop(f"{name}.{mark}", None)
        if modules is not None:
            inwards = -1.0 if hasattr(table, "outer_diameter_mm") else 1.0
            below = modules * inwards * table.module_mm  # type: ignore[attr-defined]
            found[f"{name}.{key}"] = table.tip_diameter_mm - below  # type: ignore[attr-defined]
    for key in ("pitch_errors_um", "tooth_helix_slope_um"):
        if f"{name}.{key}" in found:
            rest = [0.0] * (getattr(table, "number_of_teeth", 24) - 1)
            found[f"{name}.{key}"] = [3.0, *rest]
    return found


def _values(kind: inspect.Type, old: Any) -> list[Any]:
    """Other values of a type, near the old one first."""
    extra: dict[str, Any] = {}
    if isinstance(kind, inspect.Metadata):
        extra, kind = kind.extra_json_schema or {}, kind.type
    members = kind.types if isinstance(kind, inspect.UnionType) else (kind,)
    values: list[Any] = []
    for member in members:
        if isinstance(member, inspect.LiteralType):
            values += [value for value in member.values if value != old]
        elif isinstance(member, inspect.BoolType):
            values.append(not old)
        elif isinstance(member, inspect.IntType):
            known = old if isinstance(old, int) else 4
            values += [known + 1, known - 1, 2 * known, *([] if old is not None else [known])]
        elif isinstance(member, inspect.FloatType):
            if isinstance(old, float) and old:
                values += [old * factor for factor in (1.001, 0.999, 1.02, 0.98)]
            low = extra.get("usual", [0.01])[0]
            values += [x for x in (0.01, 0.3, 2.0, 10 * low, 100 * low) if x != old]
    return values
