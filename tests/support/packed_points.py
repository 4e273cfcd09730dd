"""Two equal cylinders given by points of the flank and tables of compliance between them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flankload import _core
from flankload.contact.body_record import packed_parts
from tests.support.packed_meshes import CYLINDER, mesh_record

#: Angles and speeds at which two equal cylinders touch beside the middle of their flanks.
MOTION = np.asfortranarray([[0.1], [np.pi + 0.1], [1.0], [-0.5]])
TORQUE = np.array([3.6e4])


def tables(s_mm: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, N, 1) Displacements along the normal under loads along it and along the flank."""
    apart = s_mm[:, None] - s_mm
    normal = 1e-6 + 3e-6 * np.exp(-np.abs(apart))
    along = 1e-7 * (s_mm[:, None] - 6.0) * np.exp(-np.abs(apart))
    return np.asfortranarray(normal[..., None]), np.asfortranarray(along[..., None])


def by_points(n: int) -> NDArray[np.float64]:
    """Record of a cylinder from n points."""
    s = np.linspace(0.0, CYLINDER.length_mm, n)
    arguments = (
        np.asfortranarray(CYLINDER.point(s).T),
        np.zeros(n, dtype=np.intc),
        tables(s)[0],
        *(np.zeros(1), np.zeros(1), np.ones((1, 1), dtype=np.intc, order="F"), 2.8e-7),
    )
    record = np.empty(_core.flankload_pack_points(*arguments, np.empty(0)))
    assert _core.flankload_pack_points(*arguments, record) == 0
    return record


def by_curve(n: int) -> NDArray[np.float64]:
    """The same with the arc itself."""
    s = np.linspace(0.0, CYLINDER.length_mm, n)
    arguments = (
        CYLINDER.breaks,
        np.asfortranarray(CYLINDER.coefficients.transpose(2, 1, 0)),
        np.zeros(CYLINDER.breaks.size, dtype=np.intc),
        *(np.zeros(1), np.zeros(1), np.array([0.0, CYLINDER.length_mm]), 2.8e-7, tables(s)[0]),
        np.ones((1, 1), dtype=np.intc, order="F"),
    )
    record = np.empty(_core.flankload_pack_body(*arguments, np.empty(0)))
    assert _core.flankload_pack_body(*arguments, record) == 0
    return packed_parts(record, [("nodes", s)])


def rotation(body: NDArray[np.float64], *, friction: float | None = None) -> float:
    """Rotation of two such cylinders; with friction by their own tables."""
    mesh, n = mesh_record(0.0), int(body[5])
    if friction is not None:
        s = np.linspace(0.0, CYLINDER.length_mm, n)
        body = packed_parts(body, [("tangential", tables(s)[1].ravel(order="F"))])
        mesh = packed_parts(mesh, [("friction", np.array([0.0, friction]))])
    none: list[Any] = [np.empty(0, np.intc), *[np.zeros((1, 1), np.intc, "F")] * 2]
    found = _core.flankload_sweep_mesh(
        *(1, MOTION, TORQUE, mesh, body, body, 11 if friction is None else 13),
        *(np.zeros(2, np.intc), np.empty(0, np.intc), np.empty(0), *none),
    )
    assert found[-1] == 0, _core.flankload_status_text(int(found[0][0, 0]))
    return float(found[1][0, 0])
