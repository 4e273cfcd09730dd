"""The conductor: from a scene to its results, stage by stage, with the clock running."""

from __future__ import annotations

from functools import partial
from time import perf_counter, process_time
from typing import TYPE_CHECKING

from flankload.assembly import BodyPair, build_bodies
from flankload.compliance import BodyCompliance, flank_compliance, no_compliance
from flankload.errors import SceneError
from flankload.estimate import estimate_errors
from flankload.given_compliance import given_compliance
from flankload.resolution import choose_resolution
from flankload.result import Result
from flankload.result.from_sweep import result_of
from flankload.sweep import sweep

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.bodies import Body
    from flankload.scene import Scene

    Progress = Callable[[str, int, int], None]

#: Bodies that stand by their files must nearly touch there, to this part of the pitch: what stands
#: further apart is another tooth, or another centre distance.
LARGEST_STANDING_GAP = 0.25


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
    torques = scene.torques_Nm
    total = 3 + len(torques) * (2 if scene.accuracy.estimate else 1)
    with clock.stage("bodies", 0, total):
        pair = build_bodies(scene)
        standing = _standing_gap(scene, pair)
    compliances = _compliances(scene, pair, clock, total)
    done = 3
    results = []
    for torque in torques:
        run = partial(
            sweep,
            (pair.body_1, pair.body_2),
            pairing=pair.pairing,
            position_rad=pair.position_rad,
            torque_Nmm=1000.0 * torque,
            face_width_mm=scene.pair.face_width_mm,
        )
        grid = pair.resolution.grid
        with clock.stage("sweep", done, total):
            found = run(compliances=compliances, grid=grid)
        done += 1
        estimate = None
        if scene.accuracy.estimate:
            with clock.stage("estimate", done, total):
                # without torque nothing is approximated
                estimate = estimate_errors(found, run, compliances, grid) if torque else None
            done += 1
        results.append(
            result_of(
                found,
                pair,
                compliances,
                name=scene.name,
                face_width_mm=scene.pair.face_width_mm,
                estimate=estimate.as_dict() if estimate is not None else None,
                stages=clock.stages,
                notes=standing,
            )
        )
    clock.finish(total)
    return tuple(results) if scene.has_torque_list else results[0]


def _compliances(
    scene: Scene, pair: BodyPair, clock: _Clock, total: int
) -> tuple[BodyCompliance, BodyCompliance]:
    """One finite-element job for each body that yields and does not bring its compliance along."""
    found = []
    elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)
    for z, body in enumerate((pair.body_1, pair.body_2)):
        if not elastic[z]:
            found.append(no_compliance(body))
            continue
        with clock.stage(f"compliance body {z + 1}", 1 + z, total):
            found.append(compliance_of(body, scene))
    return found[0], found[1]


def compliance_of(body: Body, scene: Scene) -> BodyCompliance:
    """Compliance of one body: from its elements, or as it brings it along.

    Parameters
    ----------
    body : Body
        That yields.
    scene : Scene
        Decides on plane and pressure modes.

    Returns
    -------
    BodyCompliance
    """
    asked, plane = scene.accuracy.modes, scene.accuracy.plane
    default = choose_resolution(scene).modes
    if body.given is not None:
        return given_compliance(body, modes=asked, default_modes=default, plane=plane)
    return flank_compliance(body, n_modes=asked or _modes_of(body, default), plane=plane)


def _standing_gap(scene: Scene, pair: BodyPair) -> tuple[str, ...]:
    """How far apart bodies stand whose files say where they stand; too far is an error."""
    if pair.body_1.flank_angle_known and pair.body_2.flank_angle_known:
        return ()
    unloaded = sweep(
        (pair.body_1, pair.body_2),
        compliances=(no_compliance(pair.body_1), no_compliance(pair.body_2)),
        pairing=pair.pairing,
        position_rad=pair.position_rad[:1],
        torque_Nmm=0.0,
        face_width_mm=scene.pair.face_width_mm,
        grid=pair.resolution.grid,
    )
    radius = pair.body_1.reference_radius_mm
    gap_mm = float(unloaded.rotation_rad[0]) * radius
    apart = "overlap by" if gap_mm < 0 else "stand apart by"
    if abs(gap_mm) > LARGEST_STANDING_GAP * pair.pairing.period_rad * radius:
        raise SceneError(
            file=scene.file,
            key="pair.center_distance_mm",
            expected="bodies whose flanks nearly touch (to a quarter pitch) as their files stand",
            found=f"{scene.pair.axes_apart_mm:g} mm, where they {apart} {abs(gap_mm):.3f} mm",
        )
    note = (
        f"as the files stand, the flanks {apart} {1000 * abs(gap_mm):.3g} um at the first "
        "position; rotation and transmission error count from there"
    )
    return (note,)


def _modes_of(body: Body, wanted: int) -> int:
    """Degree at most half the number of flank elements: more makes a coarse mesh worse."""
    if body.mesh is None:
        return 0
    return max(2, min(wanted, body.mesh.flank_elements // 2 + 1))
