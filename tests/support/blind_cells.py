"""Seeded random pairs of external gears, and a reference with cells over whole flanks.

The reference has its own pairing (polar angles interpolated over radius) and its own influence
coefficients (numpy), and places equal cells over all flanks that could touch: it does not use
points of least gap, contact widths or corners.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from math import acos, cos, pi, radians, sin, sqrt, tan

import numpy as np

import flankload as fl
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.near_field import mode_values
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.reuse import made_once
from flankload.scene.discretization import Grid
from tests.support.cells_near_field import cells_near_field
from tests.support.random_scenes import ANGLE, STEEL, inv
from tests.support.solving import PARTS


def draw(rng: np.random.Generator) -> dict | None:
    """One scene; None if the drawn keys give no pair (pointed, or a contact ratio out of range)."""
    teeth = [int(rng.integers(8, 30)), int(rng.integers(8, 121))]
    module, working = rng.uniform(1, 10), radians(rng.uniform(17, 27))
    pitch_radius = [module * z / 2 * cos(ANGLE) / cos(working) for z in teeth]
    distance, backlash = sum(pitch_radius), module * rng.uniform(0.005, 0.06)
    filled = (2 * pi * pitch_radius[0] - teeth[0] * backlash) / (2 * pitch_radius[0])
    total = (filled - pi - sum(teeth) * (inv(ANGLE) - inv(working))) / (2 * tan(ANGLE))
    low, high = max(-0.3, total - 0.8), min(0.8, total + 0.3)
    if low >= high:
        return None
    shift = [rng.uniform(low, high)]
    shift.append(total - shift[0])
    dedendum = rng.choice([1.25, 1.25, 1.5])
    root = [module * (z / 2 + x - dedendum) for z, x in zip(teeth, shift, strict=True)]
    base = [module * z / 2 * cos(ANGLE) for z in teeth]
    tip = [distance - r - 0.2 * module for r in reversed(root)]
    bodies, path = {}, -distance * sin(working)
    for k in (0, 1):
        half = (pi / 2 + 2 * shift[k] * tan(ANGLE)) / teeth[k] + inv(ANGLE)
        if tip[k] <= base[k] or 2 * tip[k] * (half - inv(acos(base[k] / tip[k]))) < 0.2 * module:
            return None
        path += sqrt(tip[k] ** 2 - base[k] ** 2)
        body = {"kind": "gear", "teeth": teeth[k], "module_mm": module, "profile_shift": shift[k]}
        body |= {"tip_diameter_mm": 2 * tip[k], "bore_diameter_mm": root[k] * rng.uniform(0.5, 1.6)}
        body |= {"dedendum_factor": dedendum, "fillet_radius_factor": 0.25}
        if rng.random() < 0.4:
            body["tip_relief_um"] = rng.uniform(2, 30)
            body["tip_relief_start_diameter_mm"] = 2 * tip[k] - module * rng.uniform(0.4, 1.6)
            body["tip_relief_shape"] = rng.choice(["linear", "parabolic"])
        if rng.random() < 0.3:
            body["profile_crowning_um"] = rng.uniform(1, 12)
        if rng.random() < 0.5:
            end = rng.choice(["tip_radius_mm", "tip_chamfer_mm"])
            body[str(end)] = module * rng.uniform(0.03, 0.12)
        if rng.random() < 0.2:
            body["pitch_errors_um"] = rng.uniform(-10, 10, teeth[k]).tolist()
        bodies[f"body_{k + 1}"] = body
    if not 1.05 < path / (pi * module * cos(ANGLE)) < 2.3:
        return None
    rho = sin(working) * pitch_radius[0] * pitch_radius[1] / distance
    width, pressure = rng.uniform(5, 60), rng.uniform(500, 1500)
    torque = pressure**2 * pi**2 * rho * STEEL * width * base[0] / 1000  # Hertz, one pair
    return {
        **bodies,
        "pair": {"center_distance_mm": distance, "face_width_mm": width},
        "load": {"torque_Nm": torque * rng.choice([1e-3, 0.1, 1.0, 1.0, 3.0, 10.0])},
        "accuracy": {"estimate": False, "plane": str(rng.choice(["strain", "stress"]))},
    }


@cache
def scenes(seed: int, wanted: int) -> list[dict]:
    """The given number of scenes with a valid pair."""
    found: list[dict] = []
    rng = np.random.default_rng(seed)
    while len(found) < wanted:
        scene = draw(rng)
        if scene is None:
            continue
        try:
            build_bodies(fl.Scene.from_dict(scene))
        except SceneError:
            continue
        found.append(scene)
    return found


class Job:
    """A scene with its finite-element solution, for sweeps at any positions."""

    def __init__(self, scene: dict, angles_deg: tuple[float, ...] | None = None) -> None:
        positions = {"count": 8} if angles_deg is None else {"angles_deg": list(angles_deg)}
        self.scene = fl.Scene.from_dict({**scene, "positions": positions})
        pair = build_bodies(self.scene, parts=PARTS)
        self.pair, self.bodies, self.pairing = pair, pair.bodies, pair.pairing
        options = JobOptions(n_modes=5, plane=self.scene.accuracy.plane)
        self.fields = tuple(
            made_once(partial(flank_compliance, body, options), PARTS) for body in self.bodies
        )
        self.torque = 1000.0 * scene["load"]["torque_Nm"]
        self.width = scene["pair"]["face_width_mm"]
        self.period = pair.pairing.pitch_rad
        curve = self.bodies[1].curve
        s_2 = np.linspace(0.0, curve.length_mm, 20001)
        self.flank_2 = (s_2, curve.point(s_2), curve.tangent(s_2))

    def run(self, position_rad: np.ndarray, **grid: float) -> Sweep:
        (found,) = sweep(
            FlankContact(self.pair, self.fields, replace(Grid(), **grid)),
            np.asarray(position_rad, dtype=float),
            [self.torque],
        )
        return found


@cache
def job(seed: int, wanted: int, k: int) -> Job:
    return Job(scenes(seed, wanted)[k])


def reference(job: Job, position: float, cell: float, rotation: float) -> tuple[float, np.ndarray]:
    """Rotation and force of each site; pairs with a gap well beyond the rotation are omitted."""
    columns: list[np.ndarray] = []
    turns = [t[0] for t in job.pairing.turns(np.array([position]))]
    axis_2 = np.array([job.pairing.center_distance_mm, 0.0])
    s_2, own_points, own_tangents = job.flank_2
    for site in range(job.pairing.sites.size):
        length = job.bodies[0].curve.length_mm
        s_1 = np.arange(length - cell / 2, 0.0, -cell)
        angles = [turns[z] + job.pairing.site_angles_rad[z][site] for z in (0, 1)]
        curve = job.bodies[0].curve.rotated(angles[0])
        p_1, t_1 = curve.point(s_1), curve.tangent(s_1)
        turn = np.array([[cos(angles[1]), sin(angles[1])], [-sin(angles[1]), cos(angles[1])]])
        p_2, t_2 = own_points @ turn + axis_2, own_tangents @ turn
        r_1, r_2 = np.hypot(*p_1.T), np.hypot(*p_2.T)
        facing = slice(np.argmax(r_2), np.argmin(r_2) + 1)
        r, order = r_2[facing], np.argsort(r_2[facing])
        if r.size < 2 or (np.diff(r) > 0).any():
            continue  # a flank far round the gear
        on_both = ((p_1 * t_1).sum(1) > 0.02 * r_1) & (r_1 > r.min()) & (r_1 < r.max())
        r_1, p_1, t_1, s_1 = (x[on_both] for x in (r_1, p_1, t_1, s_1))

        def at(values: np.ndarray, r: np.ndarray = r, order: np.ndarray = order) -> np.ndarray:
            return np.interp(r_1, r[order], values[facing][order])  # noqa: B023

        angle_2 = at(np.unwrap(np.arctan2(p_2[:, 1], p_2[:, 0])))
        gap = np.angle(np.exp(1j * (angle_2 - np.arctan2(p_1[:, 1], p_1[:, 0]))))
        lever_1 = np.abs((p_1 * t_1).sum(1))
        lever_2 = at(np.abs((p_2 * t_2).sum(1)))
        width_2 = cell * lever_1 / lever_2
        lever = (lever_1 + lever_2) / 2
        keep = gap < rotation + 0.2 * abs(rotation)
        rows = (np.full(gap.size, site), s_1, at(s_2), gap, lever_1, lever, 0 * gap + cell, width_2)
        columns.append(np.stack(rows)[:, keep])
    site, s_1, s_2, gap, lever_1, lever, width_1, width_2 = np.concatenate(columns, axis=1)
    matrix = np.zeros((site.size, site.size))
    for z, (s, d) in enumerate(((s_1, width_1), (s_2, width_2))):
        field = job.fields[z]
        low, high = field.modes.range_mm
        end = high if field.modes.tip is None else field.modes.tip.end_mm
        count = field.smooth.shape[1]
        modes = mode_values(np.clip(s, low, end), (low, high), count, tip=field.modes.tip)
        teeth = job.pairing.site_teeth[z][site.astype(int)]
        offset = (teeth[:, None] - teeth[None, :]) % job.bodies[z].teeth
        for t in np.unique(offset):
            matrix += np.where(offset == t, modes @ field.smooth[t] @ modes.T, 0.0)
        for own in (np.flatnonzero(site == j) for j in np.unique(site)):
            size = np.sqrt(d[own, None] * d[None, own])
            matrix[np.ix_(own, own)] += cells_near_field(field, s[own], size)
    matrix /= job.width
    state = fl.solve_contact(
        matrix / lever[:, None], lever_1, gap, job.torque, normal_lever_arms=lever
    )
    force = np.bincount(site.astype(int), state.normal_forces, job.pairing.sites.size)
    return state.rotation, force
