"""One mesh of a stage with a twisted carrier: a leaning planet in CalculiX and in flankload.

`./dev bench leaning-planet`. The planet of `SCENE` leans by 3.1 mrad, as one of four times its
usual torque on a soft carrier does.

The deck is that of `flankload verify` for sun and planet as a pair: sections of quadratic
triangles, extruded along the helix in layers of 15-node wedges; bores rigid. There the axis of the
planet is displaced in proportion to z; here the planet is rotated in space about the middle of its
axis, as a rigid pin does.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

import flankload as fl
from flankload.studies.verification.calculix import find_program, run_deck
from flankload.studies.verification.deck import deck_text
from flankload.studies.verification.solid_model import solid_model_of

if TYPE_CHECKING:
    from flankload.base.arrays import Floats

#: Elements on the half-width of a contact.
ELEMENTS = 0.4
#: Displacement of the pin along -x and -y per length along z.
RADIAL, TANGENTIAL = -0.9, 3.0
RELIEF = {"tip_relief_um": 90, "tip_relief_length": "short", "tip_relief_shape": "parabolic"}
TEETH = {"kind": "gear", "teeth": 18, "module_mm": 4, "helix_angle_deg": 12, **RELIEF}
SCENE: dict[str, Any] = {
    "name": "leaning planet",
    "body_1": {**TEETH, "hand": "right", "tip_diameter_mm": 81, "bore_diameter_mm": 30},
    "planet": {**TEETH, "hand": "left", "tip_diameter_mm": 81, "bore_diameter_mm": 30},
    "body_2": {
        **TEETH,
        "kind": "ring",
        "teeth": 54,
        "hand": "left",
        "tip_diameter_mm": 214,
        "root_diameter_mm": 231,
        "outer_diameter_mm": 270,
    },
    "stage": {
        "planets": 1,
        "pin_radial_inclinations_um_per_mm": [RADIAL],
        "pin_tangential_inclinations_um_per_mm": [TANGENTIAL],
    },
    "pair": {"center_distance_mm": 73.6085228, "face_width_mm": 20},
    "load": {"torque_Nm": 900},
    "positions": {"angles_deg": [8]},
    "effects": {"mesh_coupling": False},
    "accuracy": {"estimate": False},
}


def rotated(points: Floats, vector: Floats, center: Floats) -> Floats:
    """Points (n, 3) rotated about a center by a vector, rad."""
    angle = float(np.linalg.norm(vector))
    axis, arms = vector / angle, points - center
    across = np.cross(axis, arms)
    turned = np.sin(angle) * across + (1.0 - np.cos(angle)) * np.cross(axis, across)
    return np.asarray(points + turned)


def pair() -> fl.Scene:
    """Sun and planet as a pair."""
    keys = {name: SCENE[name] for name in ("name", "body_1", "load", "positions", "accuracy")}
    leans = {"inclination_um_per_mm": -RADIAL, "deviation_um_per_mm": -TANGENTIAL}
    keys |= {"body_2": SCENE["planet"], "pair": SCENE["pair"] | leans}
    return fl.Scene.from_dict(keys)


def row(name: str, loads: Floats, edges: Floats) -> str:
    """Share, centre and largest line load of the loads (2, L) of layers."""
    widths, total = np.diff(edges), (loads * np.diff(edges)).sum(axis=1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    line = loads.sum(axis=0)
    center, mean = (line * widths) @ middle / total.sum(), total.sum() / widths.sum()
    text = f"{name:10s} share of pair -1: {100 * total[0] / total.sum():.2f} %, centre of the load "
    return text + f"{center:.3f} mm, largest line load over mean {line.max() / mean:.4f}"


def run() -> str:
    """Write the deck, solve it, compare."""
    with TemporaryDirectory() as folder:
        return compared(Path(folder))


def compared(folder: Path) -> str:
    """The same in a folder."""
    scene, slope = pair(), -1e-3 * np.array([RADIAL, TANGENTIAL])
    model = solid_model_of(
        scene, fl.solve(scene), 0, elements_per_half_width=ELEMENTS, large_displacement=False
    )
    sun, planet = model.deck.parts
    upright = planet.nodes.copy()
    upright[:, :2] -= upright[:, 2:] * slope
    center = np.array([scene.pair.axes_apart_mm, 0.0, 0.0])
    leaning = rotated(upright, np.array([-slope[1], slope[0], 0.0]), center)
    deck = replace(model.deck, parts=(sun, replace(planet, nodes=leaning)))
    (folder / "deck.inp").write_text(deck_text(deck), encoding="ascii")
    answer = run_deck(find_program("ccx", folder), folder, deck, time_limit_s=None)
    edges, slices = deck.edges_mm, fl.solve(fl.Scene.from_dict(SCENE)).mesh(1, "sun").slices
    assert edges is not None
    assert slices is not None
    assert answer.line_load_N_per_mm is not None
    half = 0.5 * slices.width_mm
    low = np.maximum(edges[:-1, None], slices.z_mm - half)
    parts = np.maximum(np.minimum(edges[1:, None], slices.z_mm + half) - low, 0.0)
    loads = slices.line_load_N_per_mm[0] @ (parts / np.diff(edges)[:, None]).T
    rows = [f"{deck.unknowns} unknowns, {edges.size - 1} layers, {answer.wall_s:.0f} s"]
    rows += [row("CalculiX", answer.line_load_N_per_mm, edges), row("flankload", loads, edges)]
    return "\n".join(rows)
