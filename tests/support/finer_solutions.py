"""Reference results of much finer solutions, kept in files: a changed estimate needs no new ones.

Each file names its scene and its refinement; if either has changed, the file is computed again.
A changed core is not detected: remove the files in this case.
"""

from __future__ import annotations

import json
import signal
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import PchipInterpolator

import flankload as fl
from flankload.analysis.error_rules import (
    FACE_LOAD,
    LINE_FACTOR,
    LINE_LOAD,
    PEAK_LINE,
    ROOT_STRESS,
)
from flankload.analysis.estimate import OVERALL, POINTWISE
from flankload.errors import FlankloadError
from flankload.mechanisms import run_once
from flankload.scene.discretization import (
    DEFAULT,
    Discretization,
    Grid,
    choose_discretization,
)
from tests.support.resolved_peaks import with_resolved_peaks

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from numpy.typing import NDArray

#: Refinement factors of elements, cells and positions. Cells of splines cover whole flanks, and
#: their refinement would take too long.
FINER, FINER_SPLINE = (8, 4, 4), (8, 2, 2)
#: In three dimensions: relative element lengths, positions (the first with states at all of them),
#: and keys of [accuracy]. Cells at the positions of the scene; the change by more positions is that
#: of lumped contacts on the same bodies.
FINER_SPATIAL = (0.6, (8, 6, 4))
SPATIAL = {"modes": 7, "axial_degree": 10, "load_degree_z": 6, "slices": 56, "estimate": False}
#: Modes for elements eight times as fine (70 and more along a flank). On elements four times as
#: fine, pressures at the ends of a flank are up to 9 % too high with 12 modes; with 8 modes, the
#: error of some quantities is still a third of that at the default.
MODES = 12
#: Stored results are computed again if the definition of a quantity changes.
DEFINED = {
    "stiffness_secant": "from the state without torque",
    "line_load": "of slices",
    "root_stress": "largest tension",
    "overall": "with the change by more positions",
}
OF_PERIOD = (PEAK_LINE, FACE_LOAD, LINE_FACTOR)
QUANTITIES = (*POINTWISE, *OVERALL, ROOT_STRESS, LINE_LOAD, *OF_PERIOD)
#: CPU seconds after which a solution is abandoned.
MOST_CPU_S = 90.0


@dataclass(frozen=True)
class Truth:
    """Results of a finer solution, as in `Result`.

    Attributes
    ----------
    sites : (S,) array
    position_rad, rotation_rad : (P,)
    load_share, peak_pressure_MPa, corner_contact : (P, S) arrays
    slice_width_mm : (J,) array
    slice_line_load_N_per_mm : (P, S, J) array
    overall : (4,) or (7,) array
        `overall_values`.
    root_tension_MPa : (2, P) array
        Largest tension in the roots of both bodies, NaN without fillets.
    """

    sites: NDArray[np.int64]
    position_rad: NDArray[np.float64]
    rotation_rad: NDArray[np.float64]
    load_share: NDArray[np.float64]
    peak_pressure_MPa: NDArray[np.float64]
    corner_contact: NDArray[np.int64]
    slice_width_mm: NDArray[np.float64]
    slice_line_load_N_per_mm: NDArray[np.float64]
    overall: NDArray[np.float64]
    root_tension_MPa: NDArray[np.float64]


def kept_truth(scene: dict[str, Any], file: Path) -> Truth | None:
    """Reference of a scene from its file, or computed and stored.

    None if it takes too long, is refused for its load, or if its cells have no state.
    """
    names = [field.name for field in fields(Truth)]
    key = json.dumps(
        [scene, FINER, FINER_SPLINE, FINER_SPATIAL, SPATIAL, MODES, DEFINED], sort_keys=True
    )
    if file.exists():
        with np.load(file) as stored:
            if str(stored["scene"]) == key:
                there = "rotation_rad" in stored
                return Truth(**{name: stored[name] for name in names}) if there else None
    truth, arrays = None, {}
    with suppress(TooLongError, FlankloadError), at_most(MOST_CPU_S):
        truth = finer_solution(scene)
        arrays = {name: getattr(truth, name) for name in names}
    file.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(file, scene=key, **arrays)
    return truth


def finer_solution(scene: dict[str, Any], finer: tuple[int, int, int] | None = None) -> Truth:
    """The scene with all discretization parameters refined, by default by those above."""
    scene = with_root_stress(scene)
    if is_spatial(scene):
        return _finer_spatial(scene)
    splined = scene["body_1"]["kind"] == "spline_shaft"
    elements, cells, positions = finer or (FINER_SPLINE if splined else FINER)
    count = positions * scene["positions"]["count"]
    fine = fl.Scene.from_dict(
        {**scene, "positions": {"count": count}, "accuracy": {"estimate": False}}
    )
    default = choose_discretization(fine)
    (result,) = run_once(
        fine,
        {},
        discretization=Discretization(
            default.flank_element_parts / elements,
            MODES,
            Grid(
                cells * default.grid.strips_per_half_width,
                cells * default.grid.corner_strips_per_half_width,
                default.grid.zone_half_widths,
            ),
        ),
    )
    return _truth_of(result)


def is_spatial(scene: dict[str, Any]) -> bool:
    return scene.get("effects", {}).get("dimension") == 3


def _finer_spatial(scene: dict[str, Any]) -> Truth:
    part, positions = FINER_SPATIAL
    length = part * DEFAULT.flank_element_parts * scene["body_1"]["module_mm"]
    count, kept = scene["positions"]["count"], {}

    def solved(contact: str, count: int) -> fl.Result:
        fine = {
            **scene,
            "positions": {"count": count},
            "effects": {**scene["effects"], "contact": contact},
            "accuracy": {**SPATIAL, "flank_element_mm": length},
        }
        return run_once(fl.Scene.from_dict(fine), kept)[0]

    truth, few = _truth_of(solved("pairs", count)), overall_values(solved("lumped", count))
    for times in positions:
        with suppress(FlankloadError):  # some of many positions may have no state
            many = overall_values(solved("lumped", times * count))
            return replace(truth, overall=truth.overall * many / few)
    return truth


def _truth_of(result: fl.Result) -> Truth:
    own = {
        "slice_width_mm": _widths(result),
        "overall": overall_values(result),
        "root_tension_MPa": root_tension(result),
    }
    names = {field.name for field in fields(Truth)} - set(own)
    return Truth(**{name: np.asarray(getattr(result, name)) for name in names}, **own)


def overall_values(result: fl.Result) -> NDArray[np.float64]:
    """Values over all positions, in the order of `OVERALL` and, with a width, `OF_PERIOD`."""
    rotation, values = result.rotation_rad, []
    if result.slices is not None:
        largest = result.mean_line_load_N_per_mm.max()
        values = [largest, result.face_load_factor, result.line_load_factor]
    secant, tangent = result.stiffness_secant_Nm_per_rad, result.stiffness_tangent_Nm_per_rad
    return np.array([rotation.mean(), np.ptp(rotation), secant.mean(), tangent.mean(), *values])


def root_tension(result: fl.Result) -> NDArray[np.float64]:
    """Largest tension (2, P) in the roots of both bodies; NaN where none is known."""
    none = np.full(result.position_rad.size, np.nan)
    return np.array(
        [
            none if stress is None else stress.tension.stress_MPa.max(axis=1)
            for stress in result.root_stress
        ]
    )


def with_root_stress(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene with root stress if its bodies have fillets."""
    if scene["body_1"]["kind"] == "follower":
        return scene
    return {**scene, "effects": {**scene.get("effects", {}), "root_stress": True}}


def _widths(result: fl.Result) -> NDArray[np.float64]:
    return np.ones(1) if result.slices is None else np.asarray(result.slices.width_mm)


class TooLongError(BaseException):  # no `except Exception` on the way stops it
    """Time limit exceeded."""


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Abandon solutions beyond a limit of CPU seconds: the core is interrupted as by Ctrl-C."""

    def give_up(*_: object) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


Errors = dict[str, float]


def compared(
    scene: dict[str, Any],
    truth: Truth | None = None,
    *,
    finer: tuple[int, int, int] | None = None,
) -> dict[str, Any]:
    """Estimated and true errors of a scene, and the share of the estimate in the run's CPU time."""
    truth = truth or finer_solution(scene, finer)
    result = fl.solve(fl.Scene.from_dict(with_root_stress(scene)))
    assert result.estimate is not None
    stages = {name: stage["cpu_s"] for name, stage in result.cost["stages"].items()}
    plane = not is_spatial(scene)
    resolved = with_resolved_peaks(result, fl.Scene.from_dict(scene)) if plane else result
    return {
        "true": true_errors(resolved, truth) | _of_roots(result, truth),
        "estimated": {name: result.estimate.get(name, np.nan) for name in QUANTITIES},
        "by_source": result.estimate["by_source"],
        "price": stages["estimate"] / sum(stages.values()),
    }


def true_errors(result: fl.Result, finer: fl.Result | Truth) -> Errors:
    """Errors of all quantities by a finer solution at more positions."""
    at = np.abs(finer.position_rad - result.position_rad[:, None]).argmin(axis=1)
    rotation, true = result.rotation_rad, finer.rotation_rad
    sites = np.union1d(result.sites, finer.sites)

    def placed(one: fl.Result | Truth, values: np.ndarray) -> np.ndarray:
        wide = np.zeros((len(values), sites.size, *values.shape[2:]))
        wide[:, np.searchsorted(sites, one.sites)] = values
        return wide

    share = placed(result, result.load_share) - placed(finer, finer.load_share[at])
    peak = placed(result, result.peak_pressure_MPa)
    true_peak = placed(finer, finer.peak_pressure_MPa[at])
    corner = placed(result, result.corner_contact) + placed(finer, finer.corner_contact[at])
    smooth = (corner == 0) & (peak > 0)  # off sharp corners in both
    largest, true_largest = (each[smooth].max(initial=0.0) for each in (peak, true_peak))
    one = overall_values(result)
    two = finer.overall if isinstance(finer, Truth) else overall_values(finer)
    parts = np.abs(np.divide(one, two, out=np.ones_like(one), where=two != 0) - 1.0)
    return {
        "transmission_error": float(np.abs(rotation - true[at]).max() / np.abs(true).max()),
        "load_share": float(np.abs(share).max()),
        "peak_pressure": float(
            np.abs(peak - true_peak)[smooth].max(initial=0.0) / true_peak[smooth].max(initial=1.0)
        ),
        "largest_pressure": float(abs(largest / true_largest - 1)) if true_largest > 0 else 0.0,
        **dict(zip((*OVERALL, *OF_PERIOD), parts.tolist(), strict=False)),
        **(_of_slices(result, finer, at, placed) if result.slices is not None else {}),
    }


def _of_roots(result: fl.Result, finer: Truth) -> Errors:
    """Error of the largest root tension of both bodies at the positions of the result."""
    at = np.abs(finer.position_rad - result.position_rad[:, None]).argmin(axis=1)
    one, two = root_tension(result).max(axis=1), finer.root_tension_MPa[:, at].max(axis=1)
    known = np.isfinite(one) & (two > 0)
    return {ROOT_STRESS: float(np.abs(one / two - 1)[known].max())} if known.any() else {}


def _of_slices(
    result: fl.Result,
    finer: Truth,
    at: NDArray[np.int64],
    placed: Callable[[fl.Result | Truth, np.ndarray], np.ndarray],
) -> Errors:
    """Error of line loads, on average over the slices."""
    width, fine = _widths(result), finer.slice_width_mm
    one, two = (np.append(0.0, np.cumsum(each)) for each in (width, fine))
    two *= one[-1] / two[-1]  # equal up to rounding
    sums = np.cumsum(finer.slice_line_load_N_per_mm[at] * fine, axis=2)
    sums = PchipInterpolator(two, np.pad(sums, ((0, 0), (0, 0), (1, 0))), axis=2)(one)
    true = placed(finer, np.diff(sums, axis=2) / width)
    change = placed(result, result.slice_line_load_N_per_mm) - true
    return {LINE_LOAD: float(np.abs(change).max() / true.max())}
