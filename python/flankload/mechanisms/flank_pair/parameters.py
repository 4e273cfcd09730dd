"""Discretization parameters of two bodies with flanks."""

from __future__ import annotations

from math import ceil, inf
from typing import TYPE_CHECKING

from flankload.bodies import SPLINE_ELEMENT_FACTOR
from flankload.bodies.imported.compliance import ModalCompliance
from flankload.mechanisms.flank_pair.notes import ELEMENT_RESERVE
from flankload.mechanisms.parameters import ANYWHERE, SOURCES, Parameters, lengths, named, rounded
from flankload.mechanisms.scene_bodies import PAIR, bodies_of, node_spacing_of
from flankload.pairing.slices import SLICES as DEFAULT_SLICES
from flankload.scene.accuracy import Accuracy
from flankload.scene.axial import DEGREES_ABOVE_LOAD, degrees_of
from flankload.scene.discretization import DEFAULT, default_grid, elements_for_modes
from flankload.scene.effects import effects_of
from flankload.scene.steps import DEGREE, ELEMENTS, LOAD_DEGREE, MODES, SLICES, STEPS, STRIPS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies import Body
    from flankload.mechanisms.parameters import Powers, Values
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import BodySpec, Scene

#: Range of the number of pressure modes that a scene can name.
LEAST_MODES, MOST_MODES = (int(STEPS[MODES].refined[end]) for end in (0, -1))
#: Elements of the default length on a flank of usual height, which is two modules of a gear.
FLANK_ELEMENTS = 9.0
#: Orders of the errors in the parameters. Polynomials of degree n change within 1/n² of the ends of
#: a flank, so elements have to resolve more of them.
FLANK_POWERS: dict[str, Powers] = {
    "elements": {ELEMENTS: STEPS[ELEMENTS].order, MODES: 4.0},
    **{SOURCES[name]: {name: STEPS[name].order} for name in (MODES, STRIPS, LOAD_DEGREE, SLICES)},
}
#: Elements of cams: half the length left 0.3 to 0.9 of the estimated error (4 cams).
CAM_POWERS: Mapping[str, Powers] = FLANK_POWERS | {"elements": {ELEMENTS: 1.0}}
#: Reason for too few modes.
FEW_MODES = "meshes and compliances from files allow no more modes"


def parameters_of_flanks(scene: Scene, parts: Parts | None = None) -> Parameters:
    """Discretization parameters of a scene; bodies are built only if their files determine these.

    Built bodies are added to `parts`, those of earlier runs.
    """
    fixed, accuracy = named(scene), scene.accuracy
    length, most = _elements_of(scene, parts)
    if length is None:
        fixed.setdefault(ELEMENTS, "meshes and compliances from files are fixed")
    if scene.effects.near_field == "nodes":
        nodes = "determined by the nodes of the flank with effects.near_field = 'nodes'"
        fixed |= {MODES: nodes, ELEMENTS: nodes}
    if most <= LEAST_MODES:
        fixed.setdefault(MODES, "the files contain no more modes")
    if scene.effects.contact == "lumped":
        fixed[STRIPS] = "lumped contact has no strips"
    cam = not (scene.is_drive or scene.body_2.has_teeth)
    if cam or scene.positions.count == 1:
        fixed.setdefault("positions", "equally spaced positions suffice")
    modes = accuracy.modes or DEFAULT.modes
    flank_mm = inf if length is None or cam else FLANK_ELEMENTS * length
    named_mm = accuracy.flank_element_mm
    while named_mm is not None and MODES not in fixed and modes > ANYWHERE:
        if elements_for_modes(modes) * named_mm <= flank_mm:
            break
        modes -= 1  # named elements resolve no more
    values: Values = {
        MODES: min(most, modes),
        STRIPS: accuracy.strips_per_half_width or default_grid(scene).strips_per_half_width,
    }
    steps: dict[str, tuple[float, ...]] = {
        MODES: tuple(count for count in STEPS[MODES].refined if count <= most),
        STRIPS: STEPS[STRIPS].refined,
    }
    if length is not None:
        values[ELEMENTS] = named_mm or rounded(length)
        steps[ELEMENTS] = lengths(scene, length)
    if effects_of(scene).three_dimensions:
        _add_axial(scene, values, steps)
    return Parameters(
        values,
        fixed,
        {name: finer for name, finer in steps.items() if name not in fixed},
        CAM_POWERS if cam else FLANK_POWERS,
        explicit=() if MODES in fixed else (MODES,),
        flank_mm=flank_mm,
        ends={} if most >= MOST_MODES else {MODES: FEW_MODES},
        first=_first(scene, values, fixed, flank_mm),
        element_mm=length,
        most_modes=most,
        nodes_mm=node_spacing_of(scene, parts) if scene.effects.near_field == "nodes" else None,
    )


def _first(scene: Scene, values: Values, fixed: Mapping[str, str], flank_mm: float) -> Values:
    """Coarser values of open parameters: fewest strips, longest elements that resolve the modes.

    In the plane, `ANYWHERE` modes for the default tolerance, more for smaller ones by their order.
    """
    found: Values = {}
    modes = values[MODES]
    if MODES not in fixed and not effects_of(scene).three_dimensions:
        part = scene.accuracy.tolerance / Accuracy().tolerance
        few = ceil(ANYWHERE * part ** (1.0 / STEPS[MODES].order))
        found[MODES] = modes = min(modes, max(ANYWHERE, few))
    if STRIPS in values and STRIPS not in fixed:
        found[STRIPS] = min(values[STRIPS], STEPS[STRIPS].refined[0])
    if ELEMENTS in values and ELEMENTS not in fixed:
        length, wanted = values[ELEMENTS], elements_for_modes(int(values[MODES]))
        if wanted * length <= flank_mm:
            fewer = ELEMENT_RESERVE * wanted / elements_for_modes(int(modes))
            # without a requirement (cams) the error is of first order
            part = STEPS[ELEMENTS].refined[0] if flank_mm == inf else fewer
            found[ELEMENTS] = rounded(part * length)
    return found


def _add_axial(scene: Scene, values: Values, steps: dict[str, tuple[float, ...]]) -> None:
    """Add the degrees along the axis and the slices of three-dimensional bodies."""
    accuracy = scene.accuracy
    if scene.effects.contact == "lumped":
        del values[STRIPS]
    values[DEGREE], values[LOAD_DEGREE] = degrees_of(accuracy)
    values[SLICES] = accuracy.slices or DEFAULT_SLICES
    most = inf if accuracy.axial_degree is None else accuracy.axial_degree - DEGREES_ABOVE_LOAD
    steps[LOAD_DEGREE] = tuple(degree for degree in STEPS[LOAD_DEGREE].refined if degree <= most)
    steps[SLICES] = STEPS[SLICES].refined


def _elements_of(scene: Scene, parts: Parts | None = None) -> tuple[float | None, int]:
    """Elements of two bodies with flanks.

    Returns
    -------
    float or None
        Default length along the flank, mm; None if files define all elements or bodies are rigid.
    int
        Largest number of pressure modes.
    """
    found, modes = [], [MOST_MODES]
    for name in PAIR:
        spec: BodySpec = getattr(scene, name)
        if spec.rigid:
            continue
        from_file = spec.from_file
        body = None
        if from_file or not hasattr(spec, "module_mm"):
            body = bodies_of(scene, DEFAULT, (name,), parts=parts)[0]
        if not from_file:
            found.append(_default_length(spec, body))
        modes.append(_most_modes(spec, body if from_file else None))
    return min(found, default=None), min(modes)


def _default_length(spec: BodySpec, body: Body | None = None) -> float:
    """Default length of elements along the flank, mm; a body whose table has no module is built."""
    module = getattr(spec, "module_mm", None)
    if module is not None:
        part = SPLINE_ELEMENT_FACTOR if getattr(spec, "kind", "").startswith("spline") else 1.0
        return float(DEFAULT.flank_element_parts * module * part)
    assert body is not None
    assert body.mesh is not None
    low, high = body.mode_range_mm
    return float((high - low) / body.mesh.flank_elements)


def _most_modes(spec: BodySpec, body: Body | None) -> int:
    """Largest number of modes of a body; one from a file is built."""
    if body is None:
        return MOST_MODES
    if isinstance(body.imported, ModalCompliance):
        return int(body.imported.smooth.shape[1])
    nodes = body.imported or (body.mesh if spec.from_file else None)
    if nodes is None:
        return MOST_MODES
    asked = range(LEAST_MODES, MOST_MODES + 1)
    return max((m for m in asked if elements_for_modes(m) <= nodes.flank_elements), default=2)
