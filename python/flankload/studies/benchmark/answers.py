"""Values of the quantities of a benchmark case: computed here, or given by another program."""

from __future__ import annotations

from difflib import get_close_matches
from math import radians, tan
from time import perf_counter
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from flankload.base.arguments import is_number
from flankload.base.files import read_file
from flankload.contact import ContactState, solve_contact, solve_contact_general
from flankload.elasticity.axial_basis import mode_norms_z
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.prism import Prism, flank_surface
from flankload.elasticity.prism.flank_potential import projected_potential
from flankload.errors import SceneError, reason_of
from flankload.mechanisms.registry import mechanism_of
from flankload.result.stage import StageLoads
from flankload.result.train import TwoMeshes
from flankload.scene import read_scene
from flankload.scene.discretization import DEFAULT
from flankload.scene.refusal import refuse
from flankload.studies.benchmark.case import Case, place_of
from flankload.studies.prepared import solve_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from flankload.result import Result

    #: Value at the indices of an identifier.
    Value = Callable[..., float]

#: Pressure modes along and across the width of a case with compliances.
MODES_S, MODES_Z = 3, 5


class Answers(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Answers of a program: the content of an answer file.

    `program` is its name and version; `values` are by case and identifier, of which any may be
    missing; `seconds` are the elapsed seconds by case, optional.
    """

    program: str
    values: dict[str, dict[str, float]]
    seconds: dict[str, float] = {}


def read_answers(path: Path) -> Answers:
    """Read the answers of a program: JSON, {"program": …, "values": {case: {identifier: value}}}.

    Raises SceneError if the file cannot be read or does not follow the format.
    """
    try:
        found = msgspec.json.decode(read_file(path))
        _check_numbers(path, found)
        return msgspec.convert(found, Answers)
    except OSError as error:
        refuse("file", "a JSON file with answers to read", reason_of(error), path)
    except SceneError:
        raise
    except (ValueError, RecursionError) as error:  # no JSON, or another form
        raise SceneError(file=path, key="answers", expected="answers", found=error) from None


def _check_numbers(path: Path, found: Any) -> None:
    """Refuse a value that is not a number, by its case and identifier."""
    cases = found.get("values") if isinstance(found, dict) else None
    for name, values in cases.items() if isinstance(cases, dict) else ():
        for identifier, value in values.items() if isinstance(values, dict) else ():
            if not is_number(value):
                refuse(f"values.{name}.{identifier}", "a number", repr(value), path)


def check_answers(answers: Answers, cases: Sequence[Case], path: Path) -> None:
    """Refuse answers to cases or quantities that do not exist: they would seem to be missing.

    The cases are all of the set; the path is that of the answers, for the error.
    """
    known = {case.name: list(case.quantities) for case in cases}
    for name, values in answers.values.items():
        _require_known(path, "values", name, list(known))
        for identifier in values:
            _require_known(path, f"values.{name}", identifier, known[name])


def _require_known(path: Path, key: str, name: str, known: list[str]) -> None:
    if name not in known:
        near = get_close_matches(name, known, n=1) or known[:1]
        refuse(key, f"names of the set, such as {near[0]}", name, path)


def answers_of(case: Case, folder: Path) -> tuple[dict[str, float], float]:
    """Solve a case from the folder of all cases: values by identifier, and elapsed seconds.

    Raises SceneError if a quantity is unknown, FlankloadError if there is no solution.
    """
    began = perf_counter()
    if "form" in case.inputs:
        known = _of_contact_problem(case.inputs)
    elif any(place_of(identifier)[0] == "compliance" for identifier in case.quantities):
        known = {"compliance": _compliance(case, folder)}
    else:
        found = solve_scene(read_scene(folder / case.name / "scene.toml"), None, None)
        known = _of_result(found)
    values = {}
    for identifier in case.quantities:
        name, place = place_of(identifier)
        if name not in known:
            refuse("quantities", ", ".join(known), name, folder / case.name / "case.json")
        values[identifier] = known[name](*place)
    return values, perf_counter() - began


def _of_result(result: Result) -> dict[str, Value]:
    """Quantities of a scene: at a position, of a pair, at a place of the face width."""

    sites = result.sites.tolist()

    def of_pair(array: NDArray[Any]) -> Value:
        return lambda p, pair: float(array[int(p), sites.index(int(pair))])

    def of_slice(array: NDArray[Any]) -> Value:
        return lambda p, pair, z: float(
            np.interp(z, result.slice_z_mm, array[int(p), sites.index(int(pair))])
        )

    def mean_line_load(p: float, pair: float, z: float) -> float:
        """Over the length of line loads about z."""
        slices = result.slices
        assert slices is not None
        edges = np.append(slices.z_mm - 0.5 * slices.width_mm, slices.z_mm[-1])
        edges[-1] += 0.5 * slices.width_mm[-1]
        carried = np.append(0.0, np.cumsum(slices.force_N[int(p), sites.index(int(pair))]))
        length = slices.line_load_length_mm
        return float(
            np.diff(np.interp([z - 0.5 * length, z + 0.5 * length], edges, carried))[0] / length
        )

    known: dict[str, Value] = {
        "rotation": lambda p: float(result.rotation_rad[int(p)]),
        "transmission_error": lambda p: float(result.transmission_error_um[int(p)]),
        "single_stiffness": lambda p: float(
            result.stiffness_secant_N_per_um[int(p)] / result.face_width_mm
        ),
        "pair_force": of_pair(result.site_force_N),
        "load_share": of_pair(result.load_share),
        "line_load": of_pair(result.line_load_N_per_mm),
        "peak_pressure": of_pair(result.peak_pressure_MPa),
        "line_load_at": mean_line_load,
        "peak_pressure_at": of_slice(result.slice_peak_pressure_MPa),
    }
    drive = result.drive
    if drive is None:
        known["contact_half_width"] = of_pair(result.contact_half_width_mm)
    elif isinstance(drive, StageLoads):
        known["mesh_load_factor"] = lambda p: float(drive.mesh_load_factor[int(p)])
    elif isinstance(drive, TwoMeshes):
        known["bearing_force"] = lambda p: float(drive.common_force_N[int(p)])
    else:
        known["tension"] = of_pair(drive.tension_behind_N)
    return known


def _of_contact_problem(inputs: Mapping[str, Any]) -> dict[str, Value]:
    """Quantities of a contact problem; the index 0 of a force and of a gap is the only position."""
    if inputs["form"] == "angles":
        names = ("influence_coefficients", "lever_arms", "gap_angles", "torque")
        state = solve_contact(*(inputs[name] for name in names))
    else:
        names = ("compliance", "gaps", "motions", "loads")
        given, rows = (inputs[name] for name in names), inputs["load_rows"]
        state = solve_contact_general(*given, load_rows=rows)
    return {
        "rotation": lambda _: float(state.motions[0]),
        "pair_force": lambda _, i: float(state.normal_forces[int(i)]),
        "gap": lambda _, i: float(state.final_gap_angles[int(i)]),
        "violation": lambda _: _violation(state, inputs),
    }


def _violation(state: ContactState, inputs: Mapping[str, Any]) -> float:
    """Largest error of the equations of the general form, as part of their own size."""
    K, g0, B, R, Q = (
        np.asarray(inputs[name], dtype=float)
        for name in ("compliance", "gaps", "motions", "load_rows", "loads")
    )
    force, motion = state.normal_forces, state.motions
    gap = K @ force + g0 - B @ motion
    size = (np.abs(K) @ np.abs(force) + np.abs(g0) + np.abs(B) @ np.abs(motion)).max()
    wrong = np.where(force > 0.0, np.abs(gap), -gap).max() / size
    tension = -force.min() / np.abs(force).max()
    loads = np.abs(R.T @ force - Q) / (np.abs(R.T) @ np.abs(force))
    return float(max(0.0, wrong, tension, loads.max()))


def _compliance(case: Case, folder: Path) -> Value:
    """Compliance of the pressure modes of body 1 of the scene as a prism, um/kN."""
    scene = read_scene(folder / case.name / "scene.toml")
    body = mechanism_of(scene).build(scene, DEFAULT).bodies[0]
    inputs = case.inputs
    width, helix = inputs["face_width_mm"], radians(inputs["helix_angle_deg"])
    pitch_radius = 0.5 * inputs["module_mm"] * inputs["teeth"]
    prism = Prism((-0.5 * width, 0.5 * width), tan(helix) / pitch_radius)
    found = flank_compliance(body, JobOptions(n_modes=MODES_S, prism=prism))
    surface = flank_surface(body, prism)
    response = found.smooth.copy()
    norms = np.kron(np.diag(surface.products(MODES_S)), mode_norms_z(width, MODES_Z - 1))
    near = 0.5 * found.near.kernel * projected_potential(surface, MODES_S, MODES_Z - 1)
    response[0] += near / np.outer(norms, norms)

    modes = 1e6 * np.einsum("tmm->tm", response)
    return lambda tooth, a, c: float(modes[int(tooth), int(a) * MODES_Z + int(c)])
