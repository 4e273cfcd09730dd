"""Questions to the user about values outside the usual range of their key."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from msgspec import Struct

from flankload.errors import SceneError
from flankload.scene.catalogue import estimate_notes
from flankload.scene.form import fields_of
from flankload.scene.refusal import shown
from flankload.scene.table import BODIES, SEVERAL_MESHES

if TYPE_CHECKING:
    from flankload.scene.scene import Scene, SceneFile
    from flankload.scene.table import Table

#: Factor between units of one quantity (um and mm, GPa and MPa), also squared (um and m).
THOUSAND = 1000.0
TABLES = (
    *(*BODIES, *SEVERAL_MESHES, "pair"),
    *("load", "positions", "effects", "accuracy"),
)
#: Units in which values are given by mistake, by the unit of the key and the factor between them.
MISTAKEN = {
    "um": {THOUSAND: "mm", THOUSAND**2: "m", 1 / THOUSAND: "nm"},
    "mm": {THOUSAND: "m", 1 / THOUSAND: "um", THOUSAND**-2: "nm"},
    "um/mm": {THOUSAND: "rad", 1 / THOUSAND: "um/m"},
    "mrad": {THOUSAND: "rad", 1 / THOUSAND: "urad"},
    "MPa": {THOUSAND: "GPa", 1 / THOUSAND: "kPa", THOUSAND**-2: "Pa"},
    "N m": {THOUSAND: "kN m", 1 / THOUSAND: "N mm"},
}
#: Least usual tangential force over face width, module and Young's modulus. Gears are designed for
#: 2e-5 to 2e-3; a torque in kN m gives a thousandth of it.
LEAST_LOAD = 2e-6


class Usual(NamedTuple):
    """Usual range of the magnitude of a key, and its unit.

    Attributes
    ----------
    per : (str, float) or None
        Name of a length of the body and the largest usual value per mm of it.
    """

    low: float
    high: float
    unit: str = ""
    per: tuple[str, float] | None = None

    def at(self, length_mm: float | None) -> Usual:
        """The range for a body with this length, if there is one."""
        if self.per is None or not length_mm:
            return self
        return self._replace(high=max(self.low, min(self.high, self.per[1] * length_mm)))


def questions(scene: Scene | SceneFile) -> dict[str, str]:
    """Value and question for each key of a scene with an unusual value, by path of the key."""
    found = {
        path: f"{shown(value)}, {asked}"
        for name in TABLES
        for path, value, usual in _numbers(getattr(scene, name), name, scene)
        if (asked := question(_largest(value), usual)) is not None
    }
    # a torque is compared with sizes and moduli: if one of these is unusual, it may be the cause
    about_torque = None if found else _question_of_torque(scene)
    return found if about_torque is None else {"load.torque_Nm": about_torque}


def question_notes(scene: Scene) -> tuple[str, ...]:
    """Lines of text: questions about unusual values and notes about estimated ones."""
    asked = (f"{path} = {text}" for path, text in questions(scene).items())
    return (*asked, *estimate_notes(scene))


def with_questions(error: SceneError, scene: Scene | SceneFile) -> SceneError:
    """The error of an impossible scene with the questions about its unusual values."""
    asked = [f"{key} = {text}" for key, text in questions(scene).items()]
    if not asked:
        return error
    found = f"{error.found}; unusual: {', '.join(asked)}"
    return SceneError(key=error.key, expected=error.expected, found=found, file=error.file)


def question(value: float, usual: Usual) -> str | None:
    """Question about a value whose magnitude is unusual; None for other values and for 0."""
    low, high, unit, per = usual
    if value == 0.0 or low <= abs(value) <= high:
        return None
    known = f"usual: {low:g} to {high:g} {unit}".rstrip()
    for factor in (THOUSAND, 1.0 / THOUSAND, THOUSAND**2, THOUSAND**-2):
        meant = value * factor
        if not low <= abs(meant) <= high or (per is not None and low <= abs(value)):
            continue
        mistaken = MISTAKEN.get(unit, {}).get(factor)
        slip = f"; {value:.12g} {mistaken} are {meant:.12g} {unit}" if mistaken else ""
        return f"did you mean {meant:.12g}? ({known}{slip})"
    limit = (
        "" if per is None else f", up to {per[1]:g} {unit} per mm of {per[0].removesuffix('_mm')}"
    )
    return f"is that what you mean? ({known}{limit})"


def _question_of_torque(scene: Scene | SceneFile) -> str | None:
    """Question about a torque that hardly loads teeth of this size."""
    body: Any = scene.body_1
    torque = max(scene.load.torques_Nm)
    module = getattr(body.flank_keys[1], "module_mm", None)
    teeth = getattr(body, "number_of_teeth", 0)
    if scene.pair is None or module is None or not teeth or torque == 0.0:
        return None
    area_mm2 = scene.pair.face_width_mm * module
    per_torque = THOUSAND * 2.0 / (module * teeth * area_mm2 * body.young_modulus_MPa)
    if per_torque * torque >= LEAST_LOAD:
        return None
    usual = Usual(LEAST_LOAD / per_torque, THOUSAND * LEAST_LOAD / per_torque, "N m")
    return f"{torque:g}, {question(torque, usual)}"


def _numbers(table: Any, key: str, scene: Scene | SceneFile) -> Iterator[tuple[str, Any, Usual]]:
    """Path, value and usual range of each key that has one."""
    if not isinstance(table, Struct):
        return
    usual = usual_ranges(type(table))
    for name in table.__struct_fields__:
        value, path = getattr(table, name), f"{key}.{name}"
        if isinstance(value, Struct):
            yield from _numbers(value, path, scene)
        elif value is not None and name in usual:
            yield path, value, usual[name].at(_length(table, usual[name], scene))


def _length(table: Any, usual: Usual, scene: Scene | SceneFile) -> float | None:
    """Length to which a usual range refers; None for splines, whose crowning allows large tilts."""
    if usual.per is None or getattr(table, "conforms", False):
        return None
    name = usual.per[0]
    return getattr(table, name, None) or getattr(scene.pair, name, None)


@cache
def usual_ranges(form: type[Table]) -> dict[str, Usual]:
    """The usual ranges in the annotations of a table, by key."""
    found = {}
    for name, field in fields_of(form).items():
        for meta in getattr(field.type, "__metadata__", ()):
            extra = meta.extra_json_schema or {}
            if "usual" in extra:
                low, high = extra["usual"]
                per = tuple(extra["usual_per"]) if "usual_per" in extra else None
                found[name] = Usual(low, high, extra.get("unit", ""), per)
    return found


def _largest(value: float | Sequence[float]) -> float:
    """The number, or the entry of a list with the largest magnitude."""
    if isinstance(value, Sequence):
        return max((float(part) for part in value), key=abs, default=0.0)
    return float(value)
