"""Natural modes of planetary stages: a published table, symmetry, the stage's own stiffness."""

from math import cos, inf, pi, radians
from types import SimpleNamespace

import numpy as np
import pytest

import flankload as fl
from flankload.analysis.stage_modes import Inertia, StageSystem, Support
from flankload.bodies.mass import mass_of
from flankload.contact.meshes_contact import sweep_meshes
from flankload.contact.stage_stiffness import contact_stiffness
from flankload.errors import SceneError
from flankload.mechanisms.stage.assembly import NAMES, assemble
from flankload.mechanisms.stage.states import compliances_of
from flankload.mechanisms.stage_clock import StageClock
from tests.support.planetary_stages import four, scene_of
from tests.support.stage_paths import StagePaths
from tests.support.stages_with_width import wide
from tests.support.tolerances import ROUND_OFF

#: The table has one decimal.
PRINTED_HZ = 0.1
#: Difference quotients while the cells of a contact follow its width (measured 2e-4).
TANGENT = 1e-3
#: Ratio of rotations without resistance by the same differences (measured 1e-3 at 4 positions).
RATIO = 5e-3
#: Coarse elements and few slices.
WITH_WIDTH = {
    "effects.dimension": 3,
    "accuracy.slices": 6,
    "accuracy.axial_degree": 4,
    "accuracy.load_degree_z": 0,
    "accuracy.flank_element_mm": 1.2,
}
#: Lin and Parker 1999, table 2, three planets.
PUBLISHED_HZ = np.repeat(
    [0, 743.2, 1102.4, 1475.7, 1896.0, 1930.3, 2276.4, 2658.3, 6986.3, 7462.8, 9647.9, 11775.3],
    [1, 2, 2, 1, 2, 1, 2, 1, 2, 1, 2, 1],
)


def springs(paths: StagePaths, stiffness: float) -> np.ndarray:
    """Stiffness of equal springs on all lines of action."""
    n = paths.angles_rad.size
    rows = np.zeros((2 * n, 3 * n + 6))
    rows[:, :3] = paths.sun_rows[:, [1, 2, 0]]
    rows[:, 3:-3] = (paths.planet_rows[:, :, [1, 2, 0]] * [1, 1, -1]).reshape(2 * n, -1)
    rows[:, -3:] = paths.ring_rows[:, [1, 2, 0]]
    return stiffness * rows.T @ rows


def published(count: int) -> StageSystem:
    """Lin and Parker's example, table 1; their moments of inertia are over base radii squared."""
    distance, alpha, sun = 100.0, radians(24.6), 40.0
    planet = distance * cos(alpha) - sun
    ring = distance * cos(alpha) + planet
    angles = 2 * pi * np.arange(count) / count
    paths = StagePaths(angles, (alpha, alpha), (sun, planet, ring))
    data = ((0.4, 0.39, sun), (0.66, 0.61, planet), (2.35, 3.0, ring), (5.43, 6.29, distance))
    bearing = 1e5  # N/mm
    return StageSystem(
        angles_rad=angles,
        center_distance_mm=distance,
        contacts=springs(paths, 5e5),
        pins_N_per_mm=(bearing, bearing),
        inertias=tuple(Inertia(mass, part * (r / 1000) ** 2) for mass, part, r in data),
        supports=(Support(bearing, 0.0), Support(bearing, 1e6 * ring**2), Support(bearing, 0.0)),
    )


def test_the_table_of_lin_and_parker():
    modes = published(3).modes()
    np.testing.assert_allclose([m.frequency_Hz for m in modes], PUBLISHED_HZ, atol=PRINTED_HZ)
    assert all(mode.share == pytest.approx(1.0, abs=ROUND_OFF) for mode in modes)
    single = np.array([mode.kind == "rotational" for mode in modes])
    assert single.tolist() == [list(PUBLISHED_HZ).count(f) == 1 for f in PUBLISHED_HZ]


def test_modes_of_planets_alone_from_four_planets_on():
    """Theirs with four planets: 1808.2, 5963.8, 6981.7 Hz; sun, ring and carrier stay at rest."""
    own = [mode for mode in published(4).modes() if mode.kind == "planet"]
    expected = [1808.2, 5963.8, 6981.7]
    np.testing.assert_allclose([m.frequency_Hz for m in own], expected, atol=PRINTED_HZ)
    for mode in own:
        np.testing.assert_allclose(mode.energy, [0, 1, 0, 0], atol=1e-12)
        # in turn (z_s = 25): orders 4 i turn, odd ones push, the others do neither
        assert mode.orders(25, 10) == (2, 6, 10)
        assert mode.orders(24, 4) == ()


@pytest.mark.parametrize(
    ("floating", "changes"),
    [
        ("sun", {}),
        ("none", {}),
        ("sun", {"stage.pin_tilt_stiffness_Nm_per_mrad": 300, **WITH_WIDTH}),
    ],
)
def test_the_stiffness_is_that_of_the_stage(floating, changes):
    """With all bodies at rest but those of the sweep, its compliance is the sweep's tangent."""
    keys = {"floating": floating, "pin_stiffness_N_per_um": [300, 200]}
    keys["pin_tangential_errors_um"] = [20, 0, 0, 0]
    scene = scene_of(stage=keys, positions={"count": 3}).replace(changes)
    assembly, compliances = compliances_of(
        scene, assemble(scene), StageClock(None, NAMES, 1, {}), {}
    )
    contact, at = assembly.contact(scene, compliances), assembly.position_rad
    [found] = sweep_meshes(contact, at, scene.torques_Nmm)
    for p, stiffness in enumerate(contact_stiffness(contact, found, at)):
        total = stiffness.copy()
        for j in range(contact.pairing.count):
            pin = contact.springs[1 + j, :2, 1 + j, :2]
            own = slice(3 + 3 * j, 5 + 3 * j)
            total[own, own] += np.linalg.inv(pin)
        free = [*([0, 1] if floating == "sun" else []), *range(2, 15)]
        compliance = np.linalg.inv(total[np.ix_(free, free)])
        turn = free.index(2)
        tangent = found.whole.tangent_rad_per_Nmm[p]
        assert compliance[turn, turn] == pytest.approx(tangent, rel=TANGENT)


def test_modes_of_a_stage(monkeypatch):
    """Equal planets: pure modes, translations in pairs; the lowest ones move the sun."""
    monkeypatch.setattr("flankload.mechanisms.stage.modes.POSITIONS", 8)
    scene = scene_of(stage={"pin_stiffness_N_per_um": 300})
    [found] = fl.natural_modes(scene)
    kinds = [mode.kind for mode in found.modes]
    assert [kinds.count(kind) for kind in ("rotational", "translational", "planet")] == [4, 8, 3]
    assert min(mode.share for mode in found.modes) > 1.0 - 1e-6
    pairs = found.frequencies_Hz[np.array(kinds) == "translational"].reshape(-1, 2)
    np.testing.assert_allclose(pairs[:, 0], pairs[:, 1], rtol=1e-6)
    assert len(found.rows()) == 2 + 11
    # a turning carrier with very much inertia is one at rest, but for its own motion
    heavy = scene.replace({"stage.carrier_inertia_kg_m2": 1e6, "stage.sun_mass_kg": 2.0})
    [other] = fl.natural_modes(heavy)
    assert other.frequencies_Hz[0] == 0.0
    shape = other.modes[0].shape
    assert shape[-1] == pytest.approx(shape[2] * 25 / (25 + 59), rel=RATIO)
    turning = [m.frequency_Hz for m in found.modes if m.kind == "rotational"]
    also = [m.frequency_Hz for m in other.modes if m.kind == "rotational"]
    np.testing.assert_allclose(also[1:], turning, rtol=1e-5)
    assert other.frequencies_Hz[1] < found.frequencies_Hz[0]


def test_modes_of_a_stage_with_width(monkeypatch):
    """Frequencies lie between those of plane strain and plane stress, as the stiffness does."""
    monkeypatch.setattr("flankload.mechanisms.stage.modes.POSITIONS", 3)
    keys = {"pin_stiffness_N_per_um": 300, "sun_inertia_kg_m2": 0.001, "planet_mass_kg": 0.25}
    keys |= {"planet_inertia_kg_m2": 1e-4, "sun_mass_kg": 0.6}
    [found] = fl.natural_modes(fl.Scene.from_dict(wide(0.0, stage=keys)))
    plane = scene_of(
        stage={**keys, "planets": 3}, load={"torque_Nm": 450}, effects={"tip_contact": False}
    )
    strain, stress = (
        fl.natural_modes(plane.replace({"accuracy.plane": state}))[0].frequencies_Hz
        for state in ("strain", "stress")
    )
    assert (found.frequencies_Hz < 1.005 * strain).all()
    assert (found.frequencies_Hz > 0.995 * stress).all()


def test_rigid_pins_are_very_stiff_ones():
    system = published(4)
    at_rest = (*system.supports[:2], Support(inf, 0.0))
    stiff, rigid = (
        StageSystem(**{**vars(system), "pins_N_per_mm": pins, "supports": at_rest})
        for pins in ((1e11, 1e11), None)
    )
    slow = [mode.frequency_Hz for mode in rigid.modes()]
    assert len(slow) == 3 + 4 + 3 + 1
    np.testing.assert_allclose(
        [mode.frequency_Hz for mode in stiff.modes()][: len(slow)], slow, rtol=1e-5, atol=1e-2
    )


def test_the_mass_of_a_disc():
    """A polygon of many corners: (1 - (2 pi/k)**2/6) of the circle's area."""
    angles = np.linspace(-pi / 10, pi / 10, 101)
    disc = SimpleNamespace(
        outline=50 * np.column_stack([np.cos(angles), np.sin(angles)]), teeth=10, bore_radius_mm=20
    )
    mass, moment = mass_of(disc, 7850.0, 10.0)
    assert mass == pytest.approx(7850e-9 * 10 * pi * (50**2 - 20**2), rel=1e-5)
    assert moment == pytest.approx(mass * 0.5e-6 * (50**2 + 20**2), rel=1e-5)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"load": {"torque_Nm": [0, 600]}}, "load.torque_Nm: expected a number > 0 for modes"),
        (
            {"stage": {"floating": "carrier"}},
            "stage.carrier_mass_kg: expected a value for modes, with stage.floating = 'carrier'",
        ),
        (
            {"stage": {"pin_clearance_um": 20}},
            "stage.pin_clearance_um: expected nothing for modes, in which planets are on springs",
        ),
    ],
)
def test_refused(changes, line):
    with pytest.raises(SceneError) as caught:
        fl.natural_modes(fl.Scene.from_dict(four(**changes)))
    assert line in str(caught.value)
