"""Keys that follow from others, as on drawings: diameters, centre distance, width, reliefs.

The formulas are those of DIN 3960 and ISO 21771. `long` and `short` reliefs begin where the number
of pairs in contact changes from one to two, and half way from there to the end of the path of
contact.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import acos, cos, hypot, pi, radians, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

from msgspec import UNSET, structs

from flankload.base.involute import distance_of_backlash, ends_of_path
from flankload.scene.axial import AxialKeys, common_range
from flankload.scene.involute import InvoluteKeys
from flankload.scene.pair import Pair
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import BODIES, SMALLEST_LENGTH
from flankload.scene.thickness import Teeth, generating_shift
from flankload.scene.tree import number_at

if TYPE_CHECKING:
    from flankload.scene.scene import Scene, SceneFile

DISTANCE, WIDTH = "pair.center_distance_mm", "pair.face_width_mm"
#: Key of the centre distance of the second mesh of a train.
DISTANCE_2 = "train.center_distance_2_mm"
#: Contact ratios between which one and two pairs are in contact in turn.
ONE_PAIR, TWO_PAIRS = 1.0, 2.0


class _Flank(NamedTuple):
    """The keys of a flank, their path ("body_1", "body_2.profile"), and the teeth that have it."""

    keys: InvoluteKeys
    path: str
    teeth: Teeth

    @property
    def half_angle_rad(self) -> float:
        """Half the angle of a tooth at the base circle by its profile shift."""
        return self._half_angle(self.keys.profile_shift)

    @property
    def finished_half_angle_rad(self) -> float:
        """The same of the finished teeth."""
        teeth = self.teeth
        shift = generating_shift(self.keys, teeth.teeth, self.path, outward=teeth.outward)
        return self._half_angle(shift)

    def _half_angle(self, shift: float) -> float:
        half = self.teeth.base_half_angle(shift)
        return half if self.teeth.outward > 0 else half - pi / self.teeth.teeth


def with_tip_diameters(asked: SceneFile) -> SceneFile:
    """The scene with the tip diameters that follow from the addendum of the basic rack.

    d_a = d + 2 m_n (h_aP* + x + k); of internal teeth d - 2 m_n (h_aP* - x + k), since their
    profile shift is positive outwards.
    """
    for name in _bodies(asked):
        flank = _flank(asked, name)
        keys: Any = None if flank is None else flank.keys
        if flank is None or keys.tip_diameter_mm is not UNSET:
            continue
        teeth = flank.teeth
        height = teeth.outward * (keys.addendum_factor + keys.tip_alteration_factor)
        tip = 2.0 * teeth.reference_radius_mm + 2.0 * keys.module_mm * (height + keys.profile_shift)
        if tip < SMALLEST_LENGTH:
            expected = "an addendum with which the tip diameter is positive"
            refuse(f"{flank.path}.addendum_factor", expected, keys.addendum_factor)
        asked = _with_keys(asked, name, {"tip_diameter_mm": tip})
    return asked


def with_common_width(asked: SceneFile) -> SceneFile:
    """The scene with the overlap of both face widths as their common one.

    Raises
    ------
    SceneError
        If the bodies do not overlap.
    """
    one, two = asked.body_1, asked.body_2
    pair: Any = asked.pair or Pair()
    if asked.body_2.is_drive or pair.face_width_mm is not UNSET:
        return asked
    if not (isinstance(one, AxialKeys) and isinstance(two, AxialKeys)):
        return asked  # these kinds do not go together, which a later check refuses
    low, high = common_range(one, two)
    return structs.replace(asked, pair=structs.replace(pair, face_width_mm=high - low))


def with_pair_geometry(asked: SceneFile) -> SceneFile:
    """The scene with centre distance and starts of reliefs that follow from other keys.

    Raises
    ------
    SceneError
        If there is no such distance or place.
    """
    flanks = {name: _flank(asked, name) for name in _bodies(asked)}
    if asked.pair is not None and asked.pair.center_distance_mm is None:
        one, two = (flanks[name] for name in _mates(asked)[0])
        if one is not None and two is not None and not asked.body_1.conforms:
            distance = _distance(one, two, asked.pair.normal_backlash_um)
            asked = structs.replace(
                asked, pair=structs.replace(asked.pair, center_distance_mm=distance)
            )
    if asked.train is not None and asked.train.lacks_distance:
        one, two = (flanks[name] for name in _mates(asked)[1])
        if one is not None and two is not None:
            apart = {"center_distance_2_mm": _distance(one, two, None)}
            asked = structs.replace(asked, train=structs.replace(asked.train, **apart))
    for name, flank in flanks.items():
        if flank is not None and (starts := dict(_starts(asked, name, flank))):
            asked = _with_keys(asked, name, starts)
    return asked


def derived_keys(asked: SceneFile, given: Mapping[str, Any]) -> frozenset[str]:
    """Paths of the keys that follow from others; `given` is the scene as in the file."""
    found = set()
    for body in _bodies(asked):
        flank = _flank(asked, body)
        if flank is None:
            continue
        table = given
        for part in flank.path.split("."):
            table = table[part]
        for name in flank.keys.instead_of:
            if name not in table and getattr(flank.keys, name) is not None:
                found.add(f"{flank.path}.{name}")
    if asked.pair is not None:
        paths = {WIDTH} if asked.pair.center_distance_mm is None else {WIDTH, DISTANCE}
        found |= paths - {f"pair.{name}" for name in given.get("pair", {})}
    if asked.train is not None and asked.train.center_distance_2_mm is not None:
        found |= {DISTANCE_2} - {f"train.{name}" for name in given["train"]}
    return frozenset(found)


def derived_rows(scene: Scene) -> tuple[tuple[str, str], ...]:
    """Path, and value with its origin, of the keys that follow from others."""
    return tuple(
        (path, f"{number_at(scene, path):.4f} mm, by {source_of(scene, path)}")
        for path in sorted(scene.derived)
    )


def source_of(scene: Scene, path: str) -> str:
    """Words for the origin of a key that follows from others."""
    if path == WIDTH:
        return "the overlap of both face widths"
    place, _, name = path.rpartition(".")
    table: Any = scene
    for part in place.split("."):
        table = getattr(table, part)
    for other in table.instead_of[name]:
        if (value := getattr(table, other)) is not None:
            text = f"{value:g}" if isinstance(value, float) else shown(value)
            return f"{other} = {text}"
    return "the profile shifts, without backlash"


def _bodies(asked: SceneFile) -> tuple[str, ...]:
    """Names of the bodies."""
    return tuple(name for name in BODIES if getattr(asked, name) is not None)


def _mates(asked: SceneFile) -> tuple[tuple[str, str], ...]:
    """Names of the bodies of each gear mesh; the common centre distance is that of the first."""
    if asked.train is not None:
        return asked.train.meshes
    names = _bodies(asked)
    return tuple(pairwise(names))


def _flank(asked: SceneFile, name: str) -> _Flank | None:
    """Keys of the involute flank of a body; None without such keys or without teeth."""
    body = getattr(asked, name)
    inside, keys = body.flank_keys
    number = getattr(body, "number_of_teeth", 0)
    if not isinstance(keys, InvoluteKeys) or not number:
        return None
    outward = -1 if getattr(keys, "inward", False) else 1
    angle = radians(keys.pressure_angle_deg)
    teeth = Teeth(number, keys.module_mm, angle, keys.helix_rad, outward)
    return _Flank(keys, f"{name}.{inside}".rstrip("."), teeth)


def _with_keys(asked: SceneFile, name: str, changes: Mapping[str, float]) -> SceneFile:
    """The scene with other keys of the flank of a body."""
    body: Any = getattr(asked, name)
    inside, keys = body.flank_keys
    changed: Any = structs.replace(keys, **changes)
    if inside:
        changed = structs.replace(body, **{inside.rstrip("."): changed})
    return structs.replace(asked, **{name: changed})


# --- centre distance ------------------------------------------------------------------------------
def _distance(one: _Flank, two: _Flank, normal_backlash_um: float | None) -> float:
    """Centre distance by the profile shifts, or by the thickness of the finished teeth, mm."""
    _check_numbers(one, two)
    half_angles, backlash = (one.half_angle_rad, two.half_angle_rad), 0.0
    if normal_backlash_um is not None:
        half_angles = (one.finished_half_angle_rad, two.finished_half_angle_rad)
        # j_bt = j_bn/cos(b_b)
        backlash = normal_backlash_um / 1000.0 / cos(one.teeth.base_helix_rad)
    radii, pitch = _base_radii(one, two), one.keys.base_pitch_mm
    distance = distance_of_backlash(radii, half_angles, pitch, two.teeth.outward, backlash)
    if distance is None:
        expected = "a number: with these profile shifts the teeth fit at no centre distance"
        refuse(DISTANCE, expected, None)
    return distance


def _check_numbers(one: _Flank, two: _Flank) -> None:
    """Check that a gear inside a ring has fewer teeth."""
    if two.teeth.outward < 0 and one.teeth.teeth >= two.teeth.teeth:
        expected = f"fewer than the {two.teeth.teeth} teeth of body_2, inside which it turns"
        refuse("body_1.teeth", expected, one.teeth.teeth)


def _base_radii(one: _Flank, two: _Flank) -> tuple[float, float]:
    return one.teeth.base_radius_mm, two.teeth.base_radius_mm


# --- starts of reliefs ----------------------------------------------------------------------------
def _starts(asked: SceneFile, name: str, flank: _Flank) -> Iterator[tuple[str, float]]:
    """Diameters at which the reliefs of a flank begin, by key, mm."""
    base, outward = flank.teeth.base_radius_mm, flank.teeth.outward
    tip_roll = sqrt(max(0.0, (0.5 * flank.keys.tip_diameter_mm / base) ** 2 - 1.0))
    for end in ("tip", "root"):
        roll: float | None = None
        key = f"{end}_relief_length"
        angle_deg = getattr(flank.keys, f"{end}_relief_start_roll_angle_deg")
        length_mm = getattr(flank.keys, f"{key}_mm", None)
        if angle_deg is not None:
            roll = radians(angle_deg)
        elif length_mm is not None:
            roll = tip_roll - outward * length_mm / base
            if roll <= 0.0:
                expected = f"less than {base * tip_roll:.4f}, the length of roll at the tip"
                refuse(f"{flank.path}.{key}_mm", expected, length_mm)
        elif (extent := getattr(flank.keys, key)) is not None:
            roll = _roll_at_change(asked, name, f"{flank.path}.{key}", extent, at_tip=end == "tip")
        if roll is not None:
            yield f"{end}_relief_start_diameter_mm", 2.0 * base * hypot(1.0, roll)


def _roll_at_change(asked: SceneFile, name: str, key: str, extent: str, *, at_tip: bool) -> float:
    """Roll parameter at which a long or short relief begins; of a planet in its mesh with the sun.

    The path of contact runs from A, the tip of body 2, to E, the tip of body 1; a single pair is in
    contact between B = E - p_bt and D = A + p_bt.
    """
    mates = next(names for names in _mates(asked) if name in names)
    one, two = (_flank(asked, mate) for mate in mates)
    z = mates.index(name)
    if one is None or two is None or asked.body_1.conforms:
        expected = "nothing: it refers to the path of contact of two gears with involute profiles"
        refuse(key, expected, shown(extent))
    _check_numbers(one, two)
    assert asked.pair is not None
    distance = asked.pair.center_distance_mm
    if asked.train is not None and mates == asked.train.meshes[1]:
        distance = asked.train.center_distance_2_mm or distance
    assert distance is not None
    radii, sense = _base_radii(one, two), two.teeth.outward
    least = abs(radii[0] + sense * radii[1])
    if distance <= least:
        name = "sum" if sense > 0 else "difference"
        refuse(DISTANCE, f"more than the {name} of the base radii, {least:.4f} mm", distance)
    angle, pitch = acos(least / distance), one.keys.base_pitch_mm
    tips = (0.5 * one.keys.tip_diameter_mm, 0.5 * two.keys.tip_diameter_mm)
    apart = sense * (distance - tips[1]) - tips[0]
    if apart >= 0.0:
        backlash_um = asked.pair.normal_backlash_um
        origin = "" if backlash_um is None else f", by normal_backlash_um = {backlash_um:g}"
        found = f"{distance:g} mm: the tips pass each other {apart:.4f} mm apart{origin}"
        refuse(DISTANCE, "a distance at which the tips reach each other", found)
    start, end = ends_of_path(radii, tips, angle, sense)
    ratio = (end - start) / pitch
    if not ONE_PAIR < ratio < TWO_PAIRS:
        expected = f"nothing, unless the contact ratio is between {ONE_PAIR:g} and {TWO_PAIRS:g}"
        refuse(key, expected, f"{shown(extent)} with a contact ratio of {ratio:.4f}")
    # the tip of body 1 and the root of body 2 are at E
    far, change = (end, start + pitch) if at_tip == (z == 0) else (start, end - pitch)
    place = change if extent == "long" else 0.5 * (change + far)
    along = place if z == 0 else -sense * place
    return (radii[z] * sqrt((distance / least) ** 2 - 1.0) + along) / radii[z]
