"""Three-dimensional bodies with rounded tips and from meshes, against the plane and each other."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import flankload as fl
from tests.support.gear_scenes import example
from tests.support.paths import SCENES
from tests.support.solving import solve

#: Compliance of a gear of this width over that of its plane sections: Young's modulus of the plane
#: pair is divided by it, so that gaps, which do not grow with it, do not change.
SOFTER = 1.042
#: One and two loaded flanks differ by 0.4 % in that factor.
PLANE = 5e-3
HELICAL = {"helix_angle_deg": 15.0, "hand": "right"}
#: Without estimate, and coarse along the axis.
PLAIN = {"estimate": False, "tangents": False, "modes": 3}
FEW = PLAIN | {"axial_degree": 5, "load_degree_z": 1, "slices": 8}


def solved(bodies: tuple[dict[str, Any], dict[str, Any]], dimension: int = 3, **keys: Any):
    scene = deepcopy(example("external_gear"))
    for number, body in enumerate(bodies, start=1):
        scene[f"body_{number}"].update(body)
    scene["positions"] = {"count": 16}
    scene["effects"] = {"dimension": dimension, "contact": "lumped"}
    scene["accuracy"] = (FEW if dimension == 3 else PLAIN) | {"flank_element_mm": 1.5}
    scene.update(keys)
    return solve(fl.Scene.from_dict(scene))


def touches_tip(result: Any) -> np.ndarray:
    """Positions at which few percent of the load are carried near the start of a tip."""
    share = np.asarray(result.load_share)
    return ((share > 0.005) & (share < 0.25)).any(axis=1)


@pytest.mark.parametrize("tip", [{"tip_radius_mm": 0.3}, {"tip_chamfer_mm": 0.3}])
def test_tips_are_as_much_softer_than_in_the_plane_as_flanks(tip: dict[str, float]) -> None:
    softer, few = tip | {"young_modulus_MPa": 206000.0 / SOFTER}, {"flank_element_mm": 2.5}
    plane = solved((softer, softer), 2, accuracy=PLAIN | few)
    found = solved((tip, tip), accuracy=FEW | few)
    assert touches_tip(plane).any()
    np.testing.assert_allclose(found.transmission_error_um, plane.transmission_error_um, rtol=PLANE)
    np.testing.assert_allclose(found.load_share, plane.load_share, atol=0.01)


def test_rounded_helical_gears_of_the_other_hand_are_the_mirror_image() -> None:
    tip = {"tip_radius_mm": 0.3, "tip_diameter_mm": 83.0, "profile_shift": 0.0}
    wheel = {"tip_radius_mm": 0.3, "tip_diameter_mm": 120.0, "profile_shift": 0.0}
    left = {"helix_angle_deg": 15.0, "hand": "left"}
    pair = {"center_distance_mm": 93.3, "face_width_mm": 14}
    coarse = {"flank_element_mm": 4.0, "modes": 3, "axial_degree": 5, "load_degree_z": 1}
    accuracy = {"estimate": False, "tangents": False, "slices": 14, **coarse}
    keys = {"pair": pair, "positions": {"count": 3}, "accuracy": accuracy}
    right_hand = solved((tip | HELICAL, wheel | left), **keys)
    left_hand = solved((tip | left, wheel | HELICAL), **keys)
    np.testing.assert_allclose(
        left_hand.transmission_error_um, right_hand.transmission_error_um, rtol=1e-7
    )
    loads = np.asarray(right_hand.slice_line_load_N_per_mm)
    np.testing.assert_allclose(
        np.asarray(left_hand.slice_line_load_N_per_mm)[..., ::-1],
        loads,
        rtol=0,
        atol=1e-6 * loads.max(),
    )
    np.testing.assert_allclose(np.sum(right_hand.load_share, axis=1), 1.0, rtol=1e-9)


def from_meshes(body_1: dict[str, Any], body_2: dict[str, Any], **keys: Any):
    scene = deepcopy(example("external_gear_mesh"))
    for number, body in enumerate((body_1, body_2), start=1):
        table = scene[f"body_{number}"]
        table["file"] = str(SCENES / table["file"])
        table.update(body)
    scene["positions"] = {"count": 4}
    scene["effects"] = {"dimension": 3}
    scene["accuracy"] = FEW
    scene.update(keys)
    return solve(fl.Scene.from_dict(scene))


#: The flanks of the files are curves through nodes, the profiles of the gears are involutes: as far
#: apart in the plane.
NODES = 2.5e-3
#: Helix angle on the base circles, to which the helix of meshes without a profile refers.
ON_BASE = float(np.degrees(np.arctan(np.tan(np.radians(15.0)) * np.cos(np.radians(20.0)))))


def test_sectors_from_meshes_are_as_compliant_as_gears() -> None:
    found, gears = from_meshes({}, {}), solved(({}, {}), positions={"count": 4})
    np.testing.assert_allclose(found.transmission_error_um, gears.transmission_error_um, rtol=NODES)
    np.testing.assert_allclose(found.load_share, gears.load_share, atol=NODES)
    assert found.face_load_factor == pytest.approx(gears.face_load_factor, rel=NODES)


def test_helical_sectors_hold_the_torque_and_know_their_circles() -> None:
    """Equal helices given on base circles and on the reference circle of a profile."""
    crowned = {"lead_crowning_um": 5.0, "hand": "right"}
    left = {"helix_angle_deg": ON_BASE, "hand": "left"}
    found = from_meshes(crowned | {"helix_angle_deg": ON_BASE}, left)
    base_radius = example("external_gear_mesh")["body_1"]["reference_radius_mm"]
    axial_force = 302e3 * np.tan(np.radians(ON_BASE)) / base_radius
    np.testing.assert_allclose(found.slices.axial_force_N, axial_force, rtol=2e-3)
    profile = {
        "module_mm": 4.5,
        "profile_shift": 0.182,
        "tip_diameter_mm": 82.46,
        "pressure_angle_deg": 20,
    }
    other = from_meshes(crowned | {"helix_angle_deg": 15.0, "profile": profile}, left)
    np.testing.assert_allclose(other.transmission_error_um, found.transmission_error_um, rtol=NODES)


def test_a_section_whose_mirror_image_is_used_has_no_hand(tmp_path: Path) -> None:
    mesh = meshio.read(SCENES.parent / "meshes" / "fzg_c_pinion.msh")
    mesh.points[:, 1] *= -1
    mesh.cells[0].data[:] = mesh.cells[0].data[:, [0, 3, 2, 1, 7, 6, 5, 4, 8]]
    meshio.write(tmp_path / "mirrored.msh", mesh, file_format="gmsh22", binary=False)
    helix = {"helix_angle_deg": ON_BASE, "hand": "right"}
    other = {"helix_angle_deg": ON_BASE, "hand": "left"}
    with pytest.raises(fl.SceneError) as caught:
        from_meshes(helix | {"file": str(tmp_path / "mirrored.msh")}, other)
    assert caught.value.key == "body_1.flank_set"
    assert caught.value.expected == (
        "a flank that faces counter-clockwise, since there is a body_1.helix_angle_deg"
    )


def test_a_sector_from_a_mesh_is_twisted_as_a_gear_is() -> None:
    """Without a profile the base tangent is the normal in the middle of the flank."""
    twisted = {"profile_twist_um": 20.0}
    found, gears = from_meshes(twisted, {}), solved((twisted, {}), positions={"count": 4})
    np.testing.assert_allclose(found.transmission_error_um, gears.transmission_error_um, rtol=NODES)
    loads = (np.asarray(one.slice_line_load_N_per_mm) for one in (found, gears))
    np.testing.assert_allclose(*loads, rtol=0.0, atol=0.02 * gears.slice_line_load_N_per_mm.max())
    assert found.line_load_factor == pytest.approx(gears.line_load_factor, rel=0.01)
    even = from_meshes({}, {})
    assert found.line_load_factor > 1.1 * even.line_load_factor
