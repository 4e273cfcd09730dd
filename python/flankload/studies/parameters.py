"""Discretization parameters of a scene, with their orders of convergence and fixed values.

Each kind of drive supplies one `Parameters`; the tolerance control is independent of the kind.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING

from flankload.bodies import SPLINE_ELEMENT_FACTOR
from flankload.bodies.imported.compliance import ModalCompliance
from flankload.mechanisms.belt.drive import default_element_mm
from flankload.mechanisms.flank_pair.assembly import bodies_of
from flankload.mechanisms.flank_pair.notes import ELEMENT_RESERVE
from flankload.pairing.slices import SLICES as DEFAULT_SLICES
from flankload.scene.axial import DEGREES_ABOVE_LOAD, degrees_of
from flankload.scene.discretization import DEFAULT, default_grid, elements_for_modes
from flankload.scene.effects import effects_of
from flankload.scene.steps import DEGREE, ELEMENTS, LOAD_DEGREE, MODES, SLICES, STEPS, STRIPS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies import Body
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import BodySpec, Scene

    Values = dict[str, float]
    Powers = Mapping[str, float]

#: Parameters on which compliances depend.
OF_ELEMENTS = (ELEMENTS, MODES, LOAD_DEGREE, DEGREE)
#: Parameters by the names of `NamedDiscretization`, and the error source that each controls.
SOURCES = {
    ELEMENTS: "elements",
    MODES: "modes",
    LOAD_DEGREE: "axial",
    SLICES: "slices",
    STRIPS: "strips",
    "positions": "positions",
}
#: Range of the number of pressure modes that a scene can name.
LEAST_MODES, MOST_MODES = (int(STEPS[MODES].refined[end]) for end in (0, -1))
#: Shortest elements relative to the default: half the length takes four times the work, so the last
#: halving is reserved for tolerances below FINE.
LEAST_PART, FINE = 0.2, 1e-3
#: Elements of the default length on a flank of usual height, which is two modules of a gear.
FLANK_ELEMENTS = 9.0
#: From this number of modes on, more modes are not better on any elements.
ANYWHERE = 4
#: Orders of the errors in the parameters. Polynomials of degree n change within 1/n² of the ends of
#: a flank, so elements have to resolve more of them.
FLANK_POWERS: dict[str, Powers] = {
    "elements": {ELEMENTS: STEPS[ELEMENTS].order, MODES: 4.0},
    **{SOURCES[name]: {name: STEPS[name].order} for name in (MODES, STRIPS, LOAD_DEGREE, SLICES)},
}
#: Elements of cams: half the length left 0.3 to 0.9 of the estimated error (4 cams).
CAM_POWERS: Mapping[str, Powers] = FLANK_POWERS | {"elements": {ELEMENTS: 1.0}}
#: Near the re-entrant corners of a belt's teeth errors decrease to 0.6 when lengths are halved.
BELT_POWERS: Mapping[str, Powers] = {"elements": {ELEMENTS: 0.75}}
#: Orders of the work in the parameters: elements, and states.
ELEMENTS_WORK: Powers = {ELEMENTS: -2.0, DEGREE: 2.0}
STATES_WORK: Powers = {STRIPS: 1.0, SLICES: 2.0}
#: The same of the seconds of a state: contacts are sought without cells.
STATES_SECONDS: Powers = {STRIPS: 0.5, SLICES: 2.0}
#: With finite influence coefficients: each two pairs have their own.
FINITE_SECONDS: Powers = {STRIPS: 2.0}
#: Order of the number of cells.
CELLS_WORK: Powers = {STRIPS: 1.0, SLICES: 1.0}
#: Keys of [positions] that set the positions of a drive.
PLACES = ("count", "angles_deg", "adaptive", "tolerance", "max_count")
FEW_MODES = "meshes and compliances from files allow no more modes"
#: Reason for slow convergence with finer steps, added to another reason.
CORNERS = "; contact on sharp corners, near which convergence is slow (a warning names them)"
BELT_CORNERS = (
    "; near the corners of teeth and lands, errors decrease more slowly than the element length"
)


@dataclass(frozen=True)
class Parameters:
    """Discretization parameters of a scene.

    Attributes
    ----------
    values : dict of str to float
        Default values, or those that the scene names.
    fixed : dict of str to str
        Parameters that do not change, with the reason.
    steps : mapping of str to tuple of float
        Finer values of the other parameters, in order.
    powers : mapping of str to mapping
        By error source: the powers of the parameters to which it is proportional.
    explicit : tuple of str
        Parameters that a run always names, even at their initial values: by default it may choose
        others.
    flank_mm : float
        Length of a flank whose elements must resolve the modes; infinite if modes set no
        requirement.
    ends : mapping of str to str
        Specific reason why no finer steps exist.
    slow : str
        Cause of slow convergence: added to a reason if pairs touch at sharp corners.
    always_slow : bool
        Whether it is added in every case.
    has_pressures : bool
    first : dict of str to float
        Coarser values of open parameters, with which the first run begins.
    element_mm : float or None
        Default length of elements; None without elements that a scene can name.
    """

    values: Values
    fixed: dict[str, str]
    steps: Mapping[str, tuple[float, ...]]
    powers: Mapping[str, Powers]
    explicit: tuple[str, ...] = ()
    flank_mm: float = inf
    ends: Mapping[str, str] = field(default_factory=dict)
    slow: str = CORNERS
    always_slow: bool = False
    has_pressures: bool = True
    first: Values = field(default_factory=dict)
    element_mm: float | None = None

    def finer(self, values: Values, source: str) -> Values | None:
        """The next step of the parameter that controls an error source.

        Parameters
        ----------
        values : dict of str to float
        source : str

        Returns
        -------
        dict or None
            None at the end of its steps, and for fixed parameters. More modes are combined with
            elements that resolve them, and higher degrees of the pressure modes along the axis with
            higher ones of the displacements.
        """
        name = next((name for name, of in SOURCES.items() if of == source), "")
        towards = -1.0 if name == ELEMENTS else 1.0
        ahead = [x for x in self.steps.get(name, ()) if towards * (x - values[name]) > 0]
        if not ahead:
            return None
        changed = {**values, name: ahead[0]}
        if name == LOAD_DEGREE:
            changed[DEGREE] = max(values[DEGREE], ahead[0] + DEGREES_ABOVE_LOAD)
        return self._bearing(changed) if name == MODES else changed

    def _bearing(self, values: Values) -> Values | None:
        """Element length that resolves the modes; None if it is not available."""
        if ELEMENTS not in values or values[MODES] <= ANYWHERE:
            return values
        longest = _rounded(self.flank_mm / elements_for_modes(int(values[MODES])))
        if values[ELEMENTS] <= longest:
            return values
        can = self.steps.get(ELEMENTS, (inf,))[-1] <= longest
        return {**values, ELEMENTS: longest} if can else None


def relative(powers: Powers, values: Values, others: Values) -> float:
    """Ratio of a product of powers of the parameters at some values to that at other values."""
    found = 1.0
    for name, power in powers.items():
        if name in values:
            found *= (values[name] / others[name]) ** power
    return found


def parameters_of(scene: Scene, parts: Parts | None = None) -> Parameters:
    """Discretization parameters of a scene; bodies are built only if their files determine these.

    Parameters
    ----------
    scene : Scene
    parts : Parts, optional
        Bodies of earlier runs, to which built ones are added.

    Returns
    -------
    Parameters
    """
    return KINDS.get(scene.body_2.kind, _of_flanks)(scene, parts)


def _of_chain(scene: Scene, parts: Parts | None) -> Parameters:
    fixed = _named(scene)
    fixed.setdefault("positions", "equally spaced positions suffice")
    return Parameters({}, fixed, {}, {}, has_pressures=False)


def _of_belt(scene: Scene, parts: Parts | None) -> Parameters:
    fixed, length = _named(scene), default_element_mm(scene)
    fixed.setdefault("positions", "a belt has positions.count equally spaced positions")
    if length is None:
        fixed.setdefault(ELEMENTS, "rigid flanks have no elements")
    return Parameters(
        {} if length is None else {ELEMENTS: scene.accuracy.flank_element_mm or _rounded(length)},
        fixed,
        {} if ELEMENTS in fixed or length is None else {ELEMENTS: _lengths(scene, length)},
        BELT_POWERS,
        slow=BELT_CORNERS,
        always_slow=True,
        has_pressures=False,
        element_mm=length,
    )


def _of_flanks(scene: Scene, parts: Parts | None) -> Parameters:
    fixed, accuracy = _named(scene), scene.accuracy
    length, most = elements_of(scene, parts)
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
        values[ELEMENTS] = named_mm or _rounded(length)
        steps[ELEMENTS] = _lengths(scene, length)
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
        first=_first(values, fixed, flank_mm),
        element_mm=length,
    )


def _first(values: Values, fixed: Mapping[str, str], flank_mm: float) -> Values:
    """Coarser values of open parameters: fewest strips, longest elements that resolve the modes."""
    found: Values = {}
    if STRIPS in values and STRIPS not in fixed:
        found[STRIPS] = min(values[STRIPS], STEPS[STRIPS].refined[0])
    if ELEMENTS in values and ELEMENTS not in fixed:
        length = values[ELEMENTS]
        if elements_for_modes(int(values[MODES])) * length <= flank_mm:
            # without a requirement (cams) the error is of first order
            part = STEPS[ELEMENTS].refined[0] if flank_mm == inf else ELEMENT_RESERVE
            found[ELEMENTS] = _rounded(part * length)
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


#: By kind of body 2; flank pairs otherwise.
KINDS = {"chain": _of_chain, "belt": _of_belt}


def _named(scene: Scene) -> dict[str, str]:
    """Parameters that the scene names."""
    fixed = {
        name: f"accuracy.{name} is set"
        for name in (ELEMENTS, MODES, STRIPS, LOAD_DEGREE, SLICES)
        if getattr(scene.accuracy, name) is not None
    }
    places = [key for key in PLACES if f"positions.{key}" in scene.named_discretization_keys]
    if places:
        fixed["positions"] = f"positions.{places[0]} is set"
    return fixed


def _lengths(scene: Scene, default_mm: float) -> tuple[float, ...]:
    """Element lengths of refinements, the longest first."""
    least = 0.0 if scene.accuracy.tolerance < FINE else LEAST_PART
    parts = STEPS[ELEMENTS].refined
    return tuple(_rounded(part * default_mm) for part in parts if part >= least)


def _rounded(length_mm: float) -> float:
    return float(f"{length_mm:.3g}")


def elements_of(scene: Scene, parts: Parts | None = None) -> tuple[float | None, int]:
    """Elements of two bodies with flanks.

    Returns
    -------
    float or None
        Default length along the flank, mm; None if files define all elements or bodies are rigid.
    int
        Largest number of pressure modes.
    """
    lengths, modes = [], [MOST_MODES]
    for z, spec in enumerate((scene.body_1, scene.body_2)):
        if spec.rigid:
            continue
        from_file = spec.from_file
        body = None
        if from_file or not hasattr(spec, "module_mm"):
            body = bodies_of(scene, DEFAULT, (z,), parts=parts)[0]
        if not from_file:
            lengths.append(_default_length(spec, body))
        modes.append(_most_modes(spec, body if from_file else None))
    return min(lengths, default=None), min(modes)


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
