"""The knobs that a scene has, their ladders, and how fine a study can afford to be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flankload.mechanisms.belt.drive import default_element_mm
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene import ComplianceBody, MeshBody, SplineShaft
from flankload.scene.discretization import DEFAULT
from flankload.setting import Setting
from flankload.steering.knobs import default_length, most_modes

if TYPE_CHECKING:
    from flankload.scene import Scene

#: Kinds that have neither pairs of flanks on circles nor pressure modes.
DRIVES = ("chain", "belt")
#: Knobs by the names of `Setting`, coarse steps first: parts of the default length of elements,
#: modes, strips and half-widths as they are, parts of the scene's number of positions.
ELEMENTS = (2.0, 1.0, 0.5, 0.25, 0.125)
#: The whole tooth of a belt has elements of this length: an eighth would take gigabytes.
BELT_ELEMENTS = ELEMENTS[:-1]
MODES = (3, 4, 5, 6, 8, 12)
STRIPS = (2.5, 5.0, 10.0, 20.0, 40.0)
ZONES = (1.2, 1.5, 2.0, 2.5, 3.0, 4.0)
COUNTS = (0.25, 0.5, 1.0, 2.0, 4.0)
#: Adaptive positions beside the even ones: tolerances, and how many they begin with.
ADAPTIVE = (0.03, 0.01, 0.003, 0.001)
ADAPTIVE_START = 8
#: The same for the reference, which begins with the most even positions.
KINKS = 3e-4
#: The finest setting: more modes spoil the ladder of elements, most of all on splines, and wider
#: zones carry nothing.
FINEST_MODES, FINEST_ZONE = 8, 3.0
#: Of a run at the default: elements take so much longer at these parts of their length.
ELEMENTS_COST = {0.125: 52.0, 0.25: 11.0, 0.5: 3.0, 1.0: 1.0}
#: Strips: work grows with a power of their number.
STRIPS_ORDER = 1.4
#: How fine the finest setting may be, finest first: parts of the elements' length, strips, parts
#: of the number of positions.
FINEST = ((0.125, 40.0, 4.0), (0.25, 40.0, 4.0), (0.25, 20.0, 2.0), (0.5, 20.0, 2.0))
#: Part of the budget that ladders may take; runs at the finest strips and positions in them, and
#: elements as often as the finest.
LADDERS_PART, LADDER_SWEEPS, LADDER_ELEMENTS = 0.6, 20.0, 1.5


@dataclass(frozen=True)
class Knobs:
    """Ladders of a scene, coarse steps first, by the names of `Setting`; without absent knobs.

    Attributes
    ----------
    ladders : dict of str to tuple
    base : Setting
        The default knobs, named.
    finest : Setting
    can_adapt : bool
        There are adaptive positions, too.
    """

    ladders: dict[str, tuple[float, ...]]
    base: Setting
    finest: Setting
    can_adapt: bool = True

    def step(self, setting: Setting, knob: str) -> int:
        """Which step of its ladder a knob stands on."""
        return self.ladders[knob].index(getattr(setting, knob))

    def coarser(self, setting: Setting, *names: str) -> Setting | None:
        """The setting with knobs a step coarser; None where one has none."""
        changed = {}
        for knob in names:
            if knob not in self.ladders or self.step(setting, knob) == 0:
                return None
            changed[knob] = self.ladders[knob][self.step(setting, knob) - 1]
        return replace(setting, **changed)  # type: ignore[arg-type]


def knobs_of(scene: Scene) -> Knobs:
    """All knobs of a scene with whole ladders.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Knobs
        Its finest setting is the first of `FINEST`.
    """
    if scene.body_2.kind in DRIVES:
        return _of_drives(scene)
    pair = build_bodies(scene)
    bodies = [(scene.body_1, pair.body_1), (scene.body_2, pair.body_2)]
    elastic = [(spec, body) for spec, body in bodies if not body.rigid]
    ladders: dict[str, tuple[float, ...]] = {}
    meshed = [
        default_length(spec, body)
        for spec, body in elastic
        if not isinstance(spec, MeshBody | ComplianceBody)
    ]
    if meshed:
        ladders["flank_element_mm"] = tuple(_rounded(min(meshed) * part) for part in ELEMENTS)
    most = min((most_modes(spec, body) for spec, body in elastic), default=0)
    if modes := tuple(mode for mode in MODES if mode <= most):
        ladders["modes"] = modes
    ladders["strips_per_half_width"] = STRIPS
    ladders["zone_half_widths"] = ZONES
    if scene.positions.angles_deg is None and pair.position_rad.size > 1:
        ladders["count"] = _counts(scene)
    base = Setting(
        flank_element_mm=ladders["flank_element_mm"][1] if meshed else None,
        modes=max((m for m in modes if m <= DEFAULT.modes), default=None),
        strips_per_half_width=10.0,
        zone_half_widths=2.5,
        count=scene.positions.count if "count" in ladders else None,
    )
    return finest_within(Knobs(ladders, base, base), FINEST[0])


def _of_drives(scene: Scene) -> Knobs:
    """Of chains and belts, which have knobs of their own: positions, and the elements of belts."""
    ladders: dict[str, tuple[float, ...]] = {}
    length = default_element_mm(scene) if scene.body_2.kind == "belt" else None
    if length is not None:
        ladders["flank_element_mm"] = tuple(_rounded(length * part) for part in BELT_ELEMENTS)
    if scene.positions.angles_deg is None:
        ladders["count"] = _counts(scene)
    base = Setting(
        flank_element_mm=None if length is None else ladders["flank_element_mm"][1],
        count=scene.positions.count if "count" in ladders else None,
    )
    return finest_within(Knobs(ladders, base, base, can_adapt=False), FINEST[0])


def _counts(scene: Scene) -> tuple[int, ...]:
    count = scene.positions.count
    return tuple(sorted({round(count * part) for part in COUNTS if count * part >= 1}))


def finest_within(knobs: Knobs, fineness: tuple[float, float, float]) -> Knobs:
    """The knobs with a finest setting, finer steps of elements, strips and positions left out."""
    part, strips, positions = fineness
    kept = dict(knobs.ladders)
    base = knobs.base
    if base.flank_element_mm is not None:
        least = base.flank_element_mm * part * 0.99
        kept["flank_element_mm"] = tuple(h for h in kept["flank_element_mm"] if h >= least)
    if "strips_per_half_width" in kept:
        kept["strips_per_half_width"] = tuple(
            n for n in kept["strips_per_half_width"] if n <= strips
        )
    if base.count is not None:
        kept["count"] = tuple(n for n in kept["count"] if n <= base.count * positions)
    modes = kept.get("modes", ())
    finest = Setting(
        flank_element_mm=kept["flank_element_mm"][-1] if "flank_element_mm" in kept else None,
        modes=max((int(m) for m in modes if m <= FINEST_MODES), default=None),
        strips_per_half_width=kept.get("strips_per_half_width", (None,))[-1],
        zone_half_widths=FINEST_ZONE if "zone_half_widths" in kept else None,
        count=int(kept["count"][-1]) if "count" in kept else None,
    )
    return replace(knobs, ladders=kept, finest=finest)


def affordable(knobs: Knobs, stages: dict[str, float], budget_s: float) -> Knobs:
    """The finest knobs whose ladders the budget is likely to pay.

    Parameters
    ----------
    knobs : Knobs
    stages : dict
        CPU seconds by stage of a run at their base.
    budget_s : float

    Returns
    -------
    Knobs
    """
    elements = sum(s for name, s in stages.items() if name.startswith("compliance"))
    sweeps = stages.get("sweep", 0.0) + stages.get("tangent", 0.0)
    if knobs.base.flank_element_mm is None:
        elements = 0.0
    for fineness in FINEST:
        part, strips, positions = fineness
        each = sweeps * (strips / 10.0) ** STRIPS_ORDER
        if knobs.base.count is not None:
            each *= positions
        ladders = LADDER_ELEMENTS * elements * ELEMENTS_COST[part] + LADDER_SWEEPS * each
        if ladders <= LADDERS_PART * budget_s:
            break
    return finest_within(knobs, fineness)


def _rounded(length: float) -> float:
    return float(f"{length:.3g}")


def can_lump(scene: Scene) -> bool:
    """Whether contacts can be lumped in places: not where flanks conform, or chains have none."""
    return not isinstance(scene.body_1, SplineShaft) and scene.body_2.kind not in DRIVES


def can_be_nodal(scene: Scene) -> bool:
    """Whether forces may stand at plain nodes: where both flanks are open and bring elements."""
    effects, bodies = scene.effects, (scene.body_1, scene.body_2)
    return (
        scene.body_2.kind not in (*DRIVES, "cam")
        and not any(isinstance(body, MeshBody | ComplianceBody) for body in bodies)
        and not (effects.coast_flank or effects.temperature_rise_K or effects.speed_rpm)
    )
