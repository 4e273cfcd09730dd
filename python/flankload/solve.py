"""The conductor: from a scene to its results, stage by stage, with the clock running."""

from __future__ import annotations

from time import perf_counter, process_time
from typing import TYPE_CHECKING

from flankload.assembly import build_bodies
from flankload.compliance import BodyCompliance, flank_compliance
from flankload.estimate import estimate_errors
from flankload.result import Result
from flankload.result.from_sweep import result_of
from flankload.sweep import Sweep, sweep

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.bodies import Body
    from flankload.resolution import Grid
    from flankload.scene import Scene

    Progress = Callable[[str, int, int], None]


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
    compliances = []
    for z, body in enumerate(bodies):
        with clock.stage(f"compliance body {z + 1}", 1 + z, total):
            modes = scene.accuracy.modes or _modes_of(body, pair.resolution.modes)
            compliances.append(flank_compliance(body, n_modes=modes, plane=scene.accuracy.plane))
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
                estimate = estimate_errors(found, run, pair_of, pair.resolution.grid).as_dict()
            done += 1
        results.append(
            result_of(
                found,
                pair,
                pair_of,
                name=scene.name,
                face_width_mm=scene.pair.face_width_mm,
                estimate=estimate,
                stages=clock.stages,
            )
        )
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
