"""Keys of a scene that sliders change: from the schema, with range, step, unit and meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import floor, isfinite, log10
from typing import TYPE_CHECKING, Any

from msgspec import inspect

from flankload.base.number_text import number_of
from flankload.errors import SceneError
from flankload.scene.effects import effects_of
from flankload.scene.form import types_of
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import Table
from flankload.scene.usual import TABLES, Usual, usual_ranges

if TYPE_CHECKING:
    from flankload.scene import Scene

#: Tables whose keys are the drive and its load; the others set the discretization.
OF_DRIVE = tuple(name for name in TABLES if name not in ("positions", "accuracy"))
#: Those whose keys belong to no single body.
OF_BOTH = ("pair", "stage", "load", "effects")
#: Units of quantities that a designer adjusts about 0: modifications, deviations, loads.
ADJUSTED = ("um", "um/mm", "mrad", "N m", "N")
#: Keys with these units that nearly every design of a kind has, if the kind has the key.
COMMON = ("tip_relief_um", "profile_crowning_um", "lead_crowning_um", "pitch_difference_um",
          "inclination_um_per_mm", "deviation_um_per_mm", "misalignment_mrad")  # fmt: skip
#: What an absent key requires beside itself: where a relief begins, without a kink.
BESIDE: dict[str, dict[str, Any]] = {
    f"{end}_relief_um": {f"{end}_relief_length": "long", f"{end}_relief_shape": "parabolic"}
    for end in ("tip", "root")
}
#: Number of keys from which no others are added, and the largest number of sliders by default.
ENOUGH, MOST = 4, 9
#: Half the range of a dimension, as part of it; steps in a range, at least.
AROUND, STEPS = 0.1, 50


@dataclass(frozen=True)
class Key:
    """A numeric key of a scene with the range of its slider.

    Attributes
    ----------
    path : str
        As of `Scene.replace`.
    unit, meaning : str
        From the schema.
    value : float
        In the scene; 0 if the key is absent.
    low, high, step : float
        Of the slider: the usual range, within that of the schema.
    whole : bool
        Whether the key is an integer.
    absent : bool
        Whether the scene does not have the key.
    """

    path: str
    unit: str
    meaning: str
    value: float
    low: float
    high: float
    step: float
    whole: bool
    absent: bool

    @property
    def name(self) -> str:
        """The key in words, without its unit."""
        table, _, key = self.path.rpartition(".")
        suffix = self.unit.replace("/", "_per_").replace(" ", "").replace("-", "")
        key = key.split("[", maxsplit=1)[0].removesuffix(f"_{suffix}").replace("_", " ")
        body = table.partition(".")[0]
        return key if body in OF_BOTH else f"{key}, {body.replace('_', ' ')}"

    def number(self, value: float) -> float | int:
        """A value of a slider without the roundoff of its steps."""
        return round(value) if self.whole and value == round(value) else float(f"{value:.12g}")


def keys_of(scene: Scene) -> dict[str, Key]:
    """All numeric keys of the tables of a scene that describe the drive, by path."""
    return {
        key.path: key
        for name in OF_DRIVE
        if isinstance(table := getattr(scene, name), Table)
        and not (name == "pair" and scene.is_drive)
        for key in _keys_in(table, name, scene)
    }


def _keys_in(table: Table, path: str, scene: Scene) -> Iterator[Key]:
    """Numeric keys of a table and of the tables in it."""
    usual = usual_ranges(type(table))
    for name, form in types_of(type(table)).items():
        value, place = getattr(table, name), f"{path}.{name}"
        if isinstance(value, Table):
            yield from _keys_in(value, place, scene)
            continue
        number = _number_type(form)
        if number is None or isinstance(value, str | bool):
            continue
        if isinstance(value, tuple):  # torques: the slider changes the largest one
            if path != "load":
                continue
            place = f"{place}[{value.index(max(value))}]"
            value = max(value)
        extra = (form.extra_json_schema or {}) if isinstance(form, inspect.Metadata) else {}
        unit, meaning = str(extra.get("unit", "")), str(extra.get("description", ""))
        length = None
        if (known := usual.get(name)) and known.per is not None:
            length = getattr(table, known.per[0], None) or getattr(scene.pair, known.per[0], None)
            known = known.at(length)
        low, high, step = _range(value or 0.0, unit, number, known)
        whole = isinstance(number, inspect.IntType)
        absent = value is None or (value == 0 and place not in _paths(scene.to_dict()))
        yield Key(place, unit, meaning, value or 0, low, high, step, whole, absent)


def _number_type(form: inspect.Type) -> inspect.IntType | inspect.FloatType | None:
    """The type of a number among those of a key, with its limits."""
    while isinstance(form, inspect.Metadata):
        form = form.type
    members = form.types if isinstance(form, inspect.UnionType) else (form,)
    bare = [part.type if isinstance(part, inspect.Metadata) else part for part in members]
    found = [part for part in bare if isinstance(part, inspect.IntType | inspect.FloatType)]
    return found[0] if found else None


def _range(
    value: float, unit: str, number: inspect.IntType | inspect.FloatType, usual: Usual | None
) -> tuple[float, float, float]:
    """Range and step of a slider: both within the limits of the key."""
    limits = [number.ge if number.ge is not None else number.gt,
              number.le if number.le is not None else number.lt]  # fmt: skip
    if unit in ADJUSTED or value == 0:
        # a key without another scale has the half of its largest usual value
        scale = 2.0 * abs(value) or (0.5 * usual.high if usual and usual.per else 10.0)
        low, high = -scale, scale
        if unit in ("N m", "N"):
            low = 0.0
    else:
        low, high = value - AROUND * abs(value), value + AROUND * abs(value)
    step = 10.0 ** floor(log10((high - low) / STEPS))
    if isinstance(number, inspect.IntType):
        step, low, high = 1.0, min(low, value - 2), max(high, value + 2)
    low, high = (step * round(end / step) for end in (low, high))
    low = low if limits[0] is None else max(low, limits[0])
    high = high if limits[1] is None else min(high, limits[1])
    return float(f"{low:.12g}"), float(f"{high:.12g}"), step


def shown_keys(scene: Scene, keys: Mapping[str, Key], vary: Sequence[str]) -> tuple[Key, ...]:
    """Keys with a slider: those that are asked for, or those that designers of the kind adjust.

    Raises SceneError at a path that is no numeric key, or at an impossible range.
    """
    if vary:
        return tuple(dict.fromkeys(_asked(keys, text) for text in vary))
    is_spatial = effects_of(scene).three_dimensions
    adjusted = [key for key in keys.values() if key.unit in ADJUSTED and key.low < key.high]
    found = [key for key in adjusted if not key.absent]
    for key in adjusted:
        if key.absent and key.path.rpartition(".")[2] in COMMON:
            tried = with_values(scene, keys, {key.path: key.number(key.high)})
            if tried is not None and effects_of(tried).three_dimensions == is_spatial:
                found.append(key)
    for key in keys.values():
        if len(found) < ENOUGH and not key.absent and key not in found:
            found.append(key)
    order = list(keys.values())
    found.sort(key=lambda key: (not key.path.startswith("load."), order.index(key)))
    return tuple(found[:MOST])


def with_values(scene: Scene, keys: Mapping[str, Key], values: Mapping[str, float]) -> Scene | None:
    """The scene with other values of keys; None if it is impossible."""
    try:
        return scene.replace(changes_of(keys, values))
    except SceneError:
        return None


def changes_of(keys: Mapping[str, Key], values: Mapping[str, Any]) -> dict[str, Any]:
    """Changes of a scene, as of `Scene.replace`, that give keys their values.

    A relief that the scene does not have begins at the end of single contact.

    Raises SceneError at a path that is no numeric key, or at a value that is no number.
    """
    found: dict[str, Any] = {}
    for path, value in values.items():
        if path not in keys:
            refuse(str(path), "a numeric key of the scene", shown(path))
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            refuse(path, "a finite number", shown(value))
        table, _, name = path.rpartition(".")
        if keys[path].absent:
            found |= {f"{table}.{other}": word for other, word in BESIDE.get(name, {}).items()}
        found[path] = value
    return found


def _asked(keys: Mapping[str, Key], text: str) -> Key:
    """The key of PATH or PATH=LOW:HIGH, with that range."""
    path, equals, ends = (part.strip() for part in text.partition("="))
    if path not in keys:
        near = ", ".join(other for other in keys if other.endswith(path.rpartition(".")[2]))
        expected = "a numeric key of the scene" + (f" ({near})" if near else "")
        refuse("vary", expected, shown(path))
    key = keys[path]
    if not equals:
        return key
    try:
        low, high = (float(number_of(part)) for part in ends.split(":"))
    except ValueError:
        low = high = 0.0
    if not (isfinite(low) and isfinite(high) and low < high):
        refuse(f"vary.{path}", "two ascending numbers, LOW:HIGH", shown(ends))
    step = 1.0 if key.whole else 10.0 ** floor(log10((high - low) / STEPS))
    return Key(**{**key.__dict__, "low": low, "high": high, "step": step})


def _paths(tree: Mapping[str, Any], before: str = "") -> set[str]:
    """Dotted paths of all keys in a dictionary of tables."""
    found: set[str] = set()
    for name, value in tree.items():
        inner = isinstance(value, Mapping)
        found |= _paths(value, f"{before}{name}.") if inner else {f"{before}{name}"}
    return found
