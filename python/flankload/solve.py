"""The conductor: from a scene to its results, stage by stage, with the clock running."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter, process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies import Body, build_body
from flankload.compliance import BodyCompliance, flank_compliance
from flankload.errors import FlankloadError, SceneError
from flankload.estimate import Estimate, estimate_errors
from flankload.pairing import Pairing, pair_bodies
from flankload.result import PairDrawing, PairTable, Result, make_result
from flankload.sweep import Grid, Sweep, sweep

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from flankload.scene import Scene

    Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Resolution:
    """The knobs of accuracy, as chosen by the scene's tolerance or named in it.

    Attributes
    ----------
    flank_element_parts : float
        Length of the flank elements in modules (parametric bodies).
    modes : int
        Pressure modes of a flank.
    grid : Grid
        Cells of the contact.
    """

    flank_element_parts: float
    modes: int
    grid: Grid


#: (tolerance, resolution), coarse to fine: the first whose tolerance is not above the wanted one.
#: Errors of the transmission error measured on the FZG type C pair, module 4.5: 0.07 % with
#: elements of 1 mm and 5 modes, 0.03 % with 0.5 mm and 6 modes; peak pressure 0.2 % with 10 strips.
RESOLUTIONS: tuple[tuple[float, Resolution], ...] = (
    (5e-3, Resolution(1.0 / 4.5, 5, Grid())),
    (1e-3, Resolution(0.5 / 4.5, 6, Grid(16.0, 48.0))),
    (0.0, Resolution(0.35 / 4.5, 6, Grid(24.0, 72.0))),
)


@dataclass(frozen=True)
class BodyPair:
    """Both bodies and how they stand to each other.

    Attributes
    ----------
    body_1, body_2 : Body
    pairing : Pairing
    resolution : Resolution
    position_rad : (P,) array
        Angles of body 1 from position zero.
    closed : bool
        The positions divide one period evenly.
    notes : tuple of str
        What a user must know of bodies and pair.
    """

    body_1: Body
    body_2: Body
    pairing: Pairing
    resolution: Resolution
    position_rad: NDArray[np.float64]
    closed: bool
    notes: tuple[str, ...]

    @property
    def turn_1(self) -> float:
        """Turn of body 1's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[0]

    @property
    def turn_2(self) -> float:
        """Turn of body 2's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[1]


class _Clock:
    """Seconds of each stage, and the progress that is told on the way."""

    def __init__(self, progress: Progress | None) -> None:
        self.stages: dict[str, dict[str, float]] = {}
        self._progress = progress

    def stage(self, name: str, done: int, total: int) -> _Stage:
        if self._progress is not None:
            self._progress(name, done, total)
        return _Stage(self.stages.setdefault(name, {"wall_s": 0.0, "cpu_s": 0.0}))

    def finish(self, total: int) -> None:
        if self._progress is not None:
            self._progress("done", total, total)


class _Stage:
    def __init__(self, account: dict[str, float]) -> None:
        self._account = account

    def __enter__(self) -> None:
        self._wall, self._cpu = perf_counter(), process_time()

    def __exit__(self, *_: object) -> None:
        self._account["wall_s"] += perf_counter() - self._wall
        self._account["cpu_s"] += process_time() - self._cpu


def choose_resolution(scene: Scene) -> Resolution:
    """Knobs for a scene: what it names, the rest from its tolerance."""
    accuracy = scene.accuracy
    chosen = next(knobs for bound, knobs in RESOLUTIONS if accuracy.tolerance >= bound)
    grid = chosen.grid
    return Resolution(
        flank_element_parts=chosen.flank_element_parts,
        modes=accuracy.modes or chosen.modes,
        grid=Grid(
            accuracy.strips_per_half_width or grid.strips_per_half_width,
            accuracy.corner_strips_per_half_width or grid.corner_strips_per_half_width,
            accuracy.zone_half_widths or grid.zone_half_widths,
        ),
    )


def build_bodies(scene: Scene) -> BodyPair:
    """Bodies of a scene and their pairing; no finite elements are solved.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    BodyPair

    Raises
    ------
    SceneError
        If a body cannot be made or the pair cannot mesh; names file, key, expected and found.
    """
    resolution = choose_resolution(scene)
    try:
        body_1, body_2 = (
            build_body(
                spec,
                key,
                folder=scene.folder,
                flank_element_mm=scene.accuracy.flank_element_mm,
                flank_element_parts=resolution.flank_element_parts,
            )
            for spec, key in ((scene.body_1, "body_1"), (scene.body_2, "body_2"))
        )
        # Position zero and the period need only the number of teeth.
        position_rad, closed = _positions(scene, 2 * np.pi / body_1.teeth)
        pairing = pair_bodies(
            body_1,
            body_2,
            center_distance_mm=scene.pair.center_distance_mm,
            position_rad=position_rad,
        )
    except SceneError as error:
        if error.file is not None or scene.file is None:
            raise
        raise error.with_file(scene.file) from None
    notes = (
        *(f"body_1: {note}" for note in body_1.notes),
        *(f"body_2: {note}" for note in body_2.notes),
        *pairing.warnings,
    )
    return BodyPair(body_1, body_2, pairing, resolution, position_rad, closed, notes)


def _positions(scene: Scene, period_rad: float) -> tuple[NDArray[np.float64], bool]:
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float)), False
    return period_rad * np.arange(wanted.count) / wanted.count, True


def solve(scene: Scene, progress: Progress | None = None) -> Result | tuple[Result, ...]:
    """Load distribution of a scene at all its positions.

    Parameters
    ----------
    scene : Scene
        From `read_scene` or `Scene.from_dict`.
    progress : callable, optional
        Called as progress(stage, done, total) when a stage begins, and at the end.

    Returns
    -------
    Result, or a tuple of Results where the scene has a list of torques

    Raises
    ------
    SceneError
        If the scene asks for something impossible.
    FlankloadError
        If a position has no answer.
    """
    clock = _Clock(progress)
    torques = _torques(scene)
    total = 3 + len(torques) * (2 if scene.accuracy.estimate else 1)
    with clock.stage("bodies", 0, total):
        pair = build_bodies(scene)
    bodies = (pair.body_1, pair.body_2)
    modes = [_modes_of(body, pair.resolution.modes) for body in bodies]
    compliances = []
    for z, body in enumerate(bodies):
        with clock.stage(f"compliance body {z + 1}", 1 + z, total):
            compliances.append(flank_compliance(body, n_modes=modes[z], plane=scene.accuracy.plane))
    pair_of = (compliances[0], compliances[1])
    done = 3
    results = []
    for torque in torques:

        def run(
            compliances: tuple[BodyCompliance, BodyCompliance] = pair_of,
            grid: Grid = pair.resolution.grid,
            torque: float = torque,
        ) -> Sweep:
            return sweep(
                bodies,
                compliances,
                pair.pairing,
                position_rad=pair.position_rad,
                torque_Nmm=1000.0 * torque,
                face_width_mm=scene.pair.face_width_mm,
                grid=grid,
            )

        with clock.stage("sweep", done, total):
            found = run()
        done += 1
        estimate = None
        if scene.accuracy.estimate:
            with clock.stage("estimate", done, total):
                estimate = estimate_errors(found, run, pair_of, pair.resolution.grid)
            done += 1
        results.append(_result(scene, pair, pair_of, found, estimate, torque, clock))
    clock.finish(total)
    return tuple(results) if scene.has_torque_list else results[0]


def _torques(scene: Scene) -> tuple[float, ...]:
    torque = scene.load.torque_Nm
    return tuple(torque) if scene.has_torque_list else (float(torque),)  # type: ignore[arg-type]


def _modes_of(body: Body, wanted: int) -> int:
    """Degree at most half the number of flank elements: more makes a coarse mesh worse."""
    if body.mesh is None:
        return 0
    return max(2, min(wanted, len(body.mesh.flank_edges) // 2 + 1))


def _result(
    scene: Scene,
    pair: BodyPair,
    compliances: tuple[BodyCompliance, BodyCompliance],
    found: Sweep,
    estimate: Estimate | None,
    torque: float,
    clock: _Clock,
) -> Result:
    carries = np.flatnonzero((found.site_force_N > 0).any(axis=0) | (pair.pairing.sites == 0))
    width = scene.pair.face_width_mm
    return make_result(
        name=scene.name,
        torque_Nm=torque,
        sites=pair.pairing.sites[carries],
        position_rad=pair.position_rad,
        rotation_rad=found.rotation_rad,
        reference_radius_mm=pair.body_1.reference_radius_mm,
        site_force_N=found.site_force_N[:, carries],
        peak_pressure_MPa=found.site_peak_N_per_mm[:, carries] / width,
        stiffness_tangent_Nm_per_rad=1e-3 / found.tangent_rad_per_Nmm,
        status=found.status,
        pair_tables=tuple(_pair_tables(pair.pairing, found, width)),
        corner_contact=found.site_corner[:, carries] > 0,
        period_rad=pair.pairing.period_rad,
        closed=pair.closed,
        face_width_mm=width,
        estimate=estimate.as_dict() if estimate is not None else None,
        cost=_cost(compliances, found, clock),
        warnings=(*pair.notes, *_warnings(pair, found)),
        drawing=_drawing(pair),
    )


def _pair_tables(pairing: Pairing, found: Sweep, width: float) -> Iterator[PairTable]:
    for k, n in enumerate(found.n_pairs):
        table = found.pair_table[k, :n].T
        yield PairTable(
            site=pairing.sites[found.pair_site[k, :n]],
            arc_length_1_mm=table[0],
            arc_length_2_mm=table[1],
            radius_mm=table[2],
            x_mm=table[3],
            y_mm=table[4],
            normal_x=table[5],
            normal_y=table[6],
            force_N=table[7],
            pressure_MPa=table[7] / (table[8] * width),
            gap_um=1000.0 * table[9],
            cell_mm=table[8],
        )


def _cost(
    compliances: tuple[BodyCompliance, BodyCompliance], found: Sweep, clock: _Clock
) -> dict[str, object]:
    pivots, columns, passes, refactorisations = found.counters.sum(axis=0).tolist()
    return {
        "fe_factorisations": sum(c.fe_factorisations for c in compliances),
        "unit_loads_normal": sum(c.unit_loads_normal for c in compliances),
        "unit_loads_tangential": 0,
        "influence_columns": columns,
        "pivots": pivots,
        "contact_passes": passes,
        "refactorisations": refactorisations,
        "fe_degrees_of_freedom": [c.degrees_of_freedom for c in compliances],
        "bytes": {
            "compliance": sum(c.bytes for c in compliances),
            "pairs": int(found.pair_table.nbytes + found.pair_site.nbytes),
        },
        "largest_backward_error": float(np.max(found.certificate[:, 0], initial=0.0)),
        "largest_condition": float(np.max(found.certificate[:, 1], initial=0.0)),
        "stages": {name: dict(account) for name, account in clock.stages.items()},
    }


def _warnings(pair: BodyPair, found: Sweep) -> Iterator[str]:
    corner = np.flatnonzero((found.site_corner > 0).any(axis=1))
    if corner.size:
        yield (
            f"at {corner.size} of {found.status.size} positions a flank works on a sharp tip "
            "corner: its peak pressure grows with the resolution and is no number to design by; a "
            "tip radius or chamfer cures it"
        )
    for z, body in enumerate((pair.body_1, pair.body_2)):
        low = body.mode_range_mm[0]
        places = found.pair_table[..., z]
        below = (places < low - 1e-9) & (found.pair_table[..., 7] > 0)
        if below.any():
            deepest = low - float(places[below].min())
            yield (
                f"contact reaches {deepest:.3f} mm below the active flank of body_{z + 1}: the "
                "smooth compliance of its lower end is taken there"
            )


def _drawing(pair: BodyPair) -> PairDrawing:
    turn_1, turn_2 = pair.pairing.turns(pair.position_rad)
    return PairDrawing(
        outline_1=pair.body_1.outline,
        outline_2=pair.body_2.outline,
        teeth_1=pair.body_1.teeth,
        teeth_2=pair.body_2.teeth,
        center_distance_mm=pair.pairing.center_distance_mm,
        angle_1=turn_1,
        angle_2=turn_2,
        bore_radius_1_mm=pair.body_1.bore_radius_mm,
        bore_radius_2_mm=pair.body_2.bore_radius_mm,
    )


__all__ = ["BodyPair", "FlankloadError", "build_bodies", "choose_resolution", "solve"]
