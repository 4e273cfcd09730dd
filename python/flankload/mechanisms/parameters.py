"""Discretization parameters of a scene, with their orders of convergence and fixed values.

Each kind of drive supplies its `Parameters`; the tolerance control is independent of the kind.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING

from flankload.scene.axial import DEGREES_ABOVE_LOAD
from flankload.scene.discretization import elements_for_modes
from flankload.scene.steps import DEGREE, ELEMENTS, LOAD_DEGREE, MODES, SLICES, STEPS, STRIPS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.scene import Scene

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
#: Shortest elements relative to the default: half the length takes four times the work, so the last
#: halving is reserved for tolerances below FINE.
LEAST_PART, FINE = 0.2, 1e-3
#: From this number of modes on, more modes are not better on any elements.
ANYWHERE = 4
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
#: Reason for slow convergence with finer steps, added to another reason.
CORNERS = "; contact on sharp corners, near which convergence is slow (a warning names them)"


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
    most_modes : int
        Largest number of pressure modes that a scene can name; 0 without modes.
    nodes_mm : float or None
        Distance of nodes that carry forces, by the contact width; None without such nodes.
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
    most_modes: int = 0
    nodes_mm: float | None = None

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
        longest = rounded(self.flank_mm / elements_for_modes(int(values[MODES])))
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


def named(scene: Scene) -> dict[str, str]:
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


def lengths(scene: Scene, default_mm: float) -> tuple[float, ...]:
    """Element lengths of refinements, the longest first."""
    least = 0.0 if scene.accuracy.tolerance < FINE else LEAST_PART
    parts = STEPS[ELEMENTS].refined
    return tuple(rounded(part * default_mm) for part in parts if part >= least)


def rounded(length_mm: float) -> float:
    """A length with three digits."""
    return float(f"{length_mm:.3g}")
