"""Keys of a scene that sliders change: from the schema, with range, step, unit and meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from math import floor, inf, isfinite, log10
from typing import TYPE_CHECKING, Any

from msgspec import inspect

from flankload.base.number_text import number_of
from flankload.errors import SceneError
from flankload.plot.study_table import unit_of, words
from flankload.scene.effects import effects_of
from flankload.scene.form import types_of
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import Table
from flankload.scene.usual import TABLES, Usual, usual_ranges

if TYPE_CHECKING:
    from flankload.scene import Scene

    Number = inspect.IntType | inspect.FloatType

#: Tables whose keys are the drive and its load; the others set the discretization.
OF_DRIVE = tuple(name for name in TABLES if name not in ("positions", "accuracy"))
#: Units of quantities that a designer adjusts about 0: modifications, deviations, loads.
ADJUSTED = ("um", "um/mm", "mrad", "N m", "N")
#: Keys with these units that nearly every design of a kind has, if the kind has the key.
COMMON = ("tip_relief_um", "profile_crowning_um", "lead_crowning_um", "pitch_difference_um",
          "inclination_um_per_mm", "deviation_um_per_mm", "misalignment_mrad")  # fmt: skip
#: Keys that an absent key requires beside itself: start of a relief, shape without a kink.
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
        As for `Scene.replace`.
    unit, meaning : str
        From the schema.
    value : float
        In the scene; 0 if the key is absent.
    low, high, step : float
        Range and step of the slider: the usual range, within that of the schema.
    least, most : float
        Range of the schema.
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
    least: float
    most: float
    whole: bool
    absent: bool

    @property
    def name(self) -> str:
        """The key in words, with its unit."""
        path, bracket, entry = self.path.partition("[")
        return f"{words(path)}{bracket and ' '}{bracket}{entry}, {unit_of(path)}".rstrip(", ")

    @property
    def is_entry(self) -> bool:
        """Whether it is an entry of a list."""
        return self.path.endswith("]")

    def at(self, part: float) -> float | int:
        """The value at a part of the slider."""
        return self.number(self.low + part * (self.high - self.low))

    def number(self, value: float) -> float | int:
        """A value of a slider without the roundoff of its steps."""
        return round(value) if self.whole and value == round(value) else float(f"{value:.12g}")


def keys_of(scene: Scene) -> dict[str, Key]:
    """All numeric keys of the tables of a scene that describe the drive, by path."""
    given = scene.to_dict()
    names = [name for name in OF_DRIVE if not (name == "pair" and scene.is_drive)]
    return {
        key.path: key
        for name in names
        if isinstance(table := getattr(scene, name), Table)
        for key in _keys_in(table, name, given.get(name, {}), scene.pair)
    }


def _keys_in(table: Table, path: str, given: Mapping[str, Any], pair: Any) -> Iterator[Key]:
    """Numeric keys of a table and of the tables in it, and numeric entries of its lists."""
    usual = usual_ranges(type(table))
    for name, form in types_of(type(table)).items():
        value, place = getattr(table, name), f"{path}.{name}"
        if isinstance(value, Table):
            yield from _keys_in(value, place, given.get(name, {}), pair)
        is_list = isinstance(value, tuple)
        number = _number_type(form, in_list=is_list)
        entries = value if is_list else (0 if value is None else value,)
        if number is None or not all(map(_is_number, entries)):
            continue
        extra = (form.extra_json_schema or {}) if isinstance(form, inspect.Metadata) else {}
        unit, meaning = str(extra.get("unit", "")), str(extra.get("description", ""))
        if (known := usual.get(name)) and known.per is not None:
            length = known.per[0]
            known = known.at(getattr(table, length, None) or getattr(pair, length, None))
        limits = (number.ge, number.gt, -inf), (number.le, number.lt, inf)
        least, most = (next(float(end) for end in ends if end is not None) for ends in limits)
        whole, absent = isinstance(number, inspect.IntType), not value and name not in given
        for i, one in enumerate(entries):
            low, high = _range(one, unit, known, whole=whole)
            if low >= most or high <= least:  # 0 is no value of the key
                low, high = least, min(most, least + 10.0)
            step = _step(max(low, least), min(high, most), whole=whole)
            low, high = (float(f"{step * round(end / step):.12g}") for end in (low, high))
            yield Key(
                f"{place}[{i}]" if is_list else place, unit, meaning, one,
                max(low, least), min(high, most), step, least, most, whole, absent,
            )  # fmt: skip


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _number_type(form: inspect.Type, *, in_list: bool) -> Number | None:
    """The type of a number among those of a key, or of the entries of its list."""
    while isinstance(form, inspect.Metadata):
        form = form.type
    for part in form.types if isinstance(form, inspect.UnionType) else (form,):
        if in_list and isinstance(part, inspect.VarTupleType):
            return _number_type(part.item_type, in_list=False)
        bare = part.type if isinstance(part, inspect.Metadata) else part
        if isinstance(bare, inspect.IntType | inspect.FloatType) and not in_list:
            return bare
    return None


def _range(value: float, unit: str, usual: Usual | None, *, whole: bool) -> tuple[float, float]:
    """Ends of a slider."""
    if unit in ADJUSTED or value == 0:
        # a key without another scale has the half of its largest usual value
        high = 2.0 * abs(value) or (0.5 * usual.high if usual and usual.per else 10.0)
        low = 0.0 if unit in ("N m", "N") else -high
    else:
        low, high = value - AROUND * abs(value), value + AROUND * abs(value)
    return (min(low, value - 2), max(high, value + 2)) if whole else (low, high)


def _step(low: float, high: float, *, whole: bool) -> float:
    return 1.0 if whole or low >= high else float(10.0 ** floor(log10((high - low) / STEPS)))


def shown_keys(scene: Scene, keys: Mapping[str, Key], vary: Sequence[str]) -> tuple[Key, ...]:
    """Keys with a slider: those that are asked for, or those that designers of the kind adjust.

    Raises SceneError at a path that is not a numeric key, or at an impossible range.
    """
    if vary:
        return tuple(dict.fromkeys(_asked(keys, text) for text in vary))
    torques = [key for key in keys.values() if key.path.startswith("load.torque_Nm")]
    single = [key for key in keys.values() if not (key.is_entry or key in torques)]
    adjusted = [key for key in single if key.unit in ADJUSTED and key.low < key.high]
    found = [key for key in adjusted if not key.absent or _is_common(scene, keys, key)]
    names = [key.path.rpartition(".")[2] for key in single]
    more = (
        key
        for key, name in zip(single, names, strict=True)
        if not (key.absent or key.whole or key in found or names.count(name) > 1)  # mates agree
    )
    found += [key for _, key in zip(range(ENOUGH - 1 - len(found)), more, strict=False)]
    found.sort(key=lambda key: (not key.path.startswith("load."), single.index(key)))
    return max(torques, key=lambda key: key.value), *found[: MOST - 1]


def _is_common(scene: Scene, keys: Mapping[str, Key], key: Key) -> bool:
    """Whether nearly every design has a key, with which the scene is solved as without it."""
    if key.path.rpartition(".")[2] not in COMMON:
        return False
    try:
        tried = scene.replace(changes_of(keys, {key.path: key.number(key.high)}))
    except SceneError:
        return False
    return effects_of(tried).three_dimensions == effects_of(scene).three_dimensions


def changes_of(keys: Mapping[str, Key], values: Mapping[str, Any]) -> dict[str, Any]:
    """Changes of a scene, as for `Scene.replace`, that give keys their values.

    A relief that the scene does not have begins at the end of single contact.

    Raises SceneError at a path that is not a numeric key, or at a value that is not a number.
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
        near = " or ".join(get_close_matches(path, keys, n=2, cutoff=0.8))
        expected = "a numeric key of the scene" + (f" (did you mean {near}?)" if near else "")
        refuse("vary", expected, shown(path))
    key = keys[path]
    if not equals:
        return key
    try:
        low, high = (float(number_of(part)) for part in ends.split(":"))
    except ValueError:
        low = high = inf
    if not key.least <= low < high <= key.most or (key.whole and {low % 1, high % 1} != {0}):
        kind = "integers" if key.whole else "numbers"
        limits = f" from {key.least:g} to {key.most:g}" if isfinite(key.most) else ""
        refuse(f"vary.{path}", f"two ascending {kind}{limits}, LOW:HIGH", shown(ends))
    return replace(key, low=low, high=high, step=_step(low, high, whole=key.whole))
