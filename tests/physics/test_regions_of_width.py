"""Gears with thin webs in three dimensions: compliance against another program."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flankload.bodies.body import Body
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.near_field import mode_norms
from flankload.elasticity.prism import Prism, flank_surface, prism_compliance
from flankload.elasticity.prism.axial_basis import mode_norms_z
from flankload.elasticity.prism.flank_potential import projected_potential
from tests.support.ring_bodies import gear

WIDTH, WEB = 14.0, (-2.1, 2.1)
#: Twist of a base helix of 13.8 degrees, rad/mm.
TWIST = 0.0097
#: Compliance <mode, displacement>/D² in um/kN of all of a gear of 12 teeth with a web of 0.3 of its
#: width below a rim of 6 mm, one tooth loaded; CalculiX 2.20, 16 128 elements C3D20 (12 layers
#: over the width, the narrowest 0.7 mm beside the web) on the same plane elements.
REFERENCE = {
    0.0: {"mean": 5.12927, "z1": 4.20639, "neighbour mean": 2.68463, "neighbour z1": 1.06785},
    TWIST: {"mean": 6.66381, "z1": 4.53856, "neighbour mean": 3.68493, "neighbour z1": 1.11014},
}
#: By degree of displacements and of cuts.
LIMITS = {(8, 4): 0.004, (14, 14): 0.0005}
#: The same for z1 of the neighbour, four times smaller.
NEIGHBOUR_Z1 = {(8, 4): 0.008, (14, 14): 0.0005}


@cache
def _webbed() -> Body:
    keys = {"tip_diameter_mm": 64.35, "bore_diameter_mm": 15.0, "web_width_mm": 4.2}
    spec = gear(teeth=12, rim_thickness_mm=6.0, **keys)
    return build_involute_body(spec, "body_1", flank_element_mm=2.25, regions=("web",))


@pytest.mark.parametrize("degrees", LIMITS)
@pytest.mark.parametrize("twist", REFERENCE)
def test_a_thin_web_yields_as_in_another_program(twist: float, degrees: tuple[int, int]) -> None:
    body, n_s, (degree, cut_degree) = _webbed(), 5, degrees
    prism = Prism(
        (-0.5 * WIDTH, 0.5 * WIDTH), twist, degree, 2, cut_degree, regions=(("web", WEB),)
    )
    surface = flank_surface(body, prism)
    response = prism_compliance(body, prism, n_modes=n_s).smooth.copy()
    kernel = (1 - body.material.poisson_ratio**2) / (np.pi * body.material.young_modulus_MPa)
    norms = np.outer(
        mode_norms(body.mode_range_mm, n_s), mode_norms_z(WIDTH, 2) / surface.cos_base_helix
    ).ravel()
    response[0] += kernel * projected_potential(surface, n_s, 2) / np.outer(norms, norms)
    own, one = (1e6 * np.diag(response[tooth]) for tooth in range(2))
    values = {"mean": own[0], "z1": own[1], "neighbour mean": one[0], "neighbour z1": one[1]}
    for name, value in REFERENCE[twist].items():
        limit = (NEIGHBOUR_Z1 if name == "neighbour z1" else LIMITS)[degrees]
        assert values[name] == pytest.approx(value, rel=limit), name
