"""Elements on unmodified flanks: forces have the direction of the modified flank."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pytest

import flankload as fl
from flankload.bodies import Body
from flankload.bodies.root_fillet import root_fillets
from flankload.cost import Account
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.compliance.loads import ModeLoads
from flankload.elasticity.compliance.modified_flank import on_modified_flank
from flankload.elasticity.compliance.plane_extent import PlaneExtent
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.near_field import consistent_loads, mode_values
from flankload.elasticity.sector_closure import close_ring
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.condensed import condense
from tests.support.gear_scenes import example

MODES = 5
RELIEF = {"body_1.tip_relief_um": 60.0, "body_1.tip_relief_start_diameter_mm": 76.5}
#: Terms of the second order and the finite number of modes, relative to the change; 0.2 on the
#: loaded flank if the near field of tangential loads is omitted.
SECOND_ORDER = 0.05


def body_with(**keys: Any) -> Body:
    scene = fl.Scene.from_dict(example("external_gear"))
    return build_bodies(scene.replace(RELIEF | {f"body_1.{k}": x for k, x in keys.items()})).body_1


@pytest.mark.parametrize("shape", ["linear", "parabolic"])
def test_forces_have_the_direction_of_the_modified_flank(shape: str) -> None:
    """Against elements that are loaded, and read, along the normals of the modified flank."""
    body = body_with(tip_relief_shape=shape)
    assert body.elements is not None
    options = JobOptions(n_modes=MODES, plane="strain", friction=True)
    plain = flank_compliance(body.elements, options)
    found, expected = on_modified_flank(plain, body), loaded_along_modified_normals(body)
    places = np.linspace(0.02, 0.98, 7)
    places = body.mode_range_mm[0] + places * np.ptp(body.mode_range_mm)
    own = mode_values(places, body.mode_range_mm, MODES)
    elements = mode_values(places, body.unmodified.mode_range_mm, MODES)
    before, behind = (elements @ smooth @ elements.T for smooth in (plain.smooth, expected))
    change = np.abs(behind - before).max(axis=(1, 2))
    apart = np.abs(own @ found.smooth @ own.T - behind).max(axis=(1, 2))
    assert change[0] > 5e-3 * np.abs(before).max()
    assert (apart <= SECOND_ORDER * change).all()


def loaded_along_modified_normals(body: Body) -> np.ndarray:
    """`smooth` (z, p, p) of normal loads on the elements with the normals of the body."""
    mesh, (low, high) = body.elements.mesh, body.elements.mode_range_mm

    def directed(along: Literal["normal", "tangent"]) -> np.ndarray:
        def values(s: np.ndarray) -> np.ndarray:
            there = np.minimum(s, body.mode_range_mm[1])
            direction = getattr(body.elements.curve, along)(s)
            part = np.sum(body.curve.normal(there) * direction, axis=1)
            return part[:, None] * mode_values(s, (low, high), MODES)

        return consistent_loads(mesh, values, count=MODES, along=along)

    loads = directed("normal") + directed("tangent")
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    response = close_ring(condense(matrix, loads, mesh)[0], body.teeth)
    modes = ModeLoads(body.elements, PlaneExtent(), MODES, friction=False)
    modes.subtract_near_field(response, np.zeros(1, dtype=int), Account())
    return response


def test_forces_on_coast_flanks_and_root_stress_have_that_direction_too() -> None:
    """Against elements that follow the modified flank, whose teeth are thinner, too."""
    fine = {"body_1.tip_relief_shape": "parabolic", "accuracy.flank_element_mm": 0.6}
    scene = fl.Scene.from_dict(example("external_gear")).replace(RELIEF | fine)
    body, modified = (build_bodies(scene, modified_elements=on).body_1 for on in (False, True))
    options = {"n_modes": MODES, "plane": "strain", "friction": True, "coast_flanks": True}
    plain, expected = (
        flank_compliance(each, JobOptions(**options, fillets=root_fillets(each, "body_1")))
        for each in (body.unmodified, modified)
    )
    found = on_modified_flank(plain, body)
    near_tip = [np.dot([0.05, 0.95], body.mode_range_mm)]
    weights = (2 * np.arange(MODES) + 1) * mode_values(near_tip, body.mode_range_mm, MODES)[0]
    for of in (
        lambda one: one.coast.normal[0],
        lambda one: one.root.response[0, :, :MODES] @ weights,
    ):
        before, behind = (np.abs(of(one) - of(expected)).max() for one in (plain, found))
        assert behind < 0.6 * before
