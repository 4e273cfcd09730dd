"""Positions over one pitch as data of an old program: points of flanks, compliances, angles.

``python -m tests.support.nodal_sweep`` regenerates the data file of the examples.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import flankload as fl
from flankload import _core
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.nodal_position import (
    DATA,
    SCENE,
    NodalPosition,
    body_lines,
    compliance_between,
    read_body,
)

SWEEP_DATA = DATA.with_name("sweep.dat")
#: Positions over one pitch, and fractions of the torque of the scene.
POSITIONS, PARTS = 8, (0.25, 0.5, 1.0)
#: Spacing of points, and distance from the last loaded point to the last point (or flank end).
SPACING_MM, BEYOND_MM = 0.15, 0.3
TITLE = (
    "FZG TYPE C, ONE PITCH: FLANKS POSITIONS TORQUES, THE TORQUES, AXES, ANGLES OF BOTH BODIES AT "
    "EACH POSITION; EACH BODY: SIZES, POINTS, COMPLIANCE"
)


@dataclass(frozen=True)
class NodalSweep:
    """Arguments of `flankload_sweep_points`.

    Attributes
    ----------
    still : NodalPosition
        The bodies at angles 0, and the largest torque.
    angles_rad : (2, P) array
        Angles of both bodies at each position.
    torques_Nmm : (T,) array
    results : T Results
        Results of the scene; none for data from a file.
    """

    still: NodalPosition
    angles_rad: np.ndarray
    torques_Nmm: np.ndarray
    results: tuple[fl.Result, ...] = ()

    def solve(self, **changes: Any) -> dict[str, Any]:
        """Call the core; arguments can be changed by name."""
        arguments: dict[str, Any] = {
            "n_circles": 0,
            "max_pairs": int(self.still.sizes[0].sum()),
            "turn": 1,
            "n_threads": 1,
            "angles_1": self.angles_rad[0],
            "angles_2": self.angles_rad[1],
            "torques": self.torques_Nmm,
            "axis_1": self.still.axes[0],
            "axis_2": self.still.axes[1],
        }
        for z, name in enumerate(("1", "2")):
            arguments |= {
                f"sizes_{name}": self.still.sizes[z],
                f"points_{name}": np.asfortranarray(self.still.points[z].T),
                f"compliance_{name}": np.asfortranarray(self.still.compliances[z]),
            }
        found = _core.flankload_sweep_points(*(arguments | changes).values())
        return dict(zip(NAMES, found, strict=True))

    def at(self, position: int) -> NodalPosition:
        """The bodies rotated to a position."""
        turned = []
        for points, axis, angle in zip(
            self.still.points, self.still.axes, self.angles_rad[:, position], strict=True
        ):
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            turned.append(axis + (points - axis) @ turn.T)
        return replace(self.still, points=(turned[0], turned[1]))


#: Results of `flankload_sweep_points`.
NAMES = (
    "status",
    "rotation",
    "tangent",
    "torque_2",
    "certificate",
    "flank_force",
    "n_pairs",
    "flank",
    "radius",
    "gap_angle",
    "force",
    "final_gap",
    "info",
)


def nodal_sweep(
    spacing_mm: float = SPACING_MM,
    positions: int = POSITIONS,
    parts: tuple[float, ...] = PARTS,
) -> NodalSweep:
    """One pitch of the external gear pair, with points wherever its flanks carry load."""
    tree = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    tree["accuracy"] = {"estimate": False, "tangents": False}
    tree["positions"] = {"count": positions}
    tree["load"]["torque_Nm"] = [part * tree["load"]["torque_Nm"] for part in parts]
    scene = fl.Scene.from_dict(tree)
    pair = build_bodies(scene)
    results = fl.solve(scene).by_torque
    tables = [results[-1].pairs(p) for p in range(positions)]
    sites = [
        k
        for k, site in enumerate(pair.pairing.sites)
        if any((table.force_N[table.site == site] > 0).any() for table in tables)
    ]
    axes = (np.zeros(2), np.array([pair.pairing.center_distance_mm, 0.0]))
    sizes, points, compliances = [], [], []
    for z, body in enumerate((pair.body_1, pair.body_2)):
        places, where = [], []
        for k in sites:
            carry = np.concatenate(
                [
                    (table.arc_length_1_mm, table.arc_length_2_mm)[z][
                        (table.site == pair.pairing.sites[k]) & (table.force_N > 0)
                    ]
                    for table in tables
                ]
            )
            low = carry.min() - BEYOND_MM
            high = min(carry.max() + BEYOND_MM, body.curve.length_mm)
            places.append(np.linspace(low, high, 1 + round((high - low) / spacing_mm)))
            turned = body.curve.rotated(pair.pairing.site_angles_rad[z][k])
            where.append(axes[z] + turned.point(places[-1]))
        sizes.append(np.array([s.size for s in places], dtype=np.int32))
        points.append(np.concatenate(where))
        compliances.append(
            compliance_between(body, scene, places, pair.pairing.site_teeth[z][sites])
        )
    torques = np.array([1000.0 * float(result.torque_Nm) for result in results])
    return NodalSweep(
        still=NodalPosition(
            torque_Nmm=float(torques.max()),
            axes=axes,
            sizes=(sizes[0], sizes[1]),
            points=(points[0], points[1]),
            compliances=(compliances[0], compliances[1]),
        ),
        angles_rad=np.array(pair.pairing.turns(pair.position_rad)),
        torques_Nmm=torques,
        results=results,
    )


def write_sweep(sweep: NodalSweep, path: Path) -> None:
    """Numbers only, as a Fortran program reads them; the first line describes them."""
    still = sweep.still
    lines = [
        TITLE,
        f"{still.sizes[0].size} {sweep.angles_rad.shape[1]} {sweep.torques_Nmm.size}",
        " ".join(f"{torque:.1f}" for torque in sweep.torques_Nmm),
        " ".join(f"{number:.4f}" for axis in still.axes for number in axis),
        *(" ".join(f"{angle:.15f}" for angle in both) for both in sweep.angles_rad.T),
    ]
    for body in zip(still.sizes, still.points, still.compliances, strict=True):
        lines += body_lines(*body)
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_sweep(path: Path) -> NodalSweep:
    """The same numbers as the examples read them."""
    numbers = iter(path.read_text(encoding="ascii").split("\n", 1)[1].split())
    flanks, positions, torques = (int(next(numbers)) for _ in range(3))
    loads = np.array([float(next(numbers)) for _ in range(torques)])
    axes = [float(next(numbers)) for _ in range(4)]
    angles = np.array([float(next(numbers)) for _ in range(2 * positions)])
    one, two = (read_body(numbers, flanks) for _ in range(2))
    return NodalSweep(
        still=NodalPosition(
            torque_Nmm=float(loads.max()),
            axes=(np.array(axes[:2]), np.array(axes[2:])),
            sizes=(one[0], two[0]),
            points=(one[1], two[1]),
            compliances=(one[2], two[2]),
        ),
        angles_rad=np.ascontiguousarray(angles.reshape(positions, 2).T),
        torques_Nmm=loads,
    )


if __name__ == "__main__":
    write_sweep(nodal_sweep(), SWEEP_DATA)
