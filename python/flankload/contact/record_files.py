"""Records of bodies, meshes and motions by their names in files, for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.body_record import core_sites
from flankload.contact.meshes import motion_numbers
from flankload.contact.meshes_contact import meshes_problem
from flankload.contact.pair_table import columns_of
from flankload.contact.sweep import motion_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.flank_contact import FlankContact
    from flankload.contact.meshes import Motion
    from flankload.contact.meshes_contact import AnyContact
    from flankload.pairing.gear_mesh import GearMesh

    Records = Mapping[str, Floats]
    #: Arguments of `solve_meshes`: records, motions, angles, loads, displacements.
    MeshProblem = tuple[
        list[Floats], list[Floats], tuple[Motion, ...], Floats, Floats, Floats | None
    ]

#: First number of a record of motions: of a pair, of several meshes (`record_file.f90`).
PAIR_MARK, MESHES_MARK = 70768001, 70768002
#: Numbers in a line of a text.
IN_LINE = 4


def pair_records(
    contact: FlankContact, position_rad: Floats, torques_Nmm: Sequence[float]
) -> Records:
    """Records of both bodies and their mesh, and the motion (`docs/reference/records.md`)."""
    mesh, one, two = contact.records
    n_columns = len(columns_of(friction=contact.mesh.friction is not None))
    counts = [position_rad.size, len(torques_Nmm), core_sites(contact.mesh), n_columns]
    motion = motion_of(contact.mesh, position_rad)
    return {
        "body_1": one,
        "body_2": two,
        "mesh": mesh,
        "motion": _motions(PAIR_MARK, counts, np.asarray(torques_Nmm), motion),
    }


def meshes_records(
    contact: AnyContact, position_rad: Floats, torques_Nmm: Sequence[float]
) -> Records:
    """Records of all bodies and meshes of a drive, and the motions."""
    problem = meshes_problem(contact, position_rad, torques_Nmm)
    bodies, names = contact.pairing.body_names, []
    for mesh in contact.pairing.meshes:
        one, two = mesh.members
        names.append(f"{bodies[one]}_{bodies[two]}")
    return {
        **dict(zip(bodies, problem[0], strict=True)),
        **dict(zip(names, problem[1], strict=True)),
        "motion": _motions_of_meshes(contact.meshes, problem),
    }


def _motions_of_meshes(meshes: Sequence[GearMesh], problem: MeshProblem) -> Floats:
    """Record of the motions of several meshes."""
    bodies, _, motions, angles, loads, displacements = problem
    counts = [len(angles), len(loads), len(bodies), len(meshes), len(motions)]
    counts.append(sum(core_sites(mesh) for mesh in meshes))
    parts = (
        angles.transpose(2, 1, 0),
        motion_numbers(motions).astype(float),
        np.asarray(loads).T,
        np.asarray(displacements).transpose(2, 1, 0),
    )
    return _motions(MESHES_MARK, counts, *parts)


def _motions(mark: int, counts: Sequence[int], *parts: Floats) -> Floats:
    """Record of motions: mark, length, counts, and the parts column by column."""
    numbers = np.concatenate([counts, *(part.ravel(order="F") for part in parts)])
    return np.concatenate([[mark, numbers.size + 2], numbers])


def text_of(record: Floats, title: str) -> str:
    """Numbers of a record, to the last bit, with a title behind them, which no program reads."""
    words = [f"{number:.17g}" for number in record[: int(record[1])].tolist()]
    lines = (words[k : k + IN_LINE] for k in range(0, len(words), IN_LINE))
    return "\n".join([*(" ".join(line) for line in lines), f"! {title}"]) + "\n"


def bytes_of(record: Floats) -> bytes:
    """The bytes of the numbers of a record."""
    return np.ascontiguousarray(record[: int(record[1])], dtype=float).tobytes()
