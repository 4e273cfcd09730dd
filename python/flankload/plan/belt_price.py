"""What a run of a timing belt will cost: laws of pieces, rows and contact problems.

Constants are CPU seconds and bytes on some machine; what coarse pieces take beside the same laws
says how much faster or slower this one is. Measured on belts of 5 to 22 teeth with 2 to 24 elements
on a flank, pieces of 300 to 37000 unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.cost import Account
from flankload.mechanisms.belt.belt_mesh import STRAND, coarser, mesh_strip
from flankload.mechanisms.belt.drive import (
    asked_of,
    flank_elements,
    predicted_work,
    pulley_mesh,
    tried_positions,
)
from flankload.mechanisms.belt.work import Asked, PieceWork, pieces_of, work_of_pulley

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from flankload.mechanisms.belt.belt import Strip
    from flankload.scene import Scene

    Floats = NDArray[np.float64]

#: A piece: mesh and assembly, factors, solutions of columns and of cuts.
PIECE_S, UNKNOWN_S, FACTOR_S, FACTOR_POWER = 0.018, 5.3e-6, 6.6e-7, 1.3
SOLUTION_S, CUT_PART = 6.7e-8, 0.3
FACTOR_BYTES, FACTOR_BYTES_POWER, FACTOR_AGAIN = 150.0, 1.15, 0.8
#: A ring of sectors, for each harmonic.
HARMONIC_S, HARMONIC_CUT_S = 4.0e-5, 1.0e-9
#: A row: an interface for each of its unknowns, and multiplications.
INTERFACE_S, PRODUCT_S = 5.3e-6, 2.1e-10
#: A belt at a position, for each number that changes.
STANDING_S, NUMBER_S = 1.0e-4, 1.9e-9
#: A contact problem, and what it takes more with lands that rub, or that lift.
STATE_S, STATE_NUMBER_S = 4.0e-4, 1.2e-9
RUBBING_NUMBER_S, RUBBING_CUBE_S = 2.5e-8, 8.0e-11
LIFTING_NUMBER_S = 1.6e-8
#: Tables into a strip.
BODIES_S = 1.0e-4
BYTES = 8


@dataclass(frozen=True)
class BeltSizes:
    """How large a belt's arrays are; of its largest position.

    Attributes
    ----------
    teeth, elements : int
        Of the wrap, and on a flank.
    pairs, hats : int
        Of the whole wrap.
    cell, ends : PieceWork or None, list of PieceWork
    closed : int
        Different rows that are closed.
    """

    teeth: int
    elements: int
    pairs: int
    hats: int
    cell: PieceWork | None
    ends: list[PieceWork]
    closed: int


def sizes_of(strip: Strip, elements: int, position_rad: Floats) -> BeltSizes:
    """How large a belt's arrays are.

    Parameters
    ----------
    strip : Strip
    elements : int
        On a flank.
    position_rad : (P,) array

    Returns
    -------
    BeltSizes
    """
    pieces = pieces_of(strip, elements, position_rad)
    cell = next((piece for piece in pieces if not piece.held and not piece.pulled), None)
    tight, slack = ([p for p in pieces if p.held], [p for p in pieces if p.pulled])
    inner = strip.wrapped_teeth - 1
    return BeltSizes(
        teeth=strip.wrapped_teeth,
        elements=elements,
        pairs=strip.wrapped_teeth * (elements + 1),
        hats=(inner * cell.hats if cell is not None else 0)
        + max(piece.hats for piece in tight)
        + min(piece.hats for piece in slack),
        cell=cell,
        ends=tight + slack,
        closed=max(len(tight), len(slack)),
    )


def price_belt(
    scene: Scene, strip: Strip, position_rad: Floats, slower: Mapping[str, float]
) -> dict[str, Account]:
    """What a run of a belt will cost.

    Parameters
    ----------
    scene : Scene
    strip : Strip
    position_rad : (P,) array
    slower : mapping of str to float
        Seconds of this machine over those of the laws, for "compliance body 2" and "sweep".

    Returns
    -------
    dict of str to Account
        By the names of the stages of `result.cost`.
    """
    asked = asked_of(scene)
    elements, positions = flank_elements(scene, strip), position_rad.size
    sizes = sizes_of(strip, elements, position_rad)
    states = positions * len(scene.torques_Nm)
    body, sweep = "compliance body 2", "sweep"
    stages = {
        "bodies": Account(cpu_s=BODIES_S, bytes=position_rad.nbytes),
        body: Account(
            cpu_s=slower[body] * seconds_of_elements(strip, sizes, positions, asked),
            bytes=response_bytes(sizes, asked),
            workspace_bytes=workspace(strip, sizes, asked),
        ),
        sweep: Account(
            cpu_s=slower[sweep] * states * seconds_of_state(sizes, asked),
            bytes=states * state_bytes(sizes, asked) + positions * flank_bytes(sizes),
        ),
    }
    yields = not scene.body_1.rigid
    if yields:
        stages["compliance body 1"] = price_pulley(scene, elements, slower["compliance body 1"])
    loaded = sum(torque > 0.0 for torque in scene.torques_Nm)
    if scene.accuracy.estimate and loaded:
        tried = position_rad[tried_positions(strip, position_rad)]
        halved, half_elements = coarser(strip, elements)
        coarse = sizes_of(halved, half_elements, tried)
        stages["estimate"] = Account(
            cpu_s=slower[body] * seconds_of_elements(halved, coarse, tried.size, asked)
            + slower[sweep] * tried.size * loaded * seconds_of_state(coarse, asked),
            workspace_bytes=workspace(halved, coarse, asked),
        )
        if yields:
            half = price_pulley(scene, coarse.elements, slower["compliance body 1"])
            each = slower[sweep] * tried.size * loaded
            again = 2 * seconds_of_state(sizes, asked) + seconds_of_state(coarse, asked)
            stages["estimate"].cpu_s += half.cpu_s + each * again
            stages["estimate"].workspace_bytes += half.workspace_bytes
    for stage, counted in predicted_work(scene, strip, position_rad).items():
        stages[stage].counters |= counted
    return stages


def price_pulley(scene: Scene, elements: int, slower: float) -> Account:
    """What the elements of a pulley that yields will cost.

    Parameters
    ----------
    scene : Scene
    elements : int
        On what a tooth touches.
    slower : float
        Seconds of this machine over those of the law.

    Returns
    -------
    Account
    """
    mesh, asked = pulley_mesh(scene, elements), asked_of(scene)
    counted = work_of_pulley(mesh, asked)
    unknowns = 2 * len(mesh.sector.nodes)
    loads = counted["unit_loads_normal"] + counted["unit_loads_tangential"]
    faces = mesh.sector.left_nodes.size + mesh.sector.right_nodes.size
    harmonics = mesh.sector.teeth // 2 + 1
    seconds = PIECE_S + UNKNOWN_S * unknowns
    seconds += counted["fe_factorisations"] * FACTOR_S * unknowns**FACTOR_POWER
    seconds += SOLUTION_S * unknowns * counted["fe_solutions"]
    seconds += harmonics * (HARMONIC_S + HARMONIC_CUT_S * faces**2 * (faces + loads))
    return Account(
        cpu_s=slower * seconds,
        bytes=BYTES * mesh.sector.teeth * loads**2,
        workspace_bytes=round(
            counted["fe_factorisations"] * FACTOR_BYTES * unknowns**FACTOR_BYTES_POWER
            + 2 * BYTES * unknowns * loads
        ),
    )


def seconds_of_elements(strip: Strip, sizes: BeltSizes, positions: int, asked: Asked) -> float:
    """CPU seconds of all pieces, of the rows that they make, and of their places at positions.

    Parameters
    ----------
    strip : Strip
    sizes : BeltSizes
    positions : int
    asked : Asked

    Returns
    -------
    float
    """
    seconds = 0.0
    for piece, unknowns in _unknowns(strip, sizes):
        columns = piece.columns(asked) + CUT_PART * piece.kept
        seconds += PIECE_S + UNKNOWN_S * unknowns + FACTOR_S * unknowns**FACTOR_POWER
        seconds += SOLUTION_S * unknowns * columns
    more = sizes.hats * (asked.rubbing + asked.lifting)
    loads, answers = sizes.pairs + 1 + more, sizes.pairs + sizes.hats + 1
    if sizes.cell is not None:
        face = sizes.cell.kept // 2
        own = sizes.cell.columns(asked)
        products = (sizes.teeth - 1) * loads * face**2 + answers * loads * face
        products += (sizes.teeth - 1) * loads * face * own
        seconds += sizes.closed * (INTERFACE_S * (sizes.teeth - 1) * face + PRODUCT_S * products)
    numbers = (sizes.pairs + more) * (sizes.pairs + sizes.hats)
    return seconds + positions * (STANDING_S + NUMBER_S * numbers)


def seconds_of_state(sizes: BeltSizes, asked: Asked) -> float:
    """CPU seconds of a contact problem.

    Parameters
    ----------
    sizes : BeltSizes
    asked : Asked

    Returns
    -------
    float
    """
    pairs, hats = sizes.pairs, sizes.hats
    seconds = STATE_S + STATE_NUMBER_S * (pairs + hats) ** 2
    if asked.rubbing:
        seconds += RUBBING_NUMBER_S * hats**2 + RUBBING_CUBE_S * hats**3
    if asked.lifting:
        seconds += LIFTING_NUMBER_S * (pairs + hats) ** 2
    return seconds


def response_bytes(sizes: BeltSizes, asked: Asked) -> int:
    """Of a belt's response at a position.

    Parameters
    ----------
    sizes : BeltSizes
    asked : Asked

    Returns
    -------
    int
    """
    n, h = sizes.pairs, sizes.hats
    numbers = n * n + h * n + 2 * n + 3 * h
    numbers += (asked.rubbing + asked.lifting) * (n * h + h * h + h)
    lines = 2 * sizes.teeth * (2 * sizes.elements + 1)
    return BYTES * (numbers + lines) + flank_bytes(sizes)


def flank_bytes(sizes: BeltSizes) -> int:
    """Of the pairs' places, normals, levers, gaps and lengths."""
    return BYTES * 8 * sizes.pairs


def state_bytes(sizes: BeltSizes, asked: Asked) -> int:
    """Of a state, most of whose pairs carry."""
    unknowns = sizes.pairs + asked.lifting * sizes.hats
    return BYTES * (3 * unknowns + 4 * sizes.teeth)


def workspace(strip: Strip, sizes: BeltSizes, asked: Asked) -> int:
    """Bytes of factors and columns of all pieces.

    Parameters
    ----------
    strip : Strip
    sizes : BeltSizes
    asked : Asked

    Returns
    -------
    int
    """
    total = 0.0
    for piece, unknowns in _unknowns(strip, sizes):
        again = FACTOR_AGAIN if piece.cut_solutions < piece.kept else 0.0
        total += (1.0 + again) * FACTOR_BYTES * unknowns**FACTOR_BYTES_POWER
        total += 2 * BYTES * unknowns * piece.columns(asked)
    return round(total)


def _unknowns(strip: Strip, sizes: BeltSizes) -> list[tuple[PieceWork, int]]:
    """Pieces and their unknowns; ends are as large as one whose strand begins in mid-land."""
    last = 2 * (strip.wrapped_teeth - 1)
    counts = {
        places: 2 * len(mesh_strip(strip, sizes.elements, places=places).nodes)
        for places in ((0, 2), (-STRAND, 0), (last, last + STRAND))
        if places != (0, 2) or sizes.cell is not None
    }
    found = [] if sizes.cell is None else [(sizes.cell, counts[0, 2])]
    for piece in sizes.ends:
        found.append((piece, counts[(-STRAND, 0) if piece.held else (last, last + STRAND)]))
    return [(piece, count - piece.kept - piece.hats - piece.held) for piece, count in found]
