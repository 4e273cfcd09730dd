"""Assembly, finite elements and states of a timing belt on its pulley."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_up
from flankload.cost import Account, held_bytes
from flankload.mechanisms.belt.belt import Strip, build_strip
from flankload.mechanisms.belt.belt_mesh import FLANK_ELEMENTS, coarser, mesh_strip
from flankload.mechanisms.belt.contact import BeltState, SpringRow, spring_row
from flankload.mechanisms.belt.estimate import estimate_belt
from flankload.mechanisms.belt.pulley import build_pulley
from flankload.mechanisms.belt.pulley_compliance import PulleyResponse, rest_on, solve_pulley
from flankload.mechanisms.belt.pulley_mesh import PulleyMesh, mesh_pulley
from flankload.mechanisms.belt.row import BeltRow, StripResponse
from flankload.mechanisms.belt.states import state_under
from flankload.mechanisms.belt.work import (
    Asked,
    phases,
    work_of_elements,
    work_of_pulley,
    work_of_states,
)
from flankload.meshes.report import quality_rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.belt.columns import Flanks
    from flankload.mechanisms.belt.estimate import Coarser
    from flankload.mechanisms.stage_clock import StageClock
    from flankload.scene import Scene

    Floats = NDArray[np.float64]
    BeltCompliances = tuple[BeltRow, PulleyResponse | None]

#: Least number of elements on a flank for a pressure that varies along it.
LEAST_ELEMENTS = 2


@dataclass(frozen=True)
class BeltAssembly:
    """A belt on its pulley, before finite elements are solved.

    Attributes
    ----------
    strip : Strip
    position_rad : (P,) array
        Angles of the pulley.
    pitches : int or None
        Pitches covered by the positions; None for single angles.
    """

    strip: Strip
    position_rad: Floats
    pitches: int | None


@dataclass(frozen=True)
class Standing:
    """Arrangement of a belt on its pulley at a position.

    Attributes
    ----------
    first_tooth, first_land : int
    flanks : Flanks
    degrees_of_freedom : int
    """

    first_tooth: int
    first_land: int
    flanks: Flanks
    degrees_of_freedom: int

    @classmethod
    def of(cls, response: StripResponse) -> Standing:
        """Extract the arrangement from a response, whose matrices can then be released."""
        return cls(
            response.first_tooth,
            response.first_land,
            response.flanks,
            response.degrees_of_freedom,
        )


@dataclass(frozen=True)
class BeltStates:
    """States of a belt.

    Attributes
    ----------
    found : tuple of list of BeltState
        For each torque, the state at each position.
    standings : list of Standing
        One entry per position.
    springs : SpringRow
        Row of springs equivalent to the belt.
    """

    found: tuple[list[BeltState], ...]
    standings: list[Standing]
    springs: SpringRow


def assemble(scene: Scene) -> BeltAssembly:
    """Belt, pulley and positions of a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    BeltAssembly
    """
    strip = strip_of(scene)
    return BeltAssembly(strip, *positions_of(scene, strip))


def compliances_of(scene: Scene, strip: Strip, clock: StageClock) -> BeltCompliances:
    """Solve the finite elements of the belt, and of an elastic pulley.

    Parameters
    ----------
    scene : Scene
    strip : Strip
    clock : StageClock

    Returns
    -------
    row : BeltRow
    pulley : PulleyResponse or None
        None for a rigid pulley.
    """
    pulley = None
    if not scene.body_1.rigid:
        with clock.stage("compliance body 1") as account:
            pulley = solved_pulley(scene, pulley_mesh(scene), account)
            account.bytes = held_bytes(pulley)
    with clock.stage("compliance body 2") as account:
        return _row(scene, strip, flank_elements(scene, strip), account), pulley


def states_of(
    scene: Scene, assembly: BeltAssembly, compliances: BeltCompliances, clock: StageClock
) -> BeltStates:
    """States at all positions under all torques.

    Parameters
    ----------
    scene : Scene
    assembly : BeltAssembly
    compliances : (BeltRow, PulleyResponse or None)
    clock : StageClock

    Returns
    -------
    BeltStates

    Raises
    ------
    NoContactState
        If the belt has no state under a torque.
    """
    strip, torques = assembly.strip, scene.torques_Nm
    standings: list[Standing] = []
    found: tuple[list[BeltState], ...] = tuple([] for _ in torques)
    springs = None
    progress = clock.sweep_progress("sweep")
    for p, angle in enumerate(assembly.position_rad):
        progress(p, assembly.position_rad.size)
        with clock.account("compliance body 2") as account:
            response = response_at(strip, *compliances, float(angle))
            springs = springs or spring_row(strip, response)
            account.bytes = max(account.bytes, held_bytes(response))
        with clock.account("sweep") as account:
            for torque, states in zip(torques, found, strict=True):
                states.append(state_under(scene, strip, response, torque, account))
            standings.append(Standing.of(response))
    assert springs is not None
    clock.account("sweep").bytes = held_bytes(found, standings)
    return BeltStates(found, standings, springs)


def positions_of(scene: Scene, strip: Strip) -> tuple[Floats, int | None]:
    """Angles of the pulley, and the number of pitches they cover; None for single angles.

    Parameters
    ----------
    scene : Scene
    strip : Strip

    Returns
    -------
    position_rad : (P,) array
    pitches : int or None
    """
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float)), None
    pitches = 1 if wanted.pitches == "hunting" else int(wanted.pitches)
    return strip.pitch_rad * np.arange(wanted.count * pitches) / wanted.count, pitches


def strip_of(scene: Scene) -> Strip:
    """Belt and pulley of a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Strip
    """
    from flankload.scene import Belt, Pulley

    assert isinstance(scene.body_1, Pulley)
    assert isinstance(scene.body_2, Belt)
    return build_strip(scene.body_1, scene.body_2)


def flank_elements(scene: Scene, strip: Strip) -> int:
    """Number of elements on the flank of a tooth.

    Parameters
    ----------
    scene : Scene
    strip : Strip

    Returns
    -------
    int
    """
    size = scene.accuracy.flank_element_mm
    if size is None or strip.tooth is None:
        return FLANK_ELEMENTS
    return max(LEAST_ELEMENTS, round_up(strip.tooth.height_mm / size))


def default_element_mm(scene: Scene) -> float | None:
    """Default length of the elements on the flank of a tooth; None without teeth.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    float or None
    """
    strip = strip_of(scene)
    return None if strip.tooth is None else strip.tooth.height_mm / FLANK_ELEMENTS


def pulley_mesh(scene: Scene, elements: int | None = None) -> PulleyMesh:
    """Mesh of an elastic pulley.

    Parameters
    ----------
    scene : Scene
    elements : int, optional
        On the part that a belt's tooth touches; by default as many as on the tooth.

    Returns
    -------
    PulleyMesh

    Raises
    ------
    SceneError
        If no valid mesh can be made.
    """
    from flankload.scene import Pulley

    assert isinstance(scene.body_1, Pulley)
    strip = strip_of(scene)
    pulley = build_pulley(scene.body_1, strip, scene.accuracy.plane)
    return mesh_pulley(pulley, elements or flank_elements(scene, strip))


def _rows_of_pulley(scene: Scene) -> list[tuple[str, str]]:
    if scene.body_1.rigid:
        return [("mesh", "none: rigid")]
    mesh = pulley_mesh(scene)
    pulley, sector = mesh.pulley, mesh.sector
    return [
        ("bore diameter", f"{2 * pulley.bore_radius_mm:.4f} mm, fixed"),
        ("depth of the grooves", f"{pulley.depth_mm:.4f} mm"),
        ("Young's modulus", f"{pulley.material.young_modulus_MPa:g} MPa, plane {pulley.plane}"),
        ("mesh of a sector", f"{len(sector.nodes)} nodes, {len(sector.cells[0][1])} quad9"),
        *quality_rows(sector.nodes, sector.cells),
    ]


def describe_belt(scene: Scene) -> dict[str, list[tuple[str, str]]]:
    """Rows of `flankload check` for a pulley and its belt.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    dict of str to list of (str, str)
        Name and value of each row, by title.
    """
    strip = strip_of(scene)
    mesh = mesh_strip(strip, flank_elements(scene, strip))
    slack = scene.load.slack_tension_N or 0.0
    tight = np.array(scene.torques_Nmm) / strip.pitch_radius_mm + slack
    mean = 0.5 * (tight.max() + slack)
    said = f"{strip.prestress_N_per_mm * strip.width_mm:g} N (half of both tensions: {mean:.4g} N)"
    clearance = 1000.0 * strip.clearance_rad * strip.pitch_radius_mm
    effects = scene.effects
    return {
        "body_1: pulley": [
            ("teeth", f"{strip.pulley_teeth}"),
            ("pitch diameter", f"{2 * strip.pitch_radius_mm:.4f} mm"),
            ("outer diameter", f"{2 * strip.land_radius_mm:.4f} mm"),
            *_rows_of_pulley(scene),
        ],
        "body_2: belt": [
            ("teeth on the pulley", f"{strip.wrapped_teeth}"),
            ("wrap", f"{degrees(strip.wrapped_teeth * strip.pitch_rad):g} deg"),
            ("pitch difference", f"{1000 * strip.pitch_difference_mm:g} um"),
            ("clearance of flanks", f"{clearance:.4g} um"),
            ("prestress", said),
            ("elements", f"{len(mesh.cells[0][1])}"),
        ],
        "load": [
            ("slack tension", f"{slack:g} N"),
            ("tight tension", ", ".join(f"{value:.4g} N" for value in tight)),
        ],
        "effects": [
            ("friction on the lands", f"{effects.land_friction:g}"),
            ("lands may lift", "yes" if effects.land_lift else "no"),
        ],
    }


def _row(scene: Scene, strip: Strip, elements: int, account: Account) -> BeltRow:
    return BeltRow(
        strip,
        elements,
        sliding=scene.effects.land_friction != 0.0,
        lifting=asked_of(scene).lifting,
        account=account,
    )


def asked_of(scene: Scene) -> Asked:
    """Land columns that a scene needs; an elastic pulley needs those of lifting lands."""
    return Asked(
        scene.effects.land_friction != 0.0, scene.effects.land_lift or not scene.body_1.rigid
    )


def solved_pulley(scene: Scene, mesh: PulleyMesh, account: Account) -> PulleyResponse:
    """Response of an elastic pulley to forces on its grooves and lands."""
    return solve_pulley(mesh, sliding=scene.effects.land_friction != 0.0, account=account)


def response_at(
    strip: Strip, row: BeltRow, known: PulleyResponse | None, angle_rad: float
) -> StripResponse:
    """Response of the belt at a position, on a rigid pulley or on an elastic one."""
    held = row.at(angle_rad / strip.pitch_rad)
    return held if known is None else rest_on(held, strip, known)


def error_estimates(
    scene: Scene,
    assembly: BeltAssembly,
    compliances: BeltCompliances,
    found: tuple[list[BeltState], ...],
    account: Account,
) -> list[dict[str, object] | None]:
    """Errors from elements twice as long at up to two positions, and from the spacing of positions.

    Parameters
    ----------
    scene : Scene
    assembly : BeltAssembly
    compliances : (BeltRow, PulleyResponse or None)
    found : tuple of list of BeltState
        For each torque, the state at each position.
    account : Account
        Account in which the work is counted.

    Returns
    -------
    list of dict or None
        One entry per torque, as the result shows it; None without torque.
    """
    if not any(scene.torques_Nm):
        return [None] * len(found)
    strip, (row, known) = assembly.strip, compliances
    halved, elements = coarser(strip, flank_elements(scene, strip))
    coarse = _row(scene, halved, elements, account)
    pulley = None if known is None else solved_pulley(scene, pulley_mesh(scene, elements), account)
    tried: list[tuple[int, list[Coarser]]] = []
    for p in tried_positions(strip, assembly.position_rad):
        at = partial(response_at, strip, angle_rad=float(assembly.position_rad[p]))
        if known is None:
            tried.append((p, [("elements", None, at(coarse, None))]))
            continue
        # errors of belt and pulley elements may cancel
        on_both: list[Coarser] = [
            ("elements body 1", None, at(row, pulley)),
            ("elements body 2", None, at(coarse, known)),
            ("elements body 2", at(row, None), at(coarse, None)),
        ]
        tried.append((p, on_both))
    places = None if assembly.pitches is None else phases(strip, assembly.position_rad)
    estimates: list[dict[str, object] | None] = []
    for torque, states in zip(scene.torques_Nm, found, strict=True):
        if torque == 0.0:
            estimates.append(None)
            continue
        solve = partial(state_under, scene, strip, torque_Nm=torque, account=account)
        here = [(states[p], by) for p, by in tried]
        estimates.append(estimate_belt(here, states, places, solve))
    return estimates


def predicted_work(scene: Scene, strip: Strip, position_rad: Floats) -> dict[str, dict[str, int]]:
    """Count the work of a run exactly.

    Parameters
    ----------
    scene : Scene
    strip : Strip
    position_rad : (P,) array

    Returns
    -------
    dict of str to dict of str to int
        By stages, as `result.cost["stages"]` names them, then by counters.
    """
    elements, asked = flank_elements(scene, strip), asked_of(scene)
    yields = not scene.body_1.rigid
    torques = [torque for torque in scene.torques_Nm if torque > 0.0]
    counted: dict[str, dict[str, int]] = {
        "bodies": {},
        "compliance body 2": work_of_elements(strip, elements, position_rad, asked),
        "sweep": work_of_states(strip, elements, position_rad.size * len(scene.torques_Nm)),
    }
    if yields:
        counted["compliance body 1"] = work_of_pulley(pulley_mesh(scene), asked)
    if scene.accuracy.estimate and torques:
        halved, coarse = coarser(strip, elements)
        tried = position_rad[tried_positions(strip, position_rad)]
        states = tried.size * len(torques)
        work = Counter(work_of_elements(halved, coarse, tried, asked))
        work.update(work_of_states(strip, coarse, states * (2 if yields else 1)))
        if yields:
            work.update(work_of_states(strip, elements, 2 * states))
            work.update(work_of_pulley(pulley_mesh(scene, coarse), asked))
        counted["estimate"] = dict(work)
    return counted


def tried_positions(strip: Strip, position_rad: Floats) -> list[int]:
    """Positions at which element errors are estimated: before and after a tooth engages.

    Parameters
    ----------
    strip : Strip
    position_rad : (P,) array

    Returns
    -------
    list of int
    """
    places = phases(strip, position_rad)
    return sorted({int(places.argmax()), int(places.argmin())})
