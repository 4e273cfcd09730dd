"""What a run will cost, stage by stage, before it runs.

Finite elements are priced by their number, calibrated by the coarse ones that the plan has solved;
the sweep by a few of its own states, at its own discretization. What can be counted before is.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.estimate import estimate_errors
from flankload.analysis.tangent import with_tangents
from flankload.bodies.body import WholeMesh
from flankload.cost import Account, held_bytes
from flankload.mechanisms.flank_pair.prediction import elements_estimated, predicted_work
from flankload.mechanisms.flank_pair.stages import grown_pair, sweep_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene

    Floats = NDArray[np.float64]
    Compliances = tuple[BodyCompliance, BodyCompliance]

#: Positions and torques that the sweep is tried at.
PROBE_POSITIONS, PROBE_TORQUES = 8, 2
#: A probe that is over so soon is made again: the shorter time counts.
SHORT_S = 0.01
#: Positions that adaptive ones end up with, over those they begin with.
ADAPTIVE_PART = 3.0
#: CPU seconds and bytes of finite elements, on some machine: what a coarse run takes in the same
#: formulas says how much faster or slower this one is. Measured on sectors with 74 to 3740
#: elements and on whole bodies with 112 to 10588.
STEPS = ("assembly", "factorisation", "solution", "ring")
ASSEMBLY_S, ELEMENT_S = 0.011, 6.5e-5
FACTOR_S, FACTOR_POWER = 3.0e-7, 1.3
SOLUTION_S = 1.0e-7
SMOOTHING_S = 8e-7
HARMONIC_S, HARMONIC_CUT_S = 4.0e-5, 2.0e-10
CUT_PART = 0.3
BYTES_OF_ROW, FACTOR_BYTES, FACTOR_BYTES_POWER = 390.0, 140.0, 1.15


def price_run(
    scene: Scene, pair: BodyPair, coarse: Compliances, coarse_pair: BodyPair, bodies_s: float
) -> dict[str, Account]:
    """What a run of a scene will cost.

    Parameters
    ----------
    scene : Scene
    pair : BodyPair
        Its bodies, as the run builds them.
    coarse, coarse_pair : two BodyCompliance, BodyPair
        The same, coarsely.
    bodies_s : float
        CPU seconds that building the bodies took.

    Returns
    -------
    dict of str to Account
        By the names of the stages of `result.cost`.
    """
    counted = predicted_work(scene, pair)
    stages = {"bodies": Account(cpu_s=bodies_s, bytes=held_bytes(pair))}
    stages |= price_compliances(counted, pair, coarse, coarse_pair)
    stages |= _price_sweeps(scene, pair, coarse)
    if scene.accuracy.estimate:
        stages["estimate"].cpu_s += _price_smoothing(counted, pair, coarse, coarse_pair)
    for stage, account in stages.items():
        account.counters |= counted.get(stage, {})
    return stages


def price_compliances(
    counted: Mapping[str, dict[str, int]],
    pair: BodyPair,
    coarse: Compliances,
    coarse_pair: BodyPair,
) -> dict[str, Account]:
    """What the compliances of a run will cost.

    Parameters
    ----------
    counted : mapping of str to dict
        From `predicted_work`.
    pair, coarse, coarse_pair
        As of `price_run`.

    Returns
    -------
    dict of str to Account
        A stage for each body that yields.
    """
    stages = {}
    for z, body in enumerate((pair.body_1, pair.body_2)):
        stage = f"compliance body {z + 1}"
        if stage not in counted:
            continue
        if body.mesh is None:
            stages[stage] = _price_given(coarse[z])
            continue
        small = (coarse_pair.body_1, coarse_pair.body_2)[z]
        stages[stage] = _price_elements(body, counted[stage], pair.fillets[z], small, coarse[z])
    return stages


# --- finite elements ------------------------------------------------------------------------------
def _price_elements(
    body: Body,
    counters: dict[str, int],
    fillets: RootFillets | None,
    small: Body,
    coarse: BodyCompliance,
) -> Account:
    """Price of the elements of a body, by what the formulas miss on its coarse ones."""
    account, told = elements_price(body, counters), elements_price(small, coarse.counters)
    account.cpu_s *= _slower(small, coarse)
    account.bytes += held_bytes(fillets.points) if fillets is not None else 0
    part = coarse.workspace_bytes / told.workspace_bytes
    account.workspace_bytes = round(part * account.workspace_bytes)
    return account


def _price_smoothing(
    counted: Mapping[str, dict[str, int]],
    pair: BodyPair,
    coarse: Compliances,
    coarse_pair: BodyPair,
) -> float:
    """CPU seconds that the estimate takes for what elements miss."""
    seconds = 0.0
    for z in elements_estimated(pair):
        counters = counted[f"compliance body {z + 1}"]
        columns = counters["unit_loads_normal"] + counters["unit_loads_tangential"]
        body, small = ((one.body_1, one.body_2)[z] for one in (pair, coarse_pair))
        assert body.mesh is not None
        n_elements = sum(len(cells) for _, cells in body.mesh.cells)
        seconds += SMOOTHING_S * n_elements * columns * _slower(small, coarse[z])
    return seconds


def _slower(small: Body, coarse: BodyCompliance) -> float:
    """Seconds on this machine over those by the formulas."""
    spent = sum(coarse.seconds.get(step, 0.0) for step in STEPS)
    return spent / elements_price(small, coarse.counters).cpu_s if spent > 0 else 1.0


def elements_price(body: Body, counters: Mapping[str, int]) -> Account:
    """Seconds and bytes of the elements of a body, by the formulas.

    Parameters
    ----------
    body : Body
    counters : mapping of str to int
        Of its stage.

    Returns
    -------
    Account
    """
    mesh, unknowns = body.mesh, unknowns_of(body)
    assert mesh is not None
    n_elements = sum(len(cells) for _, cells in mesh.cells)
    whole = isinstance(mesh, WholeMesh)
    flanks = len(mesh.flanks) if isinstance(mesh, WholeMesh) else 1
    blocks = flanks**2 if isinstance(mesh, WholeMesh) else mesh.teeth
    response = (counters["unit_loads_normal"] + counters.get("unit_loads_tangential", 0)) // flanks
    places, cuts = counters.get("stress_recoveries", 0), counters.get("cut_columns", 0)
    columns = counters["fe_solutions"] - cuts
    account = Account(
        cpu_s=ASSEMBLY_S
        + ELEMENT_S * n_elements
        + counters["fe_factorisations"] * FACTOR_S * unknowns**FACTOR_POWER
        + SOLUTION_S * unknowns * (columns + CUT_PART * cuts),
        bytes=8 * blocks * response * (response + (response + places if places else 0)),
        workspace_bytes=round(
            BYTES_OF_ROW * unknowns
            + FACTOR_BYTES * unknowns**FACTOR_BYTES_POWER
            + 16 * unknowns * columns / flanks
        ),
    )
    if not whole:
        assert not isinstance(mesh, WholeMesh)
        cut = len(mesh.left_nodes) + len(mesh.right_nodes)
        account.cpu_s += (mesh.teeth // 2 + 1) * (HARMONIC_S + HARMONIC_CUT_S * cut**3)
    return account


def unknowns_of(body: Body) -> int:
    """Degrees of freedom of a body's elements that are not held."""
    assert body.mesh is not None
    return 2 * (len(body.mesh.nodes) - len(body.mesh.fixed_nodes))


def _price_given(compliance: BodyCompliance) -> Account:
    """A body that brings its compliance along: reading it has been paid with the bodies."""
    return Account(cpu_s=compliance.seconds.get("wall", 1e-3), bytes=held_bytes(compliance))


# --- sweeps ---------------------------------------------------------------------------------------
def _price_sweeps(scene: Scene, pair: BodyPair, compliances: Compliances) -> dict[str, Account]:
    """Sweep, tangent and estimate from a few of their states, at the run's own discretization."""
    torques = [1000.0 * torque for torque in scene.torques_Nm]
    loaded = [torque for torque in torques if torque > 0]
    pair, compliances = grown_pair(pair, compliances)
    some = (loaded or torques)[:: max(1, -(-len(loaded) // PROBE_TORQUES))]
    probe = _Probe(scene, pair, compliances, some)
    stages = {"sweep": probe.tried(probe.states)}
    if not pair.effects.lumped_contact:
        stages["tangent"] = probe.tried(probe.tangents)
    if scene.accuracy.estimate:
        stages["estimate"] = probe.tried(probe.estimates)
    for name, account in stages.items():
        part = len(torques if name == "sweep" else loaded) / len(some)
        account.cpu_s *= part
        account.bytes = round(account.bytes * part)
        account.workspace_bytes = round(account.workspace_bytes * part)
        account.counters = {name: round(n * part) for name, n in account.counters.items()}
    return stages


class _Probe:
    """A run's sweeps at a few of its positions."""

    def __init__(
        self, scene: Scene, pair: BodyPair, compliances: Compliances, torques_Nmm: list[float]
    ) -> None:
        self._run = partial(sweep_of(scene, pair), compliances=compliances)
        self._again = partial(sweep_of(scene, pair), keep_pairs=False)
        self._pair, self._compliances = pair, compliances
        # the estimate sweeps with what elements miss, which takes as long where it is nothing
        one, two = (
            _nothing_missed(compliance) if z in elements_estimated(pair) else compliance
            for z, compliance in enumerate(compliances)
        )
        self._estimated = one, two
        self._torques = torques_Nmm
        positions = pair.position_rad
        few = np.linspace(0, positions.size - 1, PROBE_POSITIONS).round().astype(int)
        self._few = positions[np.unique(few)]
        self._count = positions.size * (ADAPTIVE_PART if pair.adaptive else 1.0)
        self._found: dict[int, tuple[Sweep, ...]] = {}

    def states(self, position_rad: Floats, account: Account) -> None:
        """The sweep itself."""
        grid = self._pair.discretization.grid
        self._found[position_rad.size] = found = self._run(
            position_rad=position_rad, grid=grid, torques_Nmm=self._torques, account=account
        )
        account.bytes = held_bytes(found)

    def tangents(self, position_rad: Floats, account: Account) -> None:
        """What `with_tangents` adds."""
        again = partial(
            self._again,
            position_rad=position_rad,
            grid=self._pair.discretization.grid,
            compliances=self._compliances,
            account=account,
        )
        with_tangents(self._found[position_rad.size], again)

    def estimates(self, position_rad: Floats, account: Account) -> None:
        """What `estimate_errors` adds."""
        loaded = tuple(part for part in self._found[position_rad.size] if part.torque_Nmm > 0)
        torques = [part.torque_Nmm for part in loaded]
        again = partial(
            self._again, position_rad=position_rad, torques_Nmm=torques, account=account
        )
        if loaded:
            run = lambda *, part, **other: again(**other)  # noqa: E731
            estimate_errors(
                loaded,
                run,
                self._estimated,
                self._pair.discretization.grid,
                lumped=self._pair.effects.lumped_contact,
                position_rad=position_rad,
            )

    def tried(self, work: Callable[[Floats, Account], None]) -> Account:
        """What work at all positions takes, from what it takes at a few of them and at one."""
        seconds, account = _shortest(partial(work, self._few))
        n, many = self._few.size, self._count
        call, each = 0.0, seconds / n
        if n > 1:
            one, _ = _shortest(partial(work, self._few[:1]))
            each = max(0.5 * each, (seconds - one) / (n - 1))
            call = max(0.0, seconds - n * each)
        pairs = max((int(part.n_pairs.max()) for part in self._found[n]), default=0)
        influence = 8 * pairs**2  # of one state at a time
        return Account(
            cpu_s=call + each * many,
            bytes=round(account.bytes * many / n),
            workspace_bytes=influence
            + round(max(0, account.workspace_bytes - influence) * many / n),
            counters={name: round(k * many / n) for name, k in account.counters.items()},
        )


def _nothing_missed(compliance: BodyCompliance) -> BodyCompliance:
    along = compliance.tangential
    p = compliance.smooth.shape[1]
    nothing = np.zeros((1, p, p + (0 if along is None else along.shape[2])))
    return replace(compliance, missed=nothing)


def _shortest(work: Callable[[Account], None]) -> tuple[float, Account]:
    """CPU seconds of work and its account; what is soon over is done again."""
    shortest = np.inf
    for _ in range(3):
        account, start = Account(), process_time()
        work(account)
        shortest = min(shortest, process_time() - start)
        if shortest > SHORT_S:
            break
    return shortest, account
