"""Measures `docs/reference/plane_limits.md`: what plane models of ten gear pairs miss.

`./dev measure` runs it; alone it takes some minutes: `.venv/bin/python docs/make_plane_limits.py`.
Finished pairs are kept in out/plane_limits.json; remove the file to measure them again.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import cos, pi, radians
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from msgspec import structs

import flankload as fl
from flankload.base.files import write_atomically
from flankload.plot.style import STYLE, new_figure, png_of
from flankload.scene.plane_section import plane_section

DOCS = Path(__file__).parent
KEPT = DOCS.parent / "out" / "plane_limits.json"
MODULE, TEETH, TORQUE_PER_WIDTH = 3.0, (25, 60), 10.0
#: Wide bodies need higher degrees along the axis.
WIDE, WIDE_DEGREES = 6.0, {"axial_degree": 14, "load_degree_z": 10, "slices": 56}
POSITIONS = 24


@dataclass(frozen=True)
class Case:
    """A gear pair.

    Attributes
    ----------
    helix_deg : float
    width : float
        Face width in normal modules.
    lead : dict
        Lead modifications of body 1.
    pair : dict
        Misalignment.
    """

    helix_deg: float
    width: float
    lead: dict[str, Any]
    pair: dict[str, Any]

    @property
    def words(self) -> str:
        """Modifications and errors along the axis."""
        found = []
        if "lead_crowning_um" in self.lead:
            found.append(f"C_β {self.lead['lead_crowning_um']:g} µm")
        if "helix_slope_um" in self.lead:
            found.append(f"C_Hβ {self.lead['helix_slope_um']:g} µm")
        if self.pair:
            found.append(f"f_Σβ {self.pair['deviation_um_per_mm']:g} µm/mm")
        return ", ".join(found) or "–"

    @property
    def overlap(self) -> float:
        """Overlap ratio ε_β."""
        return self.width * float(np.sin(radians(self.helix_deg))) / pi


CASES = (
    Case(0, 2, {}, {}),
    Case(0, 5, {}, {}),
    Case(0, 10, {}, {}),
    Case(0, 15, {}, {}),
    Case(0, 8, {"lead_crowning_um": 6.0}, {"deviation_um_per_mm": 0.5}),
    Case(10, 5, {}, {}),
    Case(15, 8, {"lead_crowning_um": 5.0}, {}),
    Case(20, 10, {}, {}),
    Case(25, 12, {"lead_crowning_um": 6.0}, {"deviation_um_per_mm": 0.3}),
    Case(30, 15, {"lead_crowning_um": 6.0}, {}),
)


def scene_of(case: Case) -> fl.Scene:
    """Scene of a case: 25 and 60 teeth of module 3, a torque of 10 N m per mm of face width."""
    secant, width = 1.0 / cos(radians(case.helix_deg)), case.width * MODULE
    tip = [MODULE * (teeth * secant + 2.0) for teeth in TEETH]
    bodies = {
        f"body_{z + 1}": {
            "kind": "gear",
            "teeth": TEETH[z],
            "module_mm": MODULE,
            "profile_shift": (0.2, -0.23)[z],
            "tip_diameter_mm": tip[z] + 2.0 * MODULE * (0.2, -0.2)[z],
            "bore_diameter_mm": (40.0, 60.0)[z],
            "tip_relief_um": 20.0,
            "tip_relief_start_diameter_mm": tip[z] + 2.0 * MODULE * (0.2, -0.2)[z] - 2.2,
            "tip_relief_shape": "parabolic",
        }
        for z in (0, 1)
    }
    bodies["body_1"] |= case.lead
    if case.helix_deg:
        for body, hand in zip(bodies.values(), ("right", "left"), strict=True):
            body |= {"helix_angle_deg": case.helix_deg, "hand": hand}
    return fl.Scene.from_dict(
        {
            **bodies,
            "pair": {
                "center_distance_mm": 0.5 * MODULE * sum(TEETH) * secant,
                "face_width_mm": width,
                **case.pair,
            },
            "load": {"torque_Nm": TORQUE_PER_WIDTH * width},
            "positions": {"count": POSITIONS},
            "effects": {"dimension": 3, "root_stress": True},
            "accuracy": {"estimate": False, **(WIDE_DEGREES if case.width > WIDE else {})},
        }
    )


def measured(case: Case) -> dict[str, dict[str, float]]:
    """Quantities of three dimensions, of the plane section, and of that in plane stress."""
    scene = scene_of(case)
    plane = plane_section(scene)
    discs = replace(plane, accuracy=structs.replace(plane.accuracy, plane="stress"))
    models = {"solid": scene, "strain": plane, "stress": discs}
    return {name: _quantities(fl.solve(model)) for name, model in models.items()}


def _quantities(result: fl.Result) -> dict[str, float]:
    summary = result.summary
    return {
        "mean_um": float(summary["transmission_error_mean_um"]),
        "peak_to_peak_um": float(summary["transmission_error_peak_to_peak_um"]),
        "face_load_factor": result.face_load_factor,
        "pressure_MPa": float(result.peak_pressure_MPa.max()),
        "root_stress_MPa": float(summary["root_stress_1"]["tension"]["stress_MPa"]),
        "share": float(result.load_share.max()),
        "cpu_s": sum(stage["cpu_s"] for stage in result.cost["stages"].values()),
    }


def main() -> None:
    """Measure, draw, write."""
    KEPT.parent.mkdir(exist_ok=True)
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for case in CASES:
        key = repr(case)
        if key not in kept:
            print(f"{case.helix_deg:g}°, b/m {case.width:g} …", flush=True)
            kept[key] = measured(case)
            KEPT.write_text(json.dumps(kept))
    found = [kept[repr(case)] for case in CASES]
    write_atomically(DOCS / "pictures" / "plane_limits.png", _picture(found))
    write_atomically(DOCS / "reference" / "plane_limits.md", "\n".join(_page(found)) + "\n")


def _part(one: dict[str, dict[str, float]], model: str, name: str) -> float:
    """Difference between a plane model and three dimensions, %."""
    return 100.0 * (one[model][name] / one["solid"][name] - 1.0)


def _page(found: list[dict[str, dict[str, float]]]) -> Iterator[str]:
    yield "# What a plane model misses"
    yield ""
    yield (
        "Ten gear pairs of 25 and 60 teeth (m_n 3 mm, 10 N m per mm of face width, parabolic tip "
        "relief of 20 µm on both gears, bores held), computed in three dimensions and as their "
        "*plane section*: the transverse section with straight teeth over the face width, in plane "
        "strain (the default) and in plane stress. Columns of plane models are differences from "
        "three dimensions. Measured by `docs/make_plane_limits.py`."
    )
    yield ""
    heads = (
        "β",
        "b/m_n",
        "ε_β",
        "along the axis",
        "mean TE, strain",
        "stress",
        "peak to peak, µm: 3D",
        "strain",
        "K_Hβ",
        "largest pressure, strain",
        "root stress, strain",
        "CPU s: 3D",
        "plane",
    )
    yield "| " + " | ".join(heads) + " |"
    yield "|" + "---|" * len(heads)
    for case, one in zip(CASES, found, strict=True):
        cells = (
            f"{case.helix_deg:g}°",
            f"{case.width:g}",
            f"{case.overlap:.2f}",
            case.words,
            *(f"{_part(one, model, 'mean_um'):+.1f} %" for model in ("strain", "stress")),
            *(f"{one[model]['peak_to_peak_um']:.2f}" for model in ("solid", "strain")),
            f"{one['solid']['face_load_factor']:.2f}",
            f"{_part(one, 'strain', 'pressure_MPa'):+.0f} %",
            f"{_part(one, 'strain', 'root_stress_MPa'):+.0f} %",
            f"{one['solid']['cpu_s']:.1f}",
            f"{one['strain']['cpu_s']:.2f}",
        )
        yield "| " + " | ".join(cells) + " |"
    yield ""
    yield "![Plane models against three dimensions](../pictures/plane_limits.png)"
    yield ""
    yield TEXT.rstrip()


TEXT = """\
* A spur pair without errors along the axis lies between plane strain and plane stress. Plane strain
  is 4.6 % too stiff at a width of 2 modules and 2.1 % at 15.
* With a helix the plane section is another gear: its pairs enter and leave contact over the whole
  width at one time, so that the peak to peak of its transmission error is that of a spur gear, up
  to 15 times that of the helical pair.
* Crowning and misalignment have no place in a plane model: its rotation is a third smaller, and its
  pressure and root stress are up to a fifth smaller.
* K_Hβ is the largest load over the face width, averaged over the mesh period, divided by its mean.
  Bores are held over their width.
* Contact is lumped in slices in three dimensions, and resolved by cells in the plane.
"""


def _picture(found: list[dict[str, dict[str, float]]]) -> bytes:
    names = (("mean_um", "mean transmission error"), ("root_stress_MPa", "root stress"))
    with rc_context(STYLE):
        figure = new_figure((9.6, 3.8))
        axes = figure.subplots(1, 2)
        labels = [f"{case.helix_deg:g}°, {case.width:g}" for case in CASES]
        at = np.arange(len(CASES))
        for each, (name, title) in zip(axes, names, strict=True):
            for shift, model in ((-0.2, "strain"), (0.2, "stress")):
                parts = [_part(one, model, name) for one in found]
                each.barh(at + shift, parts, height=0.38, label=f"plane {model}")
            each.axvline(0.0, color="#444444", linewidth=0.8)
            each.set_yticks(at, labels)
            each.invert_yaxis()
            each.set_xlabel(f"{title}, difference from three dimensions in %")
        axes[0].set_ylabel("helix angle, face width in modules")
        axes[0].legend()
    return png_of(figure)


if __name__ == "__main__":
    main()
