"""One position of a scene as data of an old program: points of flanks and their compliance.

``python -m tests.support.nodal_position`` regenerates the data file of the examples.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import flankload as fl
from flankload import _core
from flankload.bodies import Body
from flankload.elasticity.near_field import mode_values
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.cells_near_field import cells_near_field
from tests.support.paths import ROOT, SCENES

DATA = ROOT / "examples" / "legacy_fortran" / "pair.dat"
SCENE = SCENES / "external_gear.toml"
#: Half a pitch further, two tooth pairs carry load.
POSITION, OF_POSITIONS = 16, 32
#: Points of the example: number per flank, and length to both sides of the contact.
POINTS, HALF_LENGTH_MM = 17, 0.6
TITLE = "FZG TYPE C, HALF A PITCH ON: FLANKS, TORQUE, AXES; EACH BODY: SIZES, POINTS, COMPLIANCE"
#: Digits in the file: half of the last one is 5e-10 of a compliance, far below the spacing error.
DIGITS = 9


@dataclass(frozen=True)
class NodalPosition:
    """Arguments of `flankload_position`, and a torque.

    Attributes
    ----------
    torque_Nmm : float
    axes : two (2,) arrays
        O1 and O2, mm.
    sizes : two (f,) arrays
        Number of points of each flank of a body.
    points : two (n, 2) arrays
        Common frame, mm.
    compliances : two (n, n) arrays
        mm/N over the face width.
    rotation_rad, site_force_N
        Results of the scene at this position.
    """

    torque_Nmm: float
    axes: tuple[np.ndarray, np.ndarray]
    sizes: tuple[np.ndarray, np.ndarray]
    points: tuple[np.ndarray, np.ndarray]
    compliances: tuple[np.ndarray, np.ndarray]
    rotation_rad: float = np.nan
    site_force_N: np.ndarray | None = None

    def pairs(self, n_circles: int = 0, room: int = 400) -> tuple[np.ndarray, ...]:
        """Flank, radius, gap angle, three levers and K (n, n) of all pairs."""
        n, *rows, matrix, info = _core.flankload_position(
            n_circles,
            room,
            1,
            *self.axes,
            self.sizes[0],
            np.asfortranarray(self.points[0].T),
            np.asfortranarray(self.compliances[0]),
            self.sizes[1],
            np.asfortranarray(self.points[1].T),
            np.asfortranarray(self.compliances[1]),
        )
        assert info == 0
        return *(row[:n] for row in rows), matrix[: n * n].reshape(n, n).T


def compliance_between(
    body: Body, scene: fl.Scene, places: list[np.ndarray], teeth: np.ndarray
) -> np.ndarray:
    """Compliance (n, n) between evenly spaced points of flanks, mm/N over the face width.

    Each load is distributed evenly over a strip as wide as the spacing of the points.
    """
    compliance = compliance_of(body, scene)
    values = [mode_values(s, compliance.modes.range_mm, compliance.smooth.shape[1]) for s in places]
    blocks = [
        [
            v_i @ compliance.smooth[int(compliance.block_of(tooth_i, tooth_j, body.teeth))] @ v_j.T
            for tooth_j, v_j in zip(teeth, values, strict=True)
        ]
        for tooth_i, v_i in zip(teeth, values, strict=True)
    ]
    for i, s in enumerate(places):
        blocks[i][i] += cells_near_field(compliance, s, s[1] - s[0])
    return np.block(blocks) / scene.pair.face_width_mm


def nodal_position(points: int = POINTS, half_length_mm: float = HALF_LENGTH_MM) -> NodalPosition:
    """The position half a pitch further, its flanks as points around the contact."""
    tree = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    tree["accuracy"] = {"estimate": False, "tangents": False}
    scene = fl.Scene.from_dict(tree)
    pair = build_bodies(scene)
    result = fl.solve(scene)
    assert isinstance(result, fl.Result)
    table = result.pairs(POSITION)
    position = pair.position_rad[POSITION : POSITION + 1]
    turns = pair.pairing.turns(position)
    axes = (np.zeros(2), np.array([pair.pairing.center_distance_mm, 0.0]))
    loaded = [
        k
        for k, site in enumerate(pair.pairing.sites)
        if table.force_N[table.site == site].sum() > 0
    ]
    all_points, compliances = [], []
    for z, body in enumerate((pair.body_1, pair.body_2)):
        places = (table.arc_length_1_mm, table.arc_length_2_mm)[z]
        s, where = [], []
        for k in loaded:
            own = table.site == pair.pairing.sites[k]
            middle = np.average(places[own], weights=table.force_N[own])
            s.append(middle + np.linspace(-half_length_mm, half_length_mm, points))
            angle = turns[z][0] + pair.pairing.site_angles_rad[z][k]
            where.append(axes[z] + body.curve.rotated(angle).point(s[-1]))
        all_points.append(np.concatenate(where))
        compliances.append(compliance_between(body, scene, s, pair.pairing.site_teeth[z][loaded]))
    sizes = np.full(len(loaded), points, dtype=np.int32)
    return NodalPosition(
        torque_Nmm=1000.0 * float(result.torque_Nm),
        axes=axes,
        sizes=(sizes, sizes),
        points=(all_points[0], all_points[1]),
        compliances=(compliances[0], compliances[1]),
        rotation_rad=float(result.rotation_rad[POSITION]),
        site_force_N=np.array(
            [table.force_N[table.site == pair.pairing.sites[k]].sum() for k in loaded]
        ),
    )


def write_data(position: NodalPosition, path: Path) -> None:
    """Numbers only, as a Fortran program reads them; the first line describes them."""
    lines = [
        TITLE,
        f"{position.sizes[0].size} {position.torque_Nmm:.1f}",
        " ".join(f"{number:.4f}" for axis in position.axes for number in axis),
    ]
    for body in zip(position.sizes, position.points, position.compliances, strict=True):
        lines += body_lines(*body)
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def body_lines(sizes: np.ndarray, points: np.ndarray, compliance: np.ndarray) -> list[str]:
    """Sizes, points, and the lower triangle of the compliance row by row."""
    return [
        " ".join(str(size) for size in sizes),
        *(" ".join(f"{number:.9f}" for number in point) for point in points),
        *(
            " ".join(f"{number:.{DIGITS - 1}E}" for number in row[: i + 1])
            for i, row in enumerate(compliance)
        ),
    ]


def read_data(path: Path) -> NodalPosition:
    """The same numbers as the examples read them."""
    numbers = iter(path.read_text(encoding="ascii").split("\n", 1)[1].split())
    flanks, torque = int(next(numbers)), float(next(numbers))
    axes = [float(next(numbers)) for _ in range(4)]
    one, two = (read_body(numbers, flanks) for _ in range(2))
    return NodalPosition(
        torque_Nmm=torque,
        axes=(np.array(axes[:2]), np.array(axes[2:])),
        sizes=(one[0], two[0]),
        points=(one[1], two[1]),
        compliances=(one[2], two[2]),
    )


def read_body(numbers: Iterator[str], flanks: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sizes, points and compliance of one body."""
    sizes = np.array([int(next(numbers)) for _ in range(flanks)], dtype=np.int32)
    n = int(sizes.sum())
    points = np.array([float(next(numbers)) for _ in range(2 * n)]).reshape(n, 2)
    matrix = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            matrix[i, j] = matrix[j, i] = float(next(numbers))
    return sizes, points, matrix


def spoilt(values: np.ndarray, bad: float = np.nan) -> np.ndarray:
    """The same with a last number that is not finite."""
    values = np.array(values, order="F")
    values[..., -1] = bad
    return values


if __name__ == "__main__":
    write_data(nodal_position(), DATA)
