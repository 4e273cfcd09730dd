"""Several meshes in one contact problem: bodies with motions and loads, each in one or more meshes.

Frames: a mesh has a frame of its own with its body 1 at the origin and the axis of body 2 on its x
axis, at the centre distance. The fixed frame is common to all meshes (for a planetary stage that of
the carrier). A vector v of the frame of a mesh is R(angle) (v_x, sense v_y) in the fixed frame;
with sense -1 the frame is a mirror image, in which coast flanks touch as working flanks do.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload import _core
from flankload.contact.body_record import packed_parts
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.pair_table import PackedPairs, columns_of, join_pairs
from flankload.contact.status import Status, checked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

#: Kinds of motion and their numbers in the core.
KINDS = {"x": 1, "y": 2, "rotation": 3}


@dataclass(frozen=True)
class Motion:
    """A motion of a body in the fixed frame: along x or y, or counter-clockwise about its axis.

    `body`: from 0; `sign` -1: in the opposite direction; `last`: bodies from `body` to this one
    move together.
    """

    body: int
    kind: Literal["x", "y", "rotation"] = "rotation"
    sign: int = 1
    last: int | None = None

    @property
    def through(self) -> int:
        """The last body that moves."""
        return self.body if self.last is None else self.last


@dataclass(frozen=True)
class Members:
    """Place of a mesh among several.

    Attributes
    ----------
    bodies : tuple of int
        Numbers of body 1 and body 2, from 0. Body 1 drives body 2 counter-clockwise in the frame of
        the mesh.
    sites_before : tuple of int
        Number of sites of either body before those of the mesh: site k of the mesh is site
        sites_before + k of the body.
    angle_rad : float
        Angle of the x axis of its frame in the fixed frame.
    sense : int
        -1 if its frame is a mirror image, else 1.
    """

    bodies: tuple[int, int]
    sites_before: tuple[int, int] = (0, 0)
    angle_rad: float = 0.0
    sense: int = 1

    @property
    def values(self) -> NDArray[np.float64]:
        """(6,) Values of the part "members" of the record of a mesh."""
        first, second = self.bodies
        before = self.sites_before
        return np.array([first + 1, second + 1, *before, self.angle_rad, self.sense], dtype=float)


@dataclass(frozen=True)
class MeshStates:
    """States of P positions under T cases of loads; q motions, B bodies, S sites of all meshes.

    Attributes
    ----------
    status : (P, T)
        As for a pair; -23: several meshes or motions exclude the settings of the meshes.
    motion : (P, T, q)
        Motions, mm or rad; NaN for one on which no force works.
    tangent : (P, T, q, q)
        Derivatives of the motions (third axis) with respect to the loads (last axis).
    certificate : (P, T, 3)
        Backward error, condition number, margin.
    counters : (P, T, 7)
        In the order of `CORE_COUNTERS`.
    resultant : (P, T, B, 3)
        Forces along x and y, N, and moment about its axis, N mm, of all contacts on each body in
        the fixed frame.
    site_force_N, site_peak_N_per_mm, site_corner : (P, T, S)
        Values of the sites, mesh after mesh.
    pairs : tuple of PackedPairs
        Pairs of each case of loads; sites are those of all meshes, points and normals are in the
        frame of their mesh.
    """

    status: NDArray[np.int64]
    motion: NDArray[np.float64]
    tangent: NDArray[np.float64]
    certificate: NDArray[np.float64]
    counters: NDArray[np.int64]
    resultant: NDArray[np.float64]
    site_force_N: NDArray[np.float64]
    site_peak_N_per_mm: NDArray[np.float64]
    site_corner: NDArray[np.int64]
    pairs: tuple[PackedPairs, ...]

    def at(self, rows: slice) -> MeshStates:
        """The states at some of the positions."""
        arrays = {
            field.name: getattr(self, field.name)[rows]
            for field in fields(self)
            if field.name != "pairs"
        }
        pairs = []
        for part in self.pairs:
            chosen = replace(part, first=part.first[rows], count=part.count[rows])
            pairs.append(join_pairs([chosen], np.arange(chosen.count.size)))
        return MeshStates(**arrays, pairs=tuple(pairs))

    def without_forces(self) -> MeshStates:
        """The states of vanishing loads, which have motions only."""
        none = {
            name: np.zeros_like(getattr(self, name))
            for name in ("resultant", "site_force_N", "site_peak_N_per_mm")
        }
        tangent = np.full_like(self.tangent, np.nan)
        pairs = tuple(replace(part, count=np.zeros_like(part.count)) for part in self.pairs)
        return replace(self, tangent=tangent, pairs=pairs, **none)


def with_members(mesh: NDArray[np.float64], members: Members) -> NDArray[np.float64]:
    """Record of a mesh with its place among several."""
    return packed_parts(mesh, [("members", members.values)])


def with_support(body: NDArray[np.float64], compliance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Record of a body on springs.

    `compliance` (3, 3), symmetric: displacement along x and y, mm, and rotation, rad, in the fixed
    frame per force, N, and moment, N mm.
    """
    return packed_parts(body, [("support", np.asarray(compliance, dtype=float).ravel(order="F"))])


def with_shaft(
    body: NDArray[np.float64], compliance: NDArray[np.float64], z_mm: float
) -> NDArray[np.float64]:
    """Record of a body with a width on springs.

    `compliance` (6, 6), symmetric: displacements, mm, and rotations, rad, of its section at `z_mm`
    in the fixed frame per force, N, and moment, N mm; without rotation about its axis.
    """
    values = np.append(np.asarray(compliance, dtype=float).ravel(order="F"), z_mm)
    return packed_parts(body, [("shaft", values)])


def solve_meshes(
    bodies: Sequence[NDArray[np.float64]],
    meshes: Sequence[NDArray[np.float64]],
    motions: Sequence[Motion],
    angles_rad: NDArray[np.float64],
    loads: NDArray[np.float64],
    displacements: NDArray[np.float64] | None = None,
    *,
    keep_pairs: bool = True,
) -> MeshStates:
    """Solve several bodies and their meshes in all positions under all cases of loads.

    Parameters
    ----------
    bodies, meshes : sequences of (n,)
        Records of the bodies (B) and meshes (M).
    motions : sequence of Motion
        Motions (q) of the bodies; a body without one does not move.
    angles_rad : (P, M, 2)
        Angles of both bodies of each mesh in the frame of the mesh.
    loads : (T, q)
        Force, N, or moment, N mm, on the body in the direction of the motion.
    displacements : (P, B, 3), optional
        Known displacements along x and y, mm, and rotations, rad, of the bodies in the fixed frame.
    keep_pairs : bool
        Whether pairs are returned.

    Raises
    ------
    InputError
        If the core refuses an argument.
    """
    angles = np.asfortranarray(np.asarray(angles_rad, dtype=float).transpose(2, 1, 0))
    n_positions, n_cases = angles.shape[2], len(loads)
    if displacements is None:
        displacements = np.zeros((n_positions, len(bodies), 3))
    records = [*bodies, *meshes]
    n_sites = sum(int(record[4]) for record in meshes)
    arguments = (
        n_sites,
        angles,
        motion_numbers(motions),
        np.asfortranarray(np.asarray(loads, dtype=float).T),
        np.asfortranarray(np.asarray(displacements, dtype=float).transpose(2, 1, 0)),
        np.array([len(record) for record in records], dtype=np.intc),
        np.concatenate(records),
    )
    n_columns = len(columns_of(friction=False))
    room = 40 * n_sites * n_positions * n_cases if keep_pairs else 0
    while True:
        site = np.empty(room, dtype=np.intc)
        table = np.empty(room * n_columns)
        control = np.zeros(2, dtype=np.intc)
        outputs = _core.flankload_sweep_meshes(*arguments, control, site, table)
        checked(outputs[-1])
        if not np.any(outputs[0] == Status.NO_ROOM):
            break
        room *= 2
    return _states(outputs[:-1], site, table.reshape(room, n_columns))


def motion_numbers(motions: Sequence[Motion]) -> NDArray[np.intc]:
    """(4, q) Body, body through which it moves, kind and sign of motions for the core."""
    numbers = [(m.body + 1, m.through + 1, KINDS[m.kind], m.sign) for m in motions]
    return np.array(numbers, dtype=np.intc).T


def _states(
    outputs: tuple[NDArray, ...], site: NDArray[np.intc], table: NDArray[np.float64]
) -> MeshStates:
    """Outputs of the core, with the axes of positions and cases in front."""
    status, motion, tangent, certificate, counters, resultant, force, peak, corner = outputs
    n = len(CORE_COUNTERS)
    count, first = counters[n], counters[n + 1] - 1
    stored = np.where(first >= 0, count, 0)
    # the room for pairs is many times larger than what one case of loads has of them
    each = [PackedPairs(site, table, first[:, t], stored[:, t]) for t in range(status.shape[1])]
    own = [join_pairs([part], np.arange(len(status))) for part in each]
    return MeshStates(
        status=status,
        motion=motion.transpose(1, 2, 0),
        tangent=tangent.transpose(2, 3, 0, 1),
        certificate=certificate.transpose(1, 2, 0),
        counters=counters[:n].transpose(1, 2, 0),
        resultant=resultant.transpose(2, 3, 1, 0),
        site_force_N=force.transpose(1, 2, 0),
        site_peak_N_per_mm=peak.transpose(1, 2, 0),
        site_corner=corner.transpose(1, 2, 0),
        pairs=tuple(replace(part, site=part.site - 1) for part in own),
    )
