"""Assembly, finite elements and counted work of a timing belt on its pulley."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from flankload.base.rounding import round_up
from flankload.elasticity.sector_closure import unknowns_of
from flankload.mechanisms.belt.belt import Strip, build_pulley, build_strip
from flankload.mechanisms.belt.belt_mesh import FLANK_ELEMENTS, coarser
from flankload.mechanisms.belt.contact import state_under
from flankload.mechanisms.belt.estimate import estimate_belt
from flankload.mechanisms.belt.pulley_compliance import (
    PulleyResponse,
    on_elastic_pulley,
    solve_pulley,
)
from flankload.mechanisms.belt.pulley_mesh import PulleyMesh, mesh_pulley
from flankload.mechanisms.belt.row import BeltRow, StripResponse, condensation_work, phases
from flankload.mechanisms.parameters import Parameters, lengths, named, rounded
from flankload.mechanisms.scene_bodies import PAIR
from flankload.mechanisms.stage_clock import elements_stage
from flankload.mechanisms.wrapped import WrappedAssembly, WrappedStates, positions_of
from flankload.scene.steps import ELEMENTS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from flankload.cost import Account
    from flankload.mechanisms.belt.contact import BeltState, SpringRow
    from flankload.mechanisms.belt.row import PieceSize
    from flankload.mechanisms.parameters import Powers
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import Belt, Pulley, Scene

#: Least number of elements on a flank for a pressure that varies along it.
LEAST_ELEMENTS = 2
#: Bytes of a number.
BYTES = 8
#: Near the re-entrant corners of a belt's teeth errors decrease to 0.6 when lengths are halved.
POWERS: Mapping[str, Powers] = {"elements": {ELEMENTS: 0.75}}
#: Reason for slow convergence with finer steps.
CORNERS = (
    "; near the corners of teeth and lands, errors decrease more slowly than the element length"
)
#: Stages of the elements of pulley and belt.
PULLEY, STRIP = map(elements_stage, PAIR)


class PulleyMeshes:
    """Meshes of an elastic pulley, made on demand."""

    def __init__(self, keys: Pulley, strip: Strip, plane: str) -> None:
        self._keys, self._strip, self._plane = keys, strip, plane
        self._made: dict[int, PulleyMesh] = {}

    def of(self, elements: int) -> PulleyMesh:
        """The mesh with this number of elements per tooth flank; a SceneError if it is invalid."""
        if elements not in self._made:
            pulley = build_pulley(self._keys, self._strip, self._plane)
            self._made[elements] = mesh_pulley(pulley, elements)
        return self._made[elements]


@dataclass(frozen=True)
class BeltAssembly(WrappedAssembly):
    """A belt on its pulley, before finite elements are solved.

    Attributes
    ----------
    row : BeltRow
        Belt with the discretization of the run.
    coarse : BeltRow
        Belt with half as many elements, for the error estimate.
    pulley : PulleyMeshes
        Meshes of an elastic pulley.
    """

    row: BeltRow
    coarse: BeltRow
    pulley: PulleyMeshes

    @property
    def strip(self) -> Strip:
        """Dimensions of belt and pulley."""
        return self.row.strip

    @property
    def pitch_rad(self) -> float:
        """Angle between adjacent teeth."""
        return self.strip.pitch_rad

    @property
    def tried(self) -> list[int]:
        """Positions at which element errors are estimated: before and after a tooth engages."""
        places = phases(self.strip, self.position_rad)
        return sorted({int(places.argmax()), int(places.argmin())})


@dataclass(frozen=True)
class BeltStates(WrappedStates):
    """States of a belt, and a row of springs equivalent to it."""

    springs: SpringRow


def assemble(scene: Scene) -> BeltAssembly:
    """Belt, pulley and positions of a scene."""
    keys, belt = bodies_of(scene)
    strip = build_strip(keys, belt)
    elements, columns = flank_elements(scene, strip), land_columns_of(scene)
    halved, fewer = coarser(strip, elements)
    return BeltAssembly(
        *positions_of(scene, strip.pitch_rad),
        BeltRow(strip, elements, **columns),
        BeltRow(halved, fewer, **columns),
        PulleyMeshes(keys, strip, scene.accuracy.plane),
    )


def bodies_of(scene: Scene) -> tuple[Pulley, Belt]:
    """Keys of both bodies."""
    from flankload.scene import Belt, Pulley

    assert isinstance(scene.body_1, Pulley)
    assert isinstance(scene.body_2, Belt)
    return scene.body_1, scene.body_2


def flank_elements(scene: Scene, strip: Strip) -> int:
    """Number of elements on the flank of a tooth."""
    size = scene.accuracy.flank_element_mm
    if size is None or strip.tooth is None:
        return FLANK_ELEMENTS
    return max(LEAST_ELEMENTS, round_up(strip.tooth.height_mm / size))


def parameters_of_belt(scene: Scene, parts: Parts | None = None) -> Parameters:
    """Discretization parameters of a scene: the length of the elements on the flank of a tooth."""
    fixed, tooth = named(scene), build_strip(*bodies_of(scene)).tooth
    fixed.setdefault("positions", "a belt has positions.count equally spaced positions")
    length = None if tooth is None else tooth.height_mm / FLANK_ELEMENTS
    values, steps = {}, {}
    if length is None:
        fixed.setdefault(ELEMENTS, "rigid flanks have no elements")
    else:
        values[ELEMENTS] = scene.accuracy.flank_element_mm or rounded(length)
        if ELEMENTS not in fixed:
            steps[ELEMENTS] = lengths(scene, length)
    return Parameters(
        values,
        fixed,
        steps,
        POWERS,
        slow=CORNERS,
        always_slow=True,
        has_pressures=False,
        element_mm=length,
    )


def land_columns_of(scene: Scene) -> dict[str, bool]:
    """Land columns required by a scene; an elastic pulley requires those of lifting lands."""
    return {
        "sliding": scene.effects.land_friction != 0.0,
        "lifting": scene.effects.land_lift or not scene.body_1.rigid,
    }


def pulley_mesh(scene: Scene) -> PulleyMesh:
    """Mesh of an elastic pulley with the flank elements of the belt.

    Raises SceneError if no valid mesh can be made.
    """
    keys, belt = bodies_of(scene)
    strip = build_strip(keys, belt)
    return PulleyMeshes(keys, strip, scene.accuracy.plane).of(flank_elements(scene, strip))


def solved_pulley(scene: Scene, mesh: PulleyMesh, account: Account) -> PulleyResponse:
    """Response of an elastic pulley to forces on its grooves and lands."""
    return solve_pulley(mesh, sliding=scene.effects.land_friction != 0.0, account=account)


def response_at(
    row: BeltRow, known: PulleyResponse | None, angle_rad: float, account: Account | None = None
) -> StripResponse:
    """Response of the belt at a position, on a rigid pulley or on an elastic one."""
    held = row.at(angle_rad / row.strip.pitch_rad, account)
    return held if known is None else on_elastic_pulley(held, row.strip, known)


def error_estimates(
    scene: Scene,
    assembly: BeltAssembly,
    known: PulleyResponse | None,
    found: Sequence[Sequence[BeltState]],
    account: Account,
) -> list[Mapping[str, object] | None]:
    """Errors from elements twice as long at up to two positions, and from the spacing of positions.

    `found` has a list of states per torque, one per position. Returns one entry per torque in the
    form of the result, None without torque. The work is counted.
    """
    row, coarse, strip = assembly.row, assembly.coarse, assembly.strip
    pulley = None
    if known is not None:
        pulley = solved_pulley(scene, assembly.pulley.of(coarse.elements), account)
    # position; source, response to compare with (None: that of the run), and with longer elements
    tried: list[tuple[int, list[tuple[str, StripResponse | None, StripResponse]]]] = []
    for p in assembly.tried:
        at = partial(response_at, angle_rad=float(assembly.position_rad[p]), account=account)
        if known is None:
            tried.append((p, [("elements", None, at(coarse, None))]))
            continue
        # errors of belt and pulley elements may cancel
        body_1 = ("elements body 1", None, at(row, pulley))
        body_2 = ("elements body 2", None, at(coarse, known))
        tried.append((p, [body_1, body_2, ("elements body 2", at(row, None), at(coarse, None))]))
    places = None if assembly.pitches is None else phases(strip, assembly.position_rad)
    estimates: list[Mapping[str, object] | None] = []
    for torque, states in zip(scene.torques_Nmm, found, strict=True):
        if torque == 0.0:
            estimates.append(None)
            continue
        solve = partial(state_under, scene, strip, torque_Nmm=torque, account=account)
        compared = defaultdict(list)
        for p, responses in tried:
            for n, (source, own, other) in enumerate(responses):
                one = states[p] if own is None else solve(own)
                compared[n, source].append((one, solve(other)))
        by_source = [(source, pairs) for (_, source), pairs in compared.items()]
        estimates.append(estimate_belt(by_source, states, places))
    return estimates


def predicted_work(scene: Scene, assembly: BeltAssembly) -> dict[str, dict[str, int]]:
    """Exact counters of a run, by stages as `result.cost["stages"]` names them."""
    row, positions, elastic = assembly.row, assembly.position_rad, not scene.body_1.rigid
    loaded = sum(torque > 0.0 for torque in scene.torques_Nm)
    counted: dict[str, dict[str, int]] = {
        "bodies": {},
        STRIP: work_of_elements(scene, row.sizes(positions)),
        "sweep": work_of_states(row, positions.size * len(scene.torques_Nm)),
    }
    response, state = _bytes(scene, row, row.sizes(positions))
    counted[STRIP]["bytes"] = response
    flanks = BYTES * 8 * row.pairs
    counted["sweep"]["bytes"] = positions.size * (len(scene.torques_Nm) * state + flanks)
    if elastic:
        mesh = assembly.pulley.of(row.elements)
        counted[PULLEY] = work = work_of_pulley(scene, mesh)
        loads = work["unit_loads_normal"] + work["unit_loads_tangential"]
        work["bytes"] = BYTES * mesh.sector.teeth * loads**2
    if scene.accuracy.estimate and loaded:
        coarse, tried = assembly.coarse, positions[assembly.tried]
        states = tried.size * loaded
        work = Counter(work_of_elements(scene, coarse.sizes(tried)))
        work.update(work_of_states(coarse, states * (2 if elastic else 1)))
        if elastic:
            work.update(work_of_states(row, 2 * states))
            work.update(work_of_pulley(scene, assembly.pulley.of(coarse.elements)))
        counted["estimate"] = dict(work)
    return counted


def _bytes(scene: Scene, row: BeltRow, sizes: Sequence[PieceSize]) -> tuple[int, int]:
    """Bytes of the largest response, and of a state with contact at most pairs."""
    teeth, n, columns = row.strip.wrapped_teeth, row.pairs, land_columns_of(scene)
    inner = sum(size.land_functions for size in sizes if not size.held and not size.pulled)
    tight, slack = (
        [size.land_functions for size in sizes if getattr(size, end)] for end in ("held", "pulled")
    )
    # the longest tight end and the shortest slack end belong to the same position
    h = (teeth - 1) * inner + max(tight) + min(slack)
    response = n * n + h * n + 2 * n + 3 * h + 1
    response += sum(columns.values()) * (n * h + h * h + h)
    state = 3 * (n + columns["lifting"] * h) + 4 * teeth
    lines = 2 * teeth * (2 * row.elements + 1)
    return BYTES * (response + lines + 8 * n), BYTES * state


def work_of_elements(scene: Scene, sizes: Iterable[PieceSize]) -> dict[str, int]:
    """Factorisations, columns and solutions of pieces of a belt."""
    work: Counter[str] = Counter()
    for size in sizes:
        work.update(size.work(**land_columns_of(scene)))
    return dict(work)


def work_of_pulley(scene: Scene, mesh: PulleyMesh) -> dict[str, int]:
    """Factorisations, columns and solutions of an elastic pulley."""
    normal = 2 * mesh.flank.size + mesh.land.size
    along = mesh.land.size * land_columns_of(scene)["sliding"]
    unknowns = unknowns_of(mesh.sector)
    return condensation_work(unknowns, normal + along, normal, along)


def work_of_states(row: BeltRow, states: int) -> dict[str, int]:
    """Contact problems of a belt."""
    return {"states": states, "contact_passes": states, "influence_columns": states * row.pairs}
