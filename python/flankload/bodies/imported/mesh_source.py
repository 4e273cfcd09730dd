"""The mesh file of a body: its sets, and errors that name file and key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from flankload.errors import MeshError
from flankload.meshes.defects import PlaneBody, sound_body
from flankload.meshes.io import RawMesh, read_mesh
from flankload.meshes.plane_mesh import circle_through

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from flankload.scene import MeshBody

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Units in which meshes are given by mistake, in mm.
UNITS = {"metres": 1000.0, "inches": 25.4, "centimetres": 10.0, "micrometres": 0.001}
#: Largest ratio, in both directions, of the size of a body and its reference radius; with a given
#: profile, of the two tip radii.
LARGEST_RATIO, LARGEST_TIP_RATIO = 20.0, 3.0
#: Largest distance of the bore's centre from the axis, relative to the bore's radius.
OFF_AXIS = 1e-3


@dataclass(frozen=True)
class MeshSource:
    """The mesh of a body in standard form, and its source.

    Attributes
    ----------
    raw : RawMesh
    body : PlaneBody
    key : str
        "body_1" or "body_2".
    """

    raw: RawMesh
    body: PlaneBody
    key: str

    def refuse(self, name: str, expected: str, found: str) -> NoReturn:
        """Raise an error for one of the body's keys."""
        raise MeshError(
            file=self.raw.file, key=f"{self.key}.{name}", expected=expected, found=found
        )

    def nodes_of(self, name: str, wanted: str) -> Numbers:
        """Nodes of a named set, including middle nodes of the boundary.

        Middle nodes are added to a set that contains only corners; a set that contains whole edges
        of the boundary is not changed.
        """
        spelt = self.raw.set_name(wanted)
        if spelt is None or not self.raw.sets[spelt].size:
            self.refuse(
                name,
                f"a set named {wanted!r} in the mesh",
                "the sets " + (", ".join(sorted(self.raw.sets)) or "none at all"),
            )
        members = self.raw.sets[spelt]
        edges = self.body.edges
        whole = np.isin(edges[:, :2], members).all(axis=1)
        return np.union1d(members, edges[whole, 2])


def read_source(spec: MeshBody, key: str, *, folder: Path) -> MeshSource:
    """Read the mesh of a body and convert it to standard form.

    Parameters
    ----------
    spec : MeshBody
    key : str
        "body_1" or "body_2".
    folder : Path
        Folder to which the file's name is relative.

    Returns
    -------
    MeshSource

    Raises
    ------
    MeshError
        If the file is missing, unreadable, has a defect, or is not in millimetres.
    """
    raw = read_mesh(folder / spec.file, f"{key}.file")
    one_material = spec.one_material or spec.region_sets is not None
    body = sound_body(raw, f"{key}.file", one_material=one_material)
    source = MeshSource(raw, body, key)
    _check_size(source, spec)
    return source


def unit_of(ratio: float) -> str | None:
    """Unit whose length in mm is closest to a ratio of expected and actual size.

    Parameters
    ----------
    ratio : float
        Expected size in mm over the size in the file.

    Returns
    -------
    str or None
        None if no unit is close.
    """
    name, factor = min(UNITS.items(), key=lambda unit: abs(np.log(unit[1] / ratio)))
    return name if 0.2 < factor / ratio < 5.0 else None


def _check_size(source: MeshSource, spec: MeshBody) -> None:
    """Refuse a mesh of implausible size, for example one in metres."""
    largest = float(np.hypot(*source.raw.nodes.T).max())
    if spec.profile is not None:
        wanted, bound, name = 0.5 * spec.profile.tip_diameter_mm, LARGEST_TIP_RATIO, "tip radius"
    else:
        wanted, bound, name = spec.reference_radius_mm or largest, LARGEST_RATIO, "reference radius"
    ratio = wanted / largest if largest > 0 else np.inf
    if 1 / bound < ratio < bound:
        return
    unit = unit_of(ratio) if np.isfinite(ratio) else None
    hint = f"; in {unit}? (1 = {UNITS[unit]:g} mm)" if unit else ""
    expected = f"a mesh in millimetres about the origin, to the {name} of {wanted:g} mm"
    source.refuse("file", expected, f"nodes up to radius {largest:.4g}{hint}")


def check_axis(source: MeshSource, fixed: Numbers) -> None:
    """Refuse a body whose bore is a circle about another point than the origin.

    Parameters
    ----------
    source : MeshSource
    fixed : array
        Fixed nodes.

    Raises
    ------
    MeshError
    """
    circle = circle_through(source.raw.nodes[fixed[fixed < len(source.raw.nodes)]])
    if circle is None:
        return
    (x, y), radius = circle
    if np.hypot(x, y) > OFF_AXIS * radius:
        expected = "a body whose axis is the origin"
        source.refuse("file", expected, f"a bore about x = {x:.4f}, y = {y:.4f} mm")
