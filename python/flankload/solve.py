"""The conductor: from a scene to its results, stage by stage, with the clock running."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from flankload.adaptive_positions import PositionErrors, Window, sweep_adaptively
from flankload.assembly import BodyPair, build_bodies
from flankload.compliance import BodyCompliance, no_compliance
from flankload.cost import Account, beside_plan, held_bytes
from flankload.errors import ContactError, SceneError
from flankload.estimate import MOST_SWEEPS, Estimate, estimate_errors
from flankload.period_error import ALIKE, OtherTeeth, teeth_until_alike
from flankload.prediction import predicted_work
from flankload.premises import (
    blame_load,
    broken_by_drive,
    broken_by_geometry,
    broken_by_load,
    held,
    marked,
)
from flankload.resolution import position_tolerance
from flankload.result import Result
from flankload.result.cost import cost_of
from flankload.result.from_sweep import result_of
from flankload.result.geometry import pair_geometry
from flankload.scene import MeshBody
from flankload.stages import compliance_of, grown_pair, sweep_of
from flankload.sweep import sweep
from flankload.tangent import with_tangents, with_unloaded
from flankload.tip_error import tip_error
from flankload.tolerance import solve_to_tolerance

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, MutableMapping

    import numpy as np
    from numpy.typing import NDArray

    from flankload.plan import Plan
    from flankload.plan.duration import Duration
    from flankload.resolution import Resolution
    from flankload.scene import Scene
    from flankload.sweep import Sweep

    Progress = Callable[[str, int, int], None]
    Kept = MutableMapping[int, tuple[BodyCompliance, Account]]

#: Bodies that stand by their files must nearly touch there, to this part of the pitch: what stands
#: further apart is another tooth, or another centre distance.
LARGEST_STANDING_GAP = 0.25
#: A transmission error that varies by less than this part of the flank's length is rounding.
LEAST_VARIATION = 1e-7


#: Steps of the progress: building the bodies, elements of each body, each sweep.
BODY_STEPS, COMPLIANCE_STEPS, SWEEP_STEPS = 1, 5, 20


class _Clock:
    """Accounts of the stages, and the progress that is told on the way."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.stages: dict[str, Account] = {}
        self._progress = progress
        self._total = total
        self._told = ("", 0)

    def stage(self, name: str, done: int) -> Account:
        self.tell(name, done)
        return self.stages.setdefault(name, Account())

    def tell(self, name: str, done: int) -> None:
        """Tell what is new."""
        if self._progress is not None and self._told != (name, done):
            self._told = (name, done)
            self._progress(name, done, self._total)

    def sweep_progress(
        self, name: str, before: int, number: int | None = None
    ) -> Callable[[int, int], None]:
        """Positions done in a sweep, as steps; of a round of unknown many half of what is left."""
        left, part = (1.0, 1.0) if number is None else (0.5**number, 0.5 ** (number + 1))

        def tell(done: int, total: int) -> None:
            steps = SWEEP_STEPS * (1.0 - left + part * done / max(1, total))
            self.tell(name, before + int(steps + 1e-9))

        return tell

    def move(self, seconds: Mapping[str, float], name: str, step: str) -> None:
        """Count a step of a stage to the stage that has its name."""
        if step in seconds:
            for account, sign in ((self.stages[name], -1), (self.stages[step], 1)):
                account.wall_s += sign * seconds[step]
                account.cpu_s += sign * seconds[step]

    def finish(self) -> None:
        self.tell("done", self._total)


def solve(
    scene: Scene,
    progress: Progress | None = None,
    *,
    plan: Plan | None = None,
    on_duration: Callable[[Duration], None] | None = None,
) -> Result | tuple[Result, ...]:
    """Load distribution of a scene at all its positions.

    Parameters
    ----------
    scene : Scene
        From `read_scene` or `Scene.from_dict`.
    progress : callable, optional
        Called as progress(stage, done, total) when a stage begins, on the way through its
        positions, and at the end; done grows up to total. What it raises ends the solution.
    plan : Plan, optional
        Of this scene: its predictions stand in `result.cost` beside what is spent. What can be
        counted before stands there in any case.
    on_duration : callable, optional
        Called once with how long the run will take, roughly, before its elements are solved.

    Returns
    -------
    Result, or a tuple of Results where the scene has a list of torques

    Raises
    ------
    SceneError
        If the scene asks for something impossible; `PremiseError` if it breaks a premise of the
        model.
    FlankloadError
        If a position has no answer, or the plan is one of another scene.
    """
    if not scene.steers:
        return solve_with(scene, {}, progress, plan=plan, on_duration=on_duration)
    plans, told = iter((plan,)), iter((on_duration,))  # of the first run

    def run(scene: Scene, kept: Kept, progress: Progress | None) -> Result | tuple[Result, ...]:
        plan, on_duration = next(plans, None), next(told, None)
        return solve_with(scene, kept, progress, plan=plan, on_duration=on_duration)

    return solve_to_tolerance(scene, run, progress)


def solve_with(
    scene: Scene,
    kept: Kept,
    progress: Progress | None = None,
    *,
    plan: Plan | None = None,
    resolution: Resolution | None = None,
    on_duration: Callable[[Duration], None] | None = None,
) -> Result | tuple[Result, ...]:
    """The same with compliances that another scene of the same bodies and knobs has left.

    Parameters
    ----------
    scene, progress, plan, on_duration
        As of `solve`.
    kept : mapping of 0 and 1 to BodyCompliance and Account
        Of body 1 and 2, with what they took, which is counted as if it were spent here. What is
        missing is computed and put in.
    resolution : Resolution, optional
        Knobs, where the scene itself names none; those of the scene if absent.

    Returns
    -------
    Result, or a tuple of Results
    """
    guessed = None if plan is None else plan.predicted["stages"]
    if scene.body_2.kind == "chain":
        from flankload.chain_drive import solve_chain

        drives = _approved(scene, solve_chain(scene, progress, guessed))
        return drives if scene.has_torque_list else drives[0]
    if scene.body_2.kind == "belt":
        from flankload.belt_drive import solve_belts

        if on_duration is not None:
            from flankload.plan.duration import duration_of_belt

            on_duration(duration_of_belt(scene))
        drives = _approved(scene, solve_belts(scene, progress, guessed))
        return drives if scene.has_torque_list else drives[0]
    fixed = BODY_STEPS + 2 * COMPLIANCE_STEPS
    sweeps = 2 + (MOST_SWEEPS if scene.accuracy.estimate else 0)
    clock = _Clock(progress, fixed + sweeps * SWEEP_STEPS)
    chosen: tuple[str, ...] = ()
    if scene.effects.choose is not None:
        with clock.stage("plan", 0):
            from flankload.plan.choice import choose_effects, said_of

            scene, choice = choose_effects(scene)
        chosen = (said_of(choice, scene.accuracy.tolerance),) if choice else ()
    with clock.stage("bodies", 0) as account:
        pair = build_bodies(scene, resolution)
        by_geometry = held(scene, tuple(broken_by_geometry(pair)))
        standing = _standing_gap(scene, pair, account)
        account.bytes += held_bytes(pair)
    predicted = beside_plan(predicted_work(scene, pair), guessed)
    if on_duration is not None:
        from flankload.plan.duration import duration_of

        on_duration(duration_of(scene, pair))
    compliances = _compliances(scene, pair, clock, kept)
    planned, pair = pair, _with_compliance_period(scene, pair, compliances)
    if pair.position_rad.size != planned.position_rad.size:
        # teeth that yield differently, of which nothing is known before elements are solved
        predicted = beside_plan(predicted_work(scene, pair))
    pair, compliances = grown_pair(pair, compliances)
    run = sweep_of(scene, pair)
    width = scene.pair.face_width_mm
    geometry = pair_geometry(pair, compliances)
    with clock.stage("sweep", fixed) as account:

        def run_round(position_rad: NDArray[np.float64], number: int) -> tuple[Sweep, ...]:
            return run(
                position_rad=position_rad,
                compliances=compliances,
                grid=pair.resolution.grid,
                torques_Nmm=[1000.0 * torque for torque in scene.torques_Nm],
                account=account,
                progress=clock.sweep_progress("sweep", fixed, number if pair.adaptive else None),
            )

        try:
            pair, found, errors, rounds = _all_positions(scene, pair, run_round)
        except ContactError as error:
            grid, at = pair.resolution.grid, pair.position_rad
            part = partial(run, compliances=compliances, grid=grid, position_rad=at)
            blame_load(scene, pair, geometry, error, lambda torque: part(torques_Nmm=[torque]))
            raise
        account.bytes += held_bytes(found)
    run = partial(run, position_rad=pair.position_rad)
    if not pair.effects.lumped_contact:
        # a lumped contact grows with the torque in the equations themselves
        with clock.stage("tangent", fixed + SWEEP_STEPS) as account:
            found = with_tangents(
                found,
                partial(
                    run,
                    compliances=compliances,
                    grid=pair.resolution.grid,
                    keep_pairs=False,
                    account=account,
                    progress=clock.sweep_progress("tangent", fixed + SWEEP_STEPS),
                ),
            )
    with Account() as aside:
        found = with_unloaded(
            found,
            partial(
                run,
                compliances=compliances,
                grid=pair.resolution.grid,
                keep_pairs=False,
                account=aside,
            ),
        )
    aside.counters.pop("states", None)  # those are positions under a torque
    geometry = pair_geometry(pair, compliances)  # at all its positions
    broken = [
        (*by_geometry, *held(scene, tuple(broken_by_load(scene, pair, geometry, part, t))))
        for t, part in enumerate(found)
    ]
    estimates: dict[int, Estimate] = {}
    if scene.accuracy.estimate:
        with clock.stage("estimate", fixed + 2 * SWEEP_STEPS) as account:
            estimates = _estimates(
                found, partial(run, account=account), pair, compliances, clock, width
            )
        for z, compliance in enumerate(compliances):
            account.bytes += held_bytes(compliance.missed)
            clock.move(compliance.seconds, f"compliance body {z + 1}", "estimate")
    clock.stages["result"] = aside
    with clock.stage("result", fixed + sweeps * SWEEP_STEPS) as account:
        unseen = _unseen(pair, compliances) if estimates else ()
        results = tuple(
            result_of(
                part,
                pair,
                compliances,
                name=scene.name,
                face_width_mm=width,
                estimate=estimates[t].as_dict(positions=errors[t]) if t in estimates else None,
                geometry=geometry,
                notes=(*chosen, *standing, *unseen, *_not_enough(scene, pair, errors[t])),
            )
            for t, part in enumerate(found)
        )
        account.bytes += held_bytes(results)
    results = tuple(
        replace(
            marked(result, outside),
            cost=cost_of(clock.stages, part, compliances, predicted=predicted, rounds=rounds),
        )
        for result, part, outside in zip(results, found, broken, strict=True)
    )
    clock.finish()
    return results if scene.has_torque_list else results[0]


def _approved(scene: Scene, drives: tuple[Result, ...]) -> tuple[Result, ...]:
    """Results of a chain or a belt, but for those that break a premise."""
    return tuple(
        marked(result, held(scene, tuple(broken_by_drive(scene, result, t))))
        for t, result in enumerate(drives)
    )


def _estimates(
    found: tuple[Sweep, ...],
    run: Callable[..., tuple[Sweep, ...]],
    pair: BodyPair,
    compliances: tuple[BodyCompliance, BodyCompliance],
    clock: _Clock,
    face_width_mm: float,
) -> dict[int, Estimate]:
    """Error estimates by number of the torque; without torque nothing is approximated."""
    loaded = [t for t, part in enumerate(found) if part.torque_Nmm > 0]
    if not loaded:
        return {}
    before = BODY_STEPS + 2 * COMPLIANCE_STEPS + 2 * SWEEP_STEPS

    def run_again(*, part: int, **other: object) -> tuple[Sweep, ...]:
        return run(
            **other,
            torques_Nmm=[found[t].torque_Nmm for t in loaded],
            keep_pairs=False,
            progress=clock.sweep_progress("estimate", before + part * SWEEP_STEPS),
        )

    parts = tuple(found[t] for t in loaded)
    window = None if pair.pitches is None else window_of(pair)
    estimated = estimate_errors(
        parts,
        run_again,
        compliances,
        pair.resolution.grid,
        lumped=pair.effects.lumped_contact,
        position_rad=pair.position_rad,
        window=None if pair.adaptive else window,
        unlike=None if window is None else OtherTeeth.of(pair, compliances, face_width_mm, window),
        tip=partial(
            tip_error,
            bodies=(pair.body_1, pair.body_2),
            compliances=compliances,
            pairing=pair.pairing,
            face_width_mm=face_width_mm,
        ),
    )
    return dict(zip(loaded, estimated, strict=True))


def _with_compliance_period(
    scene: Scene, pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]
) -> BodyPair:
    """The pair at positions for teeth that yield differently, which only compliances tell."""
    part = ALIKE * scene.accuracy.tolerance
    bodies = (pair.body_1, pair.body_2)
    one, two = (
        teeth_until_alike(compliance, body.teeth, part)
        for compliance, body in zip(compliances, bodies, strict=True)
    )
    if (one, two) == (1, 1):
        return pair
    return build_bodies(scene, pair.resolution, bodies=bodies, groups=(one, two))


def _all_positions(
    scene: Scene, pair: BodyPair, run: Callable[[NDArray[np.float64], int], tuple[Sweep, ...]]
) -> tuple[BodyPair, tuple[Sweep, ...], tuple[PositionErrors | None, ...], int]:
    """The pair at all its positions, what was found, what they leave in doubt, and the rounds."""
    if not pair.adaptive:
        return pair, run(pair.position_rad, 0), (None,) * len(scene.torques_Nm), 1
    window = window_of(pair)
    swept = sweep_adaptively(
        run,
        pair.position_rad,
        window,
        tolerance=position_tolerance(scene),
        most=scene.positions.most_per_pitch * window.pitches,
        least_rad=LEAST_VARIATION * pair.body_1.curve.length_mm / pair.body_1.reference_radius_mm,
    )
    return replace(pair, position_rad=swept.position_rad), swept.found, swept.errors, swept.rounds


def window_of(pair: BodyPair) -> Window:
    """What the positions run over."""
    assert pair.pitches is not None
    pairing = pair.pairing
    return Window(
        pitch_rad=pairing.pitch_rad,
        pitches=pair.pitches,
        closed=pair.closed,
        sites=pairing.sites,
        # the one flank of a cam stands beside itself
        whole_circle=pairing.whole_circle or pairing.motion is not None,
    )


def _unseen(pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]) -> tuple[str, ...]:
    """Bodies of whose elements the error estimate knows nothing."""
    bodies = (pair.body_1, pair.body_2)
    unknown = [
        f"body_{z + 1}"
        for z, (body, compliance) in enumerate(zip(bodies, compliances, strict=True))
        if body.given is not None and compliance.missed is None and compliance.nodes is None
    ]
    if not unknown:
        return ()
    note = (
        "the error estimate does not contain what the elements behind the compliance of "
        f"{' and '.join(unknown)} miss: its file does not tell"
    )
    return (note,)


def _not_enough(scene: Scene, pair: BodyPair, error: PositionErrors | None) -> tuple[str, ...]:
    """What adaptive positions leave in doubt beyond the tolerance."""
    tolerance = position_tolerance(scene)
    if error is None or error.largest <= tolerance:
        return ()
    note = (
        f"{pair.position_rad.size} positions are too few for a tolerance of {tolerance:g}: "
        f"harmonics are in doubt by {100 * error.harmonics:.2g} %, the peak to peak by "
        f"{100 * error.peak_to_peak:.2g} % (positions.max_count, positions.tolerance)"
    )
    return (note,)


def _compliances(
    scene: Scene, pair: BodyPair, clock: _Clock, kept: Kept
) -> tuple[BodyCompliance, BodyCompliance]:
    """One finite-element job for each body that yields and does not bring its compliance along."""
    found = []
    elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)
    for z, body in enumerate((pair.body_1, pair.body_2)):
        growth = pair.growth[z]
        if not elastic[z] and (growth is None or not growth.needs_elements):
            found.append(no_compliance(body, growth))
            continue
        stage = f"compliance body {z + 1}"
        if z in kept:
            compliance, account = kept[z]
            clock.stages[stage] = replace(account)
            found.append(compliance)
            continue
        with clock.stage(stage, BODY_STEPS + z * COMPLIANCE_STEPS) as account:
            compliance = compliance_of(
                body,
                scene,
                pair.resolution,
                fillets=pair.fillets[z],
                growth=growth,
                estimate=scene.accuracy.estimate and elastic[z],
            )
            account.count(**compliance.counters)
            # what the elements miss is the estimate's
            account.bytes += held_bytes(replace(compliance, missed=None))
            account.workspace_bytes += compliance.workspace_bytes
            found.append(compliance)
        kept[z] = (compliance, replace(account))
    return found[0], found[1]


def _standing_gap(scene: Scene, pair: BodyPair, account: Account) -> tuple[str, ...]:
    """How far apart bodies stand whose files say where they stand; too far is an error."""
    if pair.body_1.flank_angle_known and pair.body_2.flank_angle_known:
        return ()
    (unloaded,) = sweep(
        (pair.body_1, pair.body_2),
        compliances=(no_compliance(pair.body_1), no_compliance(pair.body_2)),
        pairing=pair.pairing,
        position_rad=pair.position_rad[:1],
        torques_Nmm=[0.0],
        face_width_mm=scene.pair.face_width_mm,
        grid=pair.resolution.grid,
        account=account,
    )
    radius = pair.body_1.reference_radius_mm
    gap_mm = float(unloaded.rotation_rad[0]) * radius
    apart = "overlap by" if gap_mm < 0 else "stand apart by"
    if abs(gap_mm) > LARGEST_STANDING_GAP * pair.pairing.pitch_rad * radius:
        _blame_flank(scene, pair, f"{apart} {abs(gap_mm):.3f} mm")
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


def _blame_flank(scene: Scene, pair: BodyPair, stand: str) -> None:
    """Refuse the flank of a mesh that faces the other way round than its mate's."""
    if pair.body_1.mirrored == pair.body_2.mirrored:
        return
    key, spec = ("body_1", scene.body_1) if pair.body_1.mirrored else ("body_2", scene.body_2)
    assert isinstance(spec, MeshBody)
    sets = spec.flank_sets
    name = "flank_set" if sets is None else "flank_sets"
    raise SceneError(
        file=scene.file,
        key=f"{key}.{name}",
        expected="the other flank of the tooth: one that faces counter-clockwise about the axis of "
        "its body, as that of the mate does",
        found=f"{(sets or (spec.flank_set,))[0]!r}, which faces clockwise: in their "
        f"mirror image the flanks {stand}",
    )
