"""The knobs that a scene leaves open, and why it does not leave the others."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from flankload.bodies import SPLINE_PART
from flankload.bodies.imported.given import ModalCompliance
from flankload.mechanisms.flank_pair.assembly import bodies_of
from flankload.scene import Belt, Chain, ComplianceBody, MeshBody
from flankload.scene.discretization import DEFAULT, elements_for_modes

if TYPE_CHECKING:
    from flankload.bodies import Body
    from flankload.scene import BodySpec, Scene

#: Pressure modes that a scene may name.
LEAST_MODES, MOST_MODES = 3, 12
#: Knobs, by the names of `Setting`, and the source of errors that each of them answers for.
SOURCES = {
    "flank_element_mm": "elements",
    "modes": "modes",
    "strips_per_half_width": "strips",
    "positions": "positions",
}
#: Elements of the default length that modes are weighed with: nine of ten drawn gears and splines
#: have as many along the flank; of gears a sixth more, since their pressures are as good with a
#: sixth less than `elements_for_modes`.
FLANK_ELEMENTS = {"gears": 9.5, "splines": 10.5}
#: As many modes are better than fewer on any elements.
ANYWHERE = 4
#: Keys of [positions] that say where a pair is looked at.
PLACES = ("count", "angles_deg", "adaptive", "tolerance", "max_count")


@dataclass(frozen=True)
class Knobs:
    """What steering may decide on.

    Attributes
    ----------
    kind : {"gears", "splines", "cams", "belts"}
        Whose laws hold.
    element_mm : float or None
        Length of elements along the flank by default; None where no scene can say it.
    elements : float
        Elements along the flank by default; infinite where modes ask for no more of them.
    part : float
        Length of the elements that the scene names, over the default; 1 where it names none.
    most_modes : int
    modes : int
        Those that the scene names, or the default.
    strips : float
        The same.
    closed : dict of str to str
        Knobs that are not open, by the names of `SOURCES`, and why.
    states : int
        Positions times torques of the scene as it stands.
    """

    kind: str
    element_mm: float | None
    elements: float
    part: float
    most_modes: int
    modes: int
    strips: float
    closed: dict[str, str]
    states: int

    def is_open(self, knob: str) -> bool:
        """Whether steering may turn it."""
        return knob not in self.closed

    def bears(self, part: float, modes: int) -> bool:
        """Whether elements of that length, over the default, bear so many modes."""
        return modes <= ANYWHERE or self.elements / part > elements_for_modes(modes) - 1


def knobs_of(scene: Scene) -> Knobs:
    """What a scene leaves open; bodies are built only where their files decide.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Knobs
    """
    kind = _kind(scene)
    closed = _named(scene)
    if kind == "chains":
        for knob in ("flank_element_mm", "modes", "strips_per_half_width"):
            closed.setdefault(knob, "a chain has no such knob")
    element_mm, most = _elements(scene, kind)
    if element_mm is None:
        closed.setdefault("flank_element_mm", "meshes and compliances from files are what they are")
    if kind == "belts":
        closed |= dict.fromkeys(("modes", "strips_per_half_width"), "a belt has no such knob")
        closed.setdefault("positions", "a belt has as many even ones as positions.count says")
    if scene.effects.near_field == "nodes":
        nodes = "effects.near_field = 'nodes' goes by the nodes of the flank"
        closed |= {"modes": nodes, "flank_element_mm": nodes}
    if most <= LEAST_MODES:
        closed.setdefault("modes", "the files hold no more of them")
    if scene.effects.contact == "lumped":
        closed["strips_per_half_width"] = "lumped contact lays no strips"
    if kind in ("cams", "chains") or scene.positions.count == 1:
        closed.setdefault("positions", "even ones do")
    accuracy = scene.accuracy
    named = accuracy.flank_element_mm
    return Knobs(
        kind=kind,
        element_mm=element_mm,
        elements=inf if element_mm is None else FLANK_ELEMENTS.get(kind, inf),
        part=1.0 if named is None or element_mm is None else named / element_mm,
        most_modes=most,
        modes=min(most, accuracy.modes or DEFAULT.modes),
        strips=accuracy.strips_per_half_width or DEFAULT.grid.strips_per_half_width,
        closed=closed,
        states=_positions(scene) * sum(torque > 0 for torque in scene.torques_Nm),
    )


def default_length(spec: BodySpec, body: Body | None = None) -> float:
    """Length of elements along the flank by default, mm.

    Parameters
    ----------
    spec : table of a body
    body : Body, optional
        The same, built; needed where the table names no module.

    Returns
    -------
    float
    """
    module = getattr(spec, "module_mm", None)
    if module is not None:
        part = SPLINE_PART if getattr(spec, "kind", "").startswith("spline") else 1.0
        return float(DEFAULT.flank_element_parts * module * part)
    assert body is not None
    assert body.mesh is not None
    low, high = body.mode_range_mm
    return float((high - low) / body.mesh.flank_elements)


def most_modes(spec: BodySpec, body: Body | None) -> int:
    """Modes that a body's file allows: as many as it holds, or as its elements bear.

    Parameters
    ----------
    spec : table of a body
    body : Body or None
        The same, built; needed where it comes from a file.

    Returns
    -------
    int
    """
    if body is None:
        return MOST_MODES
    if isinstance(body.given, ModalCompliance):
        return int(body.given.smooth.shape[1])
    nodes = body.given or (body.mesh if isinstance(spec, MeshBody) else None)
    if nodes is None:
        return MOST_MODES
    asked = range(3, MOST_MODES + 1)
    return max((m for m in asked if elements_for_modes(m) <= nodes.flank_elements), default=2)


def _kind(scene: Scene) -> str:
    if isinstance(scene.body_2, Chain):
        return "chains"
    if isinstance(scene.body_2, Belt):
        return "belts"
    if scene.body_1.kind == "spline_shaft":
        return "splines"
    return "cams" if scene.body_2.kind == "cam" else "gears"


def _named(scene: Scene) -> dict[str, str]:
    """Knobs that stand in the scene."""
    closed = {}
    for knob in ("flank_element_mm", "modes", "strips_per_half_width"):
        if getattr(scene.accuracy, knob) is not None:
            closed[knob] = f"accuracy.{knob} is named"
    for key in PLACES:
        if f"positions.{key}" in scene.named_knobs:
            closed["positions"] = f"positions.{key} is named"
            break
    return closed


def _elements(scene: Scene, kind: str) -> tuple[float | None, int]:
    """Length of elements by default, and the most modes."""
    if kind == "chains":
        return None, 0
    if kind == "belts":
        from flankload.mechanisms.belt.drive import default_element_mm

        return default_element_mm(scene), 0
    lengths, modes = [], [MOST_MODES]
    for z, spec in enumerate((scene.body_1, scene.body_2)):
        if spec.rigid:
            continue
        from_file = isinstance(spec, MeshBody | ComplianceBody)
        body = None
        if from_file or not hasattr(spec, "module_mm"):
            body = bodies_of(scene, DEFAULT, (z,))[0]
        if not from_file:
            lengths.append(default_length(spec, body))
        modes.append(most_modes(spec, body if from_file else None))
    return min(lengths, default=None), min(modes)


def _positions(scene: Scene) -> int:
    positions = scene.positions
    if positions.angles_deg is not None:
        return len(positions.angles_deg)
    return positions.count * (positions.pitches if isinstance(positions.pitches, int) else 1)
