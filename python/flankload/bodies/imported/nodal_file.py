"""Reading of compliance files of other programs: nodes of a flank and a matrix between them.

`docs/guide/compliance_files.md` defines the matrix.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import Body
from flankload.bodies.flank_elements import mass_matrix
from flankload.bodies.imported.compliance import (
    CORNER_ANGLES,
    NodalCompliance,
    read_corner_angles,
    read_material,
)
from flankload.bodies.plane import sketched_tooth
from flankload.flank import curve_through_nodes, nodes_deviation
from flankload.scene.table import LARGEST_LENGTH, MOST_TEETH

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.meshes.io.named_arrays import NamedArrays


FORMAT = "flankload nodal compliance"
VERSION = 1

NAMES = (
    "format", "version", "teeth", "points", "compliance", "offsets", "columns", "elements",
    "young_modulus_MPa", "poisson_ratio", "plane", "reference_radius_mm", "teeth_stand",
    *CORNER_ANGLES,
)  # fmt: skip

#: Least number of nodes for a curve.
LEAST_POINTS = 6
#: Least cosine of the angle between neighbouring segments of ordered nodes (60 degrees).
LEAST_COSINE = 0.5
#: Largest asymmetry of the matrix (Betti's theorem), over its Frobenius norm.
LARGEST_ASYMMETRY = 0.01


def read_nodal(found: NamedArrays) -> Body:
    """Body of a file, checked, at the angle of its points.

    Raises
    ------
    ComplianceFileError
        If an array is missing, has a wrong shape, is not finite or is out of order, or if the
        matrix is not a compliance: not symmetric, or not positive definite.
    """
    found.check_names(*NAMES)
    teeth = found.integer("teeth", least=3, most=MOST_TEETH)
    quadratic = found.text("elements", "linear", "quadratic") == "quadratic"
    inwards = False
    if "teeth_stand" in found:
        inwards = found.text("teeth_stand", "outwards", "inwards") == "inwards"
    points = _read_points(found, quadratic, inwards=inwards)
    curve = curve_through_nodes(points)
    imported = _read_compliance(found, curve.arc_length_of(points)[0], teeth, quadratic=quadratic)
    deviation = nodes_deviation(points)
    estimate = f"{1000 * deviation:.2g} um" if np.isfinite(deviation) else "unknown"
    note = (
        "the flank is a smooth curve through these nodes, estimated deviation from the true "
        f"profile {estimate}"
    )
    return Body(
        kind="compliance",
        curve=curve,
        teeth=teeth,
        material=read_material(found),
        rigid=False,
        mode_range_mm=(0.0, curve.length_mm),
        reference_radius_mm=found.number("reference_radius_mm", above=0.0, most=LARGEST_LENGTH),
        flank_angle_known=False,
        outline=sketched_tooth(points, teeth),
        bore_radius_mm=1.2 * float(np.hypot(*points[0])) if inwards else 0.0,
        notes=(_note_of(imported, len(points), teeth), note),
        imported=imported,
    )


def _read_compliance(
    found: NamedArrays, arc_length_mm: Floats, teeth: int, *, quadratic: bool
) -> NodalCompliance:
    """The matrix between the nodes, checked and made symmetric."""
    offsets, n = _read_offsets(found, teeth), arc_length_mm.size
    shape = (len(offsets), n, n)
    single = found.dimensions("compliance") == 2 and len(offsets) == 1
    matrix = found.numbers("compliance", *(shape[1:] if single else shape)).reshape(shape)
    of_pressures = found.text("columns", "nodal_forces", "nodal_pressures") == "nodal_pressures"
    if of_pressures:
        matrix = mass_matrix(arc_length_mm, quadratic=quadratic) @ matrix
    matrix, asymmetry = _symmetric(found, matrix, offsets, teeth)
    imported = NodalCompliance(
        file=found.file,
        plane=found.text("plane", "strain", "stress"),
        arc_length_mm=arc_length_mm,
        quadratic=quadratic,
        of_pressures=of_pressures,
        offsets=offsets,
        matrix=matrix,
        asymmetry=asymmetry,
        corner_angles_deg=read_corner_angles(found),
    )
    _check_work(found, imported, teeth)
    return imported


def _note_of(imported: NodalCompliance, points: int, teeth: int) -> str:
    """Note on the imported compliance and its omissions."""
    note = (
        f"compliance of {points} nodes on {imported.offsets.size} of {teeth} teeth from "
        f"{imported.file.name}, asymmetry {imported.asymmetry:.2g}"
    )
    if imported.offsets.size == 1:
        note += "; other teeth do not move with the loaded one: adjacent pairs appear too stiff"
    return note


def _read_points(found: NamedArrays, quadratic: bool, *, inwards: bool) -> Floats:
    """Nodes of the flank in order from root to tip."""
    points = found.numbers("points", None, 2)
    if len(points) < LEAST_POINTS:
        found.refuse("points", f"at least {LEAST_POINTS}", f"{len(points)}")
    if quadratic and len(points) % 2 == 0:
        expected = "an odd number: quadratic elements have a middle between two ends"
        found.refuse("points", expected, f"{len(points)}")
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    if not lengths.min() > 1e-9 * lengths.max():
        k = int(lengths.argmin())
        found.refuse(f"points[{k + 1}]", "another place than the one before", "the same place")
    cosine = np.sum(steps[1:] * steps[:-1], axis=1) / (lengths[1:] * lengths[:-1])
    if (cosine < LEAST_COSINE).any():
        k = int(np.argmax(cosine < LEAST_COSINE))
        found.refuse(
            f"points[{k + 1}]",
            "places in order along a smooth flank",
            f"a turn by {np.degrees(np.arccos(np.clip(cosine[k], -1, 1))):.0f} degrees",
        )
    root, tip = np.linalg.norm(points[[0, -1]], axis=1)
    if (tip >= root) if inwards else (tip <= root):
        found.refuse(
            "points",
            "places from root to tip, the axis at the origin, of teeth that point "
            + ("inwards" if inwards else "outwards"),
            f"a first radius of {root:g} and a last one of {tip:g} mm",
        )
    return points


def _read_offsets(found: NamedArrays, teeth: int) -> Numbers:
    """Displaced teeth, including the loaded one, each once."""
    if "offsets" not in found:
        return np.zeros(1, dtype=np.int64)
    offsets = found.integers("offsets", None)
    reduced = offsets % teeth
    if 0 not in reduced or np.unique(reduced).size != offsets.size:
        expected = f"teeth counted from the loaded one, 0 among them and each of the {teeth} once"
        found.refuse("offsets", expected, ", ".join(f"{offset}" for offset in offsets[:8]))
    return reduced


def _symmetric(
    found: NamedArrays, matrix: Floats, offsets: Numbers, teeth: int
) -> tuple[Floats, float]:
    """Mean of each response and its reciprocal (Betti), and their relative difference."""
    row = {int(offset): k for k, offset in enumerate(offsets)}
    mirrored = np.stack(
        [
            matrix[row[back]].T if (back := -int(offset) % teeth) in row else matrix[k]
            for k, offset in enumerate(offsets)
        ]
    )
    differences = np.abs(matrix - mirrored)
    if not matrix.any():
        found.refuse("compliance", "a matrix that is not 0", "0")
    # norm over all entries, since loads extend over many nodes
    asymmetry = float(np.linalg.norm(differences) / np.linalg.norm(matrix))
    if asymmetry > LARGEST_ASYMMETRY:
        k, i, j = np.unravel_index(int(differences.argmax()), differences.shape)
        expected = f"a symmetric matrix (reciprocity), to {LARGEST_ASYMMETRY:g} of its norm"
        found.refuse("compliance", expected, f"{asymmetry:.3g}, most at [{k}, {i}, {j}]")
    return 0.5 * (matrix + mirrored), asymmetry


def _check_work(found: NamedArrays, imported: NodalCompliance, teeth: int) -> None:
    """Check that the compliance of the whole body is positive definite."""
    whole = np.zeros((teeth, *imported.matrix.shape[1:]))
    for offset, block in zip(imported.offsets.tolist(), imported.matrix, strict=True):
        whole[offset] = block
        if -offset % teeth not in imported.offsets:
            whole[-offset % teeth] = block.T
    # a Fourier transform over the equal teeth decouples the matrix
    waves = np.fft.fft(whole, axis=0)
    least = np.linalg.eigvalsh(0.5 * (waves + waves.conj().transpose(0, 2, 1))).min(axis=1)
    if not least.min() > 0.0:
        expected = "a positive definite matrix, since any load does positive work"
        found.refuse("compliance", expected, f"an eigenvalue of {least.min():.3g}")
