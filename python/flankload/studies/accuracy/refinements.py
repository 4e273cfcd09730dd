"""Discretization parameters of a scene, their steps, and the finest affordable discretization."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flankload.mechanisms import mechanism_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene.discretization import DEFAULT
from flankload.scene.named_discretization import NamedDiscretization
from flankload.studies.parameters import default_length, most_modes

if TYPE_CHECKING:
    from flankload.scene import Scene

#: Parameters by the names of `NamedDiscretization`, coarse steps first: element lengths relative to
#: the default, numbers of modes, cells and half-widths, numbers of positions relative to the
#: scene's.
ELEMENTS = (2.0, 1.0, 0.5, 0.25, 0.125)
#: Finest element length for a belt, whose whole tooth has this length: an eighth would take
#: gigabytes.
BELT_ELEMENTS = ELEMENTS[:-1]
MODES = (3, 4, 5, 6, 8, 12)
STRIPS = (2.5, 5.0, 10.0, 20.0, 40.0)
ZONES = (1.2, 1.5, 2.0, 2.5, 3.0, 4.0)
COUNTS = (0.25, 0.5, 1.0, 2.0, 4.0)
#: Adaptive positions in addition to even ones: tolerances, and initial numbers.
ADAPTIVE = (0.03, 0.01, 0.003, 0.001)
ADAPTIVE_START = 8
#: The same for the reference, which begins with the largest number of even positions.
KINKS = 3e-4
#: The finest discretization: more modes reduce the convergence of the elements, most of all on
#: splines, and wider zones are unloaded.
FINEST_MODES, FINEST_ZONE = 8, 3.0
#: Cost of elements at these relative lengths, compared with a run at the default.
ELEMENTS_COST = {0.125: 52.0, 0.25: 11.0, 0.5: 3.0, 1.0: 1.0}
#: The work is proportional to this power of the number of cells.
STRIPS_ORDER = 1.4
#: Possible limits of the finest discretization, finest first: relative element length, cells,
#: relative number of positions.
FINEST = ((0.125, 40.0, 4.0), (0.25, 40.0, 4.0), (0.25, 20.0, 2.0), (0.5, 20.0, 2.0))
#: Part of the budget for the steps of parameters; number of runs at the finest cells and positions
#: among them, and number of solutions with the finest elements.
LADDERS_PART, LADDER_SWEEPS, LADDER_ELEMENTS = 0.6, 20.0, 1.5


@dataclass(frozen=True)
class Refinements:
    """Steps of each parameter of a scene by the names of `NamedDiscretization`, coarse steps first.

    Attributes
    ----------
    ladders : dict of str to tuple
    base : NamedDiscretization
        The default parameters, named explicitly.
    finest : NamedDiscretization
    can_adapt : bool
        Whether adaptive positions are possible.
    """

    ladders: dict[str, tuple[float, ...]]
    base: NamedDiscretization
    finest: NamedDiscretization
    can_adapt: bool = True

    def step(self, discretization: NamedDiscretization, parameter: str) -> int:
        """Index of a parameter's value among its steps."""
        return self.ladders[parameter].index(getattr(discretization, parameter))

    def coarser(
        self, discretization: NamedDiscretization, *names: str
    ) -> NamedDiscretization | None:
        """A discretization with some parameters a step coarser; None if one has no such step."""
        changed = {}
        for parameter in names:
            if parameter not in self.ladders or self.step(discretization, parameter) == 0:
                return None
            changed[parameter] = self.ladders[parameter][self.step(discretization, parameter) - 1]
        return replace(discretization, **changed)  # type: ignore[arg-type]


def refinements_of(scene: Scene) -> Refinements:
    """All parameters of a scene with all steps.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Refinements
        Its finest discretization is the first of `FINEST`.
    """
    if scene.is_drive:
        return _of_drives(scene)
    pair = build_bodies(scene)
    bodies = [(scene.body_1, pair.body_1), (scene.body_2, pair.body_2)]
    elastic = [(spec, body) for spec, body in bodies if not body.rigid]
    ladders: dict[str, tuple[float, ...]] = {}
    meshed = [default_length(spec, body) for spec, body in elastic if not spec.from_file]
    if meshed:
        ladders["flank_element_mm"] = tuple(_rounded(min(meshed) * part) for part in ELEMENTS)
    most = min((most_modes(spec, body) for spec, body in elastic), default=0)
    if modes := tuple(mode for mode in MODES if mode <= most):
        ladders["modes"] = modes
    ladders["strips_per_half_width"] = STRIPS
    ladders["zone_half_widths"] = ZONES
    if scene.positions.angles_deg is None and pair.position_rad.size > 1:
        ladders["count"] = _counts(scene)
    base = NamedDiscretization(
        flank_element_mm=ladders["flank_element_mm"][1] if meshed else None,
        modes=max((m for m in modes if m <= DEFAULT.modes), default=None),
        strips_per_half_width=10.0,
        zone_half_widths=2.5,
        count=scene.positions.count if "count" in ladders else None,
    )
    return finest_within(Refinements(ladders, base, base), FINEST[0])


def _of_drives(scene: Scene) -> Refinements:
    """Parameters of chains and belts: positions, and the elements of belts."""
    ladders: dict[str, tuple[float, ...]] = {}
    length = mechanism_of(scene).default_element_mm(scene)
    if length is not None:
        ladders["flank_element_mm"] = tuple(_rounded(length * part) for part in BELT_ELEMENTS)
    if scene.positions.angles_deg is None:
        ladders["count"] = _counts(scene)
    base = NamedDiscretization(
        flank_element_mm=None if length is None else ladders["flank_element_mm"][1],
        count=scene.positions.count if "count" in ladders else None,
    )
    return finest_within(Refinements(ladders, base, base, can_adapt=False), FINEST[0])


def _counts(scene: Scene) -> tuple[int, ...]:
    count = scene.positions.count
    return tuple(sorted({round(count * part) for part in COUNTS if count * part >= 1}))


def finest_within(refinements: Refinements, fineness: tuple[float, float, float]) -> Refinements:
    """The parameters with a given finest discretization, without finer steps than that."""
    part, strips, positions = fineness
    kept = dict(refinements.ladders)
    base = refinements.base
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
    finest = NamedDiscretization(
        flank_element_mm=kept["flank_element_mm"][-1] if "flank_element_mm" in kept else None,
        modes=max((int(m) for m in modes if m <= FINEST_MODES), default=None),
        strips_per_half_width=kept.get("strips_per_half_width", (None,))[-1],
        zone_half_widths=FINEST_ZONE if "zone_half_widths" in kept else None,
        count=int(kept["count"][-1]) if "count" in kept else None,
    )
    return replace(refinements, ladders=kept, finest=finest)


def affordable(refinements: Refinements, stages: dict[str, float], budget_s: float) -> Refinements:
    """The finest parameters whose steps the budget can probably pay.

    Parameters
    ----------
    refinements : Refinements
    stages : dict
        CPU seconds by stage of a run at their base.
    budget_s : float

    Returns
    -------
    Refinements
    """
    elements = sum(s for name, s in stages.items() if name.startswith("compliance"))
    sweeps = stages.get("sweep", 0.0) + stages.get("tangent", 0.0)
    if refinements.base.flank_element_mm is None:
        elements = 0.0
    for fineness in FINEST:
        part, strips, positions = fineness
        each = sweeps * (strips / 10.0) ** STRIPS_ORDER
        if refinements.base.count is not None:
            each *= positions
        ladders = LADDER_ELEMENTS * elements * ELEMENTS_COST[part] + LADDER_SWEEPS * each
        if ladders <= LADDERS_PART * budget_s:
            break
    return finest_within(refinements, fineness)


def _rounded(length: float) -> float:
    return float(f"{length:.3g}")


def can_lump(scene: Scene) -> bool:
    """Whether a lumped contact model is possible: not for conforming flanks or chains."""
    return not (scene.body_1.conforms or scene.is_drive)


def can_be_nodal(scene: Scene) -> bool:
    """Whether nodal forces are possible: for two open flanks with finite elements."""
    effects, bodies = scene.effects, (scene.body_1, scene.body_2)
    return (
        not scene.is_drive
        and scene.body_2.has_teeth
        and not any(body.from_file for body in bodies)
        and not (effects.coast_flank or effects.temperature_rise_K or effects.speed_rpm)
    )
