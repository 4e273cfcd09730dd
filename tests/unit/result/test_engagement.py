"""How the bodies of a result touch: the words, tables and plots that follow from it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from flankload.plot import DRAWINGS, PICTURES
from flankload.plot.positions import label_positions, pair_curve
from flankload.result import Result
from flankload.result.engagement import FollowerOnCam, TeethAllAround, TeethInMesh
from tests.support.made_up_result import SITES, made_up_result

COUNT = 8
TURN = 2 * math.pi
GEARS = made_up_result(count=COUNT)
OVER_SITES = ("site_force_N", "peak_pressure_MPa", "corner_contact")
KINDS = {
    "gears": {},
    "spline": {"whole_circle": True, "sites": SITES + 1},
    "cam": {
        "follower_angle_rad": np.linspace(0.0, 1.0, COUNT),
        "position_rad": TURN * np.arange(COUNT) / COUNT,
        "period_rad": TURN,
        "sites": SITES[1:2],
        **{name: getattr(GEARS, name)[:, 1:2] for name in OVER_SITES},
    },
}


def result_of(kind: str) -> Result:
    return made_up_result(count=COUNT, **KINDS[kind])


@pytest.mark.parametrize(
    ("kind", "engagement", "title", "label"),
    [
        ("gears", TeethInMesh, "over one pitch of 22.5 deg", "angle of body 1 in degrees (one"),
        ("spline", TeethAllAround, "over one pitch of 22.5 deg", "angle of body 1 in degrees (one"),
        ("cam", FollowerOnCam, "over one turn of the cam", "cam angle in degrees"),
    ],
)
def test_words_follow_from_the_engagement(
    kind: str, engagement: type, title: str, label: str
) -> None:
    result = result_of(kind)
    assert type(result.engagement) is engagement
    assert result.table().splitlines()[0].endswith(title)
    axes = Figure().add_subplot()
    label_positions(axes, result)
    assert axes.get_xlabel().startswith(label)
    assert ("one pitch" in axes.get_xlabel()) == (kind != "cam")


@pytest.mark.parametrize("kind", KINDS)
def test_every_plot_of_an_engagement_exists(kind: str) -> None:
    result = result_of(kind)
    names = result.engagement.pictures(result)
    assert {*names} <= {*PICTURES} & {*DRAWINGS}
    assert ("transmission_error_spectrum" in names) == (kind == "gears")


@pytest.mark.parametrize("kind", KINDS)
def test_after_a_period_a_pair_is_at_the_place_of_another(kind: str) -> None:
    """Regression: the last tooth of a spline was drawn without load at the end of the period."""
    result = result_of(kind)
    after = {"gears": (1, 2, None), "spline": (1, 2, 0), "cam": (0,)}[kind]
    assert tuple(result.site_after_period(s) for s in range(len(after))) == after
    for s, following in enumerate(after):
        _, force = pair_curve(result, result.site_force_N, s, closing=-1.0)
        assert force[-1] == (-1.0 if following is None else result.site_force_N[0, following])


def test_force_of_a_site_is_drawn_at_the_centre_of_its_load() -> None:
    result = result_of("gears")
    table, site = result.pairs(2), result.sites[1]
    own = table.site == site
    angle, radius, direction = result.engagement.drawn_force(result, 2, 1)
    force = table.force_N[own]
    for place, column in zip(
        (radius * math.cos(angle), radius * math.sin(angle)), (table.x_mm, table.y_mm), strict=True
    ):
        assert place == pytest.approx(np.average(column[own], weights=force))
    normal = math.atan2(table.normal_y[own][0], table.normal_x[own][0])
    assert direction == pytest.approx(normal)
