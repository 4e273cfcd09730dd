"""Records of bodies: their parts, their sizes, and all that packing and sweep refuse."""

from __future__ import annotations

import ctypes
import re
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flankload import _core
from flankload.contact.body_record import PARTS
from flankload.contact.pair_table import COLUMNS, FRICTION_COLUMNS
from tests.support.body_records import N_HEADER, NAMES, counts_of, parts_of
from tests.support.paths import FORTRAN
from tests.support.pressed_cylinders import arc
from tests.support.tolerances import SOLVER

NAN = np.nan
SITES, MODES, BLOCKS = 2, 3, 2
#: The same number of modes, with which the last two are those of a tip.
TIP = np.array([20.0, 1.0, 0.3])
#: All modes are polynomials over the width; end faces, twist, strengths of both ends.
AXIAL = np.array([3.0, -1.0, 1.0, 1e-3, 1.3, 0.0])
EDGES = ("slices", [-1.0, 0.0, 1.0])
#: Place, length, normal, angle, tilt and compliance of a height of two sites.
HEIGHT = [1.0, 2.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2e-6, 1e-6, 1e-6, 2e-6]
#: Where a record has the place of the first part that every body has.
FIRST = 7 + 2 * len(PARTS)
#: A place is between both flanks, off each by half of the gap that closes.
PLACE = 1e-4
RIGID = {"kernel": 0.0}
#: Compliance of a section, and its place.
SHAFT = np.append(np.diag([1e-6, 2e-6, 0.0, 1e-9, 1e-9, 0.0]).ravel(), 0.5)


#: Flank of one of two cylinders.
CURVE = arc((36.0, -20.0), 20.0, np.pi / 2 + 0.3, np.pi / 2 - 0.3)


def main_arguments(**changes: Any) -> list[Any]:
    """Arguments of `flankload_pack_body` up to the record: one of two cylinders, two sites."""
    curve = CURVE
    arguments: dict[str, Any] = {
        "breaks": curve.breaks,
        "coefficients": np.asfortranarray(curve.coefficients.transpose(2, 1, 0)),
        "corners": np.zeros(curve.breaks.size, dtype=np.intc),
        "site_angles": np.array([0.0, -0.2]),
        "deviations": np.zeros(SITES),
        "mode_range": np.array([0.0, curve.length_mm]),
        "kernel": 2.8e-7,
        "smooth": np.asfortranarray(1e-6 * np.eye(MODES)[:, :, None] * np.array([1.0, 0.1])),
        "block": np.array([[1, 2], [2, 1]], dtype=np.intc, order="F"),
    }
    return list((arguments | changes).values())


def record_of(*parts: tuple[str, Any], **changes: Any) -> NDArray[np.float64]:
    """A record with parts."""
    arguments = main_arguments(**changes)
    values = [np.array(value, dtype=float).ravel(order="F") for _, value in parts]
    needed = _core.flankload_pack_body(*arguments, np.empty(0))
    record = np.empty(needed + sum(value.size for value in values))
    assert _core.flankload_pack_body(*arguments, record) == 0
    for (name, _), value in zip(parts, values, strict=True):
        assert part_info(name, value, record) == 0
    return record


def part_info(name: str, values: Any, record: NDArray[np.float64]) -> int:
    number = PARTS.index(name) + 1
    return int(_core.flankload_pack_part(number, np.array(values, dtype=float), record))


def sweep_info(
    one: NDArray[np.float64], two: NDArray[np.float64], **changes: Any
) -> tuple[int, NDArray[np.float64]]:
    """`info` and rotations; body 2 is body 1 turned over."""
    arguments: dict[str, Any] = {
        "n_sites": SITES,
        "motion": np.array([[0.0], [np.pi], [1.0], [-1.0]], order="F"),
        "center_distance": 72.0,
        "torques": np.array([3600.0]),
        "record_1": one,
        "record_2": two,
        "settings": np.array([10.0, 30.0, 2.5, 0.0, 0.0]),
        "n_columns": 11,
        "control": np.zeros(2, dtype=np.intc),
        "pair_site": np.empty(0, dtype=np.intc),
        "pair_table": np.empty(0),
    }
    outputs = _core.flankload_sweep(*(arguments | changes).values())
    return int(outputs[-1]), outputs[1]


def test_a_record_holds_what_was_packed() -> None:
    parts = {
        "shaft": SHAFT,
        "shift": np.arange(MODES * SITES, dtype=float),
        "wedge": np.array([0.0, 0.3]),
        "tangential": np.arange(2.0 * MODES * BLOCKS),
        "along": np.arange(2.0 * 2 * BLOCKS),
        "friction": np.array([1.0, 2.0, 0.1, 0.1, 0.05, 0.06]),
        "sides": np.ones(SITES),
        "jump": np.array([1e-7]),
        "nodes": np.array([1.0, 2.0, 3.0]),
        "tip": TIP,
        "axial": AXIAL,
        "slices": np.array([-1.0, 0.0, 1.0]),
        "turned": np.arange(MODES**2 * BLOCKS, dtype=float),
        "wedge_along": np.array([0.0, -0.5]),
        "sections": np.concatenate([CURVE.coefficients.ravel(), CURVE.coefficients.ravel()]),
        "height": np.array(HEIGHT),
        "members": np.array([1.0, 2.0, 0.0, 0.0, 0.3, -1.0]),
        "support": np.diag([1e-6, 2e-6, 0.0]).ravel(),
        "carrier": np.append(1.0, np.arange(72.0)),
        "tilt": np.array([1e-4, -2e-4, 0.5]),
    }
    assert set(parts) == set(PARTS)
    record = record_of(*parts.items())
    found = parts_of(record)
    names = ("breaks", "coefficients", "corners", "site_angles", "deviations", "mode_range")
    expected = dict(zip((*names, "kernel", "smooth", "block"), main_arguments(), strict=True))
    for name, values in (expected | parts).items():
        np.testing.assert_array_equal(
            found[name].ravel(order="F"), np.ravel(values, order="F"), err_msg=name
        )
    sizes = counts_of(record)
    assert (sizes["sites"], sizes["modes"], sizes["blocks"]) == (SITES, MODES, BLOCKS)
    assert record[1] == record.size == N_HEADER + sum(part.size for part in found.values())


def test_the_length_is_known_in_advance() -> None:
    """n_record = 0, or less than needed: the length, and nothing is written."""
    arguments = main_arguments()
    needed = _core.flankload_pack_body(*arguments, np.empty(0))
    short = np.full(needed - 1, 7.0)
    assert _core.flankload_pack_body(*arguments, short) == needed
    assert (short == 7.0).all()
    full = np.empty(needed)
    assert _core.flankload_pack_body(*arguments, full) == 0
    before = full.copy()
    assert part_info("wedge", [0.0, 0.1], full) == needed + 2
    np.testing.assert_array_equal(full, before)


def test_a_longer_record_and_a_part_packed_again() -> None:
    """Room behind a record does no harm; a part of the same length is replaced in its place."""
    exact = record_of(("wedge", [0.0, 0.3]))
    long = np.full(exact.size + 9, NAN)
    assert _core.flankload_pack_body(*main_arguments(), long) == 0
    assert part_info("wedge", [0.1, 0.2], long) == 0
    assert part_info("wedge", [0.0, 0.3], long) == 0
    np.testing.assert_array_equal(long[: exact.size], exact)
    info, rotation = sweep_info(long, record_of())
    assert info == 0
    np.testing.assert_array_equal(rotation, sweep_info(exact, record_of())[1])
    assert part_info("friction", [1.0, 0.1, 0.1], long) == 0
    assert part_info("friction", [1.0, 2.0, 0.1, 0.1, 0.1, 0.1], long) == -102


@pytest.mark.parametrize(
    ("argument", "changes"),
    [
        (2, {"coefficients": np.zeros((0, 2, 8), order="F")}),
        (3, {"breaks": np.zeros(9)}),
        (3, {"breaks": np.append(np.arange(8.0), NAN)}),
        (4, {"coefficients": np.full((4, 2, 8), NAN, order="F")}),
        (5, {"corners": np.full(9, 3, dtype=np.intc)}),
        (7, {"site_angles": np.array([0.0, NAN])}),
        (8, {"deviations": np.array([np.inf, 0.0])}),
        (9, {"smooth": np.zeros((0, 0, 1), order="F")}),
        (10, {"smooth": np.zeros((3, 3, 0), order="F")}),
        (11, {"mode_range": np.array([0.0, NAN])}),
        (12, {"kernel": NAN}),
        (12, {"kernel": -1e-7}),
        (13, {"smooth": np.full((3, 3, 2), NAN, order="F")}),
        (14, {"block": np.array([[1, 3], [3, 1]], dtype=np.intc, order="F")}),
        (14, {"block": np.array([[1, 0], [0, 1]], dtype=np.intc, order="F")}),
    ],
)
def test_refused_arguments_of_a_body(argument: int, changes: dict[str, Any]) -> None:
    base: dict[str, Any] = {
        "breaks": np.arange(9.0),
        "coefficients": np.ones((4, 2, 8), order="F"),
        "corners": np.zeros(9, dtype=np.intc),
    }
    record = np.full(1000, 7.0)
    assert _core.flankload_pack_body(*main_arguments(**(base | changes)), record) == -100 - argument
    assert (record == 7.0).all()


@pytest.mark.parametrize(
    ("argument", "place", "size"),
    [(1, 0, 1), (2, 1, -1), (6, 5, 0), (9, 8, 0), (10, 9, 0), (15, 8, 100_000)],
)
def test_refused_sizes_of_a_body(argument: int, place: int, size: int) -> None:
    """Calls as from C, which f2py cannot make. Nothing beyond these arrays is read."""
    sizes = dict(zip((0, 1, 5, 8, 9), (9, 3, SITES, MODES, BLOCKS), strict=True)) | {place: size}
    numbers, whole = np.arange(1000.0), np.zeros(1000, dtype=np.intc)
    info = np.zeros(1, dtype=np.intc)
    room = np.full(1, numbers.size, dtype=np.intc)
    arrays: list[Any] = [None, None, *(numbers, numbers, whole), None, *(numbers, numbers)]
    arrays += [None, None, *(numbers, numbers, numbers, whole), room, numbers, info]
    held = [np.full(1, sizes[k], dtype=np.intc) if a is None else a for k, a in enumerate(arrays)]
    ctypes.CDLL(_core.__file__).flankload_pack_body_(
        *(ctypes.c_void_p(array.ctypes.data) for array in held)
    )
    assert info[0] == -100 - argument


@pytest.mark.parametrize(
    ("argument", "name", "values"),
    [
        (2, "tip", [20.0, 1.0]),
        (3, "tip", [20.0, 1.0, 0.0]),
        (3, "tip", [20.0, 1.0, NAN]),
        (3, "tip", [20.0, 2.0, 0.3]),
        (2, "wedge", [0.1]),
        (3, "wedge", [0.1, -0.1]),
        (3, "wedge", [NAN, 0.1]),
        (2, "nodes", [1.0, 2.0]),
        (3, "nodes", [1.0, 2.0, 2.0]),
        (3, "nodes", [3.0, 2.0, 1.0]),
        (2, "tangential", np.zeros(MODES * BLOCKS + 1)),
        (3, "tangential", np.full(MODES * BLOCKS, NAN)),
        (2, "jump", [0.1, 0.1]),
        (2, "along", np.zeros(BLOCKS)),
        (2, "shift", np.zeros(MODES)),
        (3, "shift", np.full(MODES * SITES, NAN)),
        (2, "sides", [1.0]),
        (3, "sides", [1.0, 0.5]),
        (3, "sides", [2.0, -1.0]),
        (3, "sides", [-1.0, -1.0]),
        (3, "sides", [-1.0, 1.0]),
        (2, "friction", [1.0, 0.1]),
        (3, "friction", [1.0, 0.1, -0.1]),
        (3, "friction", [1.0, 0.1, NAN]),
        (3, "friction", [2.0, 1.0, 0.1, 0.1, 0.1, 0.1]),
        (2, "friction", []),
        (3, "axial", AXIAL[:5]),
        (3, "axial", [*AXIAL, 1.3]),
        (3, "axial", [*AXIAL, 1.3, -0.1]),
        (3, "axial", [2.0, *AXIAL[1:]]),
        (3, "axial", [1.5, *AXIAL[1:]]),
        (3, "axial", [0.0, *AXIAL[1:]]),
        (3, "axial", [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        (3, "axial", [1.0, -1.0, 1.0, 0.0, -0.1, 0.0]),
        (3, "axial", [1.0, -1.0, 1.0, NAN, 0.0, 0.0]),
        (3, "slices", [1.0]),
        (3, "slices", [0.0, 1.0, 1.0]),
        (3, "slices", [0.0, 1.0, 2.0, 3.0]),
        (3, "slices", [0.0, NAN]),
        (2, "sections", np.zeros(CURVE.coefficients.size + 1)),
        (3, "sections", np.full(CURVE.coefficients.size, NAN)),
        (3, "height", HEIGHT[:-1]),
        (3, "height", [*HEIGHT[:2], 0.0, *HEIGHT[3:]]),
        (3, "height", [*HEIGHT[:-2], 0.0, 1e-6]),
    ],
)
def test_refused_parts(argument: int, name: str, values: Any) -> None:
    record = np.append(record_of(), np.zeros(50))
    before = record.copy()
    assert part_info(name, values, record) == -100 - argument
    np.testing.assert_array_equal(record, before)


def test_refused_numbers_of_parts_and_arrays_that_are_no_record() -> None:
    record = np.append(record_of(), np.zeros(50))
    for part in (0, len(PARTS) + 1, -3):
        assert _core.flankload_pack_part(part, np.zeros(1), record) == -101
    assert part_info("wedge", [0.1, 0.1], np.zeros(3000)) == -105
    assert part_info("wedge", [0.1, 0.1], np.zeros(3)) == -105


def test_modes_of_a_tip_need_one_of_the_flank() -> None:
    record = np.append(record_of(smooth=np.zeros((2, 2, 2), order="F")), np.zeros(5))
    assert part_info("tip", TIP, record) == -103


def test_working_flanks_come_before_coast_flanks() -> None:
    three = {
        "site_angles": np.zeros(3),
        "deviations": np.zeros(3),
        "block": np.ones((3, 3), dtype=np.intc, order="F"),
    }
    record = np.append(record_of(**three), np.zeros(3))
    assert part_info("sides", [1.0, -1.0, 1.0], record) == -103
    assert part_info("sides", [1.0, -1.0, -1.0], record) == 0


def test_displacements_along_the_flank_need_as_many_loads_along_it() -> None:
    record = np.append(record_of(("tangential", np.zeros(2 * MODES * BLOCKS))), np.zeros(50))
    assert part_info("along", np.zeros(9 * BLOCKS), record) == -102
    assert part_info("along", np.zeros(4 * BLOCKS), record) == 0


def test_a_sweep_of_records() -> None:
    info, rotation = sweep_info(record_of(), record_of())
    assert info == 0
    assert np.isfinite(rotation).all()
    moved, shifted = np.zeros((MODES, SITES)), 0.01
    moved[0] = shifted
    info, turned = sweep_info(record_of(("shift", moved)), record_of())
    assert info == 0
    np.testing.assert_allclose(rotation - turned, shifted / 36.0, rtol=0.02)


@pytest.mark.parametrize("z", [1, 2])
def test_sections_are_in_place_of_the_flank(z: int) -> None:
    """One of them is the flank; so many need as many slices."""
    nearer = CURVE.coefficients.transpose(2, 1, 0).copy()
    nearer[0, 1] += 0.01
    coefficients = np.asfortranarray(nearer)
    section = ("sections", coefficients.ravel(order="F"))
    records = [record_of(section), record_of()][:: 1 if z == 1 else -1]
    info, found = sweep_info(*records)
    assert info == 0
    records[z - 1] = record_of(coefficients=coefficients)
    # circles meet sections to rounding, other flanks to one step along their tangent
    np.testing.assert_allclose(found, sweep_info(*records)[1], rtol=SOLVER)
    assert not np.array_equal(found, sweep_info(record_of(), record_of())[1])
    records[z - 1] = record_of(("sections", np.tile(section[1], 2)))
    assert sweep_info(*records)[0] == (-108 if z == 1 else -110)


NO_TANGENTIAL = ("tangential", np.zeros(MODES * BLOCKS))
FRICTION = ("friction", [1.0, 0.1, 0.1])


@pytest.mark.parametrize(
    ("z", "name", "values", "beside", "changes"),
    [
        *((z, "tip", [8.0, 1.0, 0.3], [], {"mode_range": np.array([0.0, 5.0])}) for z in (1, 2)),
        *((z, "wedge", [0.0, 0.3], [], {}) for z in (1, 2)),
        *((z, "nodes", [0.0, 6.0, 12.0], [], {}) for z in (1, 2)),
        *((z, "tangential", np.full(MODES * BLOCKS, 1e-6), [], {}) for z in (1, 2)),
        *((z, "jump", [1e-7], [NO_TANGENTIAL], {}) for z in (1, 2)),
        *((z, "along", np.full(BLOCKS, 1e-6), [NO_TANGENTIAL], {}) for z in (1, 2)),
        *((z, "shift", np.full(MODES * SITES, 1e-3), [], {}) for z in (1, 2)),
        *((z, "wedge_along", [0.0, -0.5], [NO_TANGENTIAL], {}) for z in (1, 2)),
        (1, "sides", [1.0, -1.0], [], {"site_angles": np.zeros(SITES)}),
        (1, "friction", [1.0, 0.2, 0.2], [], {}),
    ],
)
def test_each_part_reaches_the_core(
    z: int, name: str, values: Any, beside: list[Any], changes: dict[str, Any]
) -> None:
    """Without the part, the same sweep finds another rotation."""
    friction = [FRICTION] if name in ("tangential", "jump", "along", "wedge_along") else []
    steps = 3.0 if name == "along" else 0.0

    def rotation(*parts: tuple[str, Any]) -> float:
        own = [*(friction if z == 1 else ()), *beside, *parts]
        mine = record_of(*own, **changes)
        other = record_of(*(friction if z == 2 else ()), **(changes if name == "sides" else RIGID))
        rubs = bool(friction) or "friction" in dict(parts)
        info, found = sweep_info(
            *((mine, other) if z == 1 else (other, mine)),
            motion=np.array([[0.05], [np.pi], [1.0], [-0.5]], order="F"),
            settings=np.array([10.0, 30.0, 2.5, 0.0, steps]),
            n_columns=13 if rubs else 11,
        )
        assert info == 0
        return float(found[0, 0])

    assert rotation((name, values)) != rotation()


def sliced_info(one: list[Any], two: list[Any], level: float = 1.0) -> int:
    """`info` of a sweep of bodies with these parts."""
    settings = np.array([10.0, 30.0, 2.5, level, 0.0])
    return sweep_info(record_of(*one), record_of(*two), settings=settings)[0]


def test_slices_need_both_bodies_over_their_width() -> None:
    """All slices in both bodies, on body 1; modes over the width only with slices."""
    axial, short = ("axial", AXIAL), ("axial", [*AXIAL[:2], 0.9, *AXIAL[3:]])
    assert sliced_info([axial, EDGES], [axial]) == 0
    assert sliced_info([EDGES], [axial]) == -108
    assert sliced_info([axial, EDGES], []) == -110
    assert sliced_info([short, EDGES], [axial]) == -108
    assert sliced_info([axial, EDGES], [short]) == -110
    assert sliced_info([axial, EDGES], [axial, EDGES]) == -110
    assert sliced_info([axial], [axial]) == -108


def test_slices_have_shifts_but_no_finite_forces() -> None:
    """The state has a status for this."""
    axial = ("axial", AXIAL)
    shift = ("shift", np.zeros(MODES * SITES))
    assert sliced_info([axial, EDGES], [axial], level=0.0) == 0
    finite = np.array([10.0, 30.0, 2.5, 0.0, 2.0])
    sliced = record_of(axial, EDGES), record_of(axial)
    assert sweep_info(*sliced, settings=finite)[0] == 1
    assert sliced_info([axial, EDGES, shift], [axial]) == 0
    assert sliced_info([axial, EDGES], [axial, shift]) == 0
    rubbing = record_of(axial, EDGES, FRICTION), record_of(axial)
    settings = np.array([10.0, 30.0, 2.5, 1.0, 0.0])
    assert sweep_info(*rubbing, settings=settings, n_columns=13)[0] == 0
    cells = np.array([10.0, 30.0, 2.5, 0.0, 0.0])
    assert sweep_info(*rubbing, settings=cells, n_columns=13)[0] == 0
    # loads along the flank have the modes of those along the normal
    few = ("tangential", np.zeros(MODES * (MODES - 1)))
    rubbing = record_of(axial, EDGES, FRICTION, few), record_of(axial)
    assert sweep_info(*rubbing, settings=settings, n_columns=13)[0] == 1


class _Memory(ctypes.Structure):
    """`struct mallinfo2` of the C library."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "hblkhd"),
            *("usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"),
        )
    )


def bytes_in_use() -> int:
    """Bytes that `malloc` has given to this thread and that were not released."""
    mallinfo = ctypes.CDLL(None).mallinfo2
    mallinfo.restype = _Memory
    found = mallinfo()
    return int(found.uordblks + found.hblkhd)


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="another C library")
@pytest.mark.parametrize(
    ("parts", "settings"),
    [
        ([], [0.0, 0.0]),
        ([], [1.0, 0.0]),
        ([], [0.0, 2.0]),
        ([("sections", CURVE.coefficients.transpose(2, 1, 0).ravel(order="F"))], [0.0, 0.0]),
        ([("axial", AXIAL), EDGES], [0.0, 0.0]),
        ([("axial", AXIAL), EDGES, FRICTION], [1.0, 0.0]),
        ([("axial", AXIAL), EDGES], [0.0, 2.0]),
    ],
    ids=["cells", "lumped", "finite", "sections", "slices", "sliding slices", "no state"],
)
def test_a_sweep_releases_its_memory(parts: list[Any], settings: list[float]) -> None:
    """40 sweeps leak no memory except some pages of Python; the flanks take 10 kB each."""
    records = record_of(*parts), record_of(*parts[:1] if parts[1:] else [])
    changes = {
        "settings": np.array([10.0, 30.0, 2.5, *settings]),
        "n_columns": 13 if FRICTION in parts else 11,
    }
    assert sweep_info(*records, **changes)[0] == (1 if parts and settings[1] else 0)
    before = bytes_in_use()
    for _ in range(40):
        sweep_info(*records, **changes)
    assert bytes_in_use() - before < 40 * 1000


@pytest.mark.parametrize("z", [1, 2])
def test_arrays_that_are_no_record_are_refused_by_the_sweep(z: int) -> None:
    """Arrays without a mark, truncated, or with a changed layout."""
    good = record_of(("wedge", [0.0, 0.3]))
    bad = [np.zeros(0), np.zeros(500), np.full(500, NAN), good[:-1], good[: N_HEADER - 1]]
    for place, value in [
        *((0, 1.0), (0, good[0] + 1), (1, good[1] + 1), (1, good[1] - 1), (1, NAN), (1, 1e300)),
        *((2, 1.0), (3, 1e9), (4, 3.0), (5, 0.0), (5, 2.5), (6, -2.0)),
        *((7 + 2, 0.0), (7 + 2, good.size), (7 + 3, 3.0), (7 + 3, -1.0), (FIRST, 1e9)),
        *((FIRST + 1, 0.0), (7, NAN)),
    ]:
        changed = good.copy()
        changed[place] = value
        bad.append(changed)
    without_kernel = good.copy()
    without_kernel[7 + 2 * NAMES.index("kernel") + np.arange(2)] = 0.0
    without_kernel[1] -= 1
    bad.append(without_kernel)
    for record in bad:
        records = (record, good) if z == 1 else (good, record)
        info, rotation = sweep_info(*records)
        assert info == (-108 if z == 1 else -110)
        assert np.isnan(rotation).all()
    assert sweep_info(good, good)[0] == 0


@pytest.mark.parametrize(
    ("name", "value"),
    [("block", 3.0), ("block", 0.0), ("smooth", NAN), ("kernel", -1.0), ("wedge", -0.1)],
)
def test_values_spoiled_in_a_record_are_refused(name: str, value: float) -> None:
    """The caller owns the array: it is checked again although it was checked when packed."""
    record = record_of(("wedge", [0.0, 0.3]))
    place = int(record[7 + 2 * NAMES.index(name)]) - 1
    record[place] = value
    assert sweep_info(record, record_of())[0] == -108
    assert sweep_info(record_of(), record)[0] == -110


NODES = ("nodes", [0.0, 6.0, 12.0])
SIDES = ("sides", [1.0, -1.0])


@pytest.mark.parametrize(
    ("argument", "one", "two", "changes"),
    [
        (8, [NODES, ("wedge", [0.0, 0.3])], [NODES], {}),
        (10, [NODES], [NODES, ("wedge", [0.0, 0.3])], {}),
        (10, [NODES], [], {}),
        (8, [], [NODES], {}),
        (10, [], [SIDES], {}),
        (10, [], [FRICTION], {}),
        (3, [], [], {"n_sites": 3}),
        (4, [FRICTION], [], {"motion": np.full((4, 1), NAN, order="F"), "n_columns": 13}),
        (6, [], [], {"torques": np.array([-1.0])}),
        (6, [], [], {"torques": np.array([NAN])}),
        (11, [], [], {"settings": np.array([0.0, 30.0, 2.5, 0.0, 0.0])}),
        (11, [], [], {"settings": np.array([10.0, NAN, 2.5, 0.0, 0.0])}),
        (11, [], [], {"settings": np.array([10.0, 30.0, 2.5, 2.0, 0.0])}),
        (11, [], [], {"settings": np.array([10.0, 30.0, 2.5, 0.5, 0.0])}),
        (11, [], [], {"settings": np.array([10.0, 30.0, 2.5, 0.0, -1.0])}),
        (12, [], [], {"n_columns": 13}),
        (12, [FRICTION], [], {}),
    ],
)
def test_refused_arguments_of_a_sweep(
    argument: int, one: list[Any], two: list[Any], changes: dict[str, Any]
) -> None:
    info, rotation = sweep_info(record_of(*one), record_of(*two), **changes)
    assert info == -100 - argument
    assert np.isnan(rotation).all()


def test_bodies_of_other_numbers_of_sites_are_refused() -> None:
    words = _core.flankload_status_text
    changes = {
        "site_angles": np.zeros(1),
        "deviations": np.zeros(1),
        "block": np.ones((1, 1), dtype=np.intc, order="F"),
    }
    assert sweep_info(record_of(), record_of(**changes))[0] == -110
    assert words(-110) == b"flankload_sweep: record_2: expected 2 sites, found 1"
    # regression: "argument 3" was the text of the status of a contact problem
    assert sweep_info(record_of(**changes), record_of())[0] == -103
    assert words(-103) == b"flankload_sweep: n_sites: expected 1, found 2"


@pytest.mark.parametrize(
    ("argument", "values"),
    [
        (2, SHAFT[:36]),
        (3, np.append(SHAFT[:36], NAN)),
        (3, np.append(-SHAFT[:36], 0.5)),
        (3, np.append([0.0, 1e-9], SHAFT[2:])),
    ],
)
def test_refused_shafts(argument: int, values: Any) -> None:
    """A compliance is symmetric, and no section moves against its load."""
    record = np.append(record_of(), np.zeros(50))
    assert part_info("shaft", values, record) == -100 - argument


def test_a_rigid_body_needs_no_nodes() -> None:
    assert sweep_info(record_of(NODES), record_of(**RIGID))[0] == 0
    assert sweep_info(record_of(**RIGID), record_of(NODES))[0] == 0


def test_columns_of_pairs_hold_what_they_say() -> None:
    """Places on both arcs, unit normals, forces that balance the torque, gaps at unloaded pairs."""
    names = (*COLUMNS, *FRICTION_COLUMNS)
    room, mu = 200, 0.1
    site, table = np.zeros(room, dtype=np.intc), np.empty(room * len(names))
    rubbing, turn_2 = record_of(("friction", [1.0, mu, mu])), np.pi + 0.1
    motion = np.array([[0.1], [turn_2], [1.0], [-0.5]], order="F")
    motion[0] += sweep_info(rubbing, record_of(), n_columns=13, motion=motion)[1][0, 0]
    arguments = {"pair_site": site, "pair_table": table, "n_columns": len(names), "motion": motion}
    info, _ = sweep_info(rubbing, record_of(), **arguments)
    assert info == 0
    n = int(np.count_nonzero(site))
    assert (site[:n] == 1).all()
    column = dict(zip(names, table.reshape(room, -1)[:n].T, strict=True))
    place = np.array([column["x"], column["y"]])
    np.testing.assert_allclose(np.hypot(*place), column["radius"], rtol=SOLVER)
    np.testing.assert_allclose(np.hypot(column["normal_x"], column["normal_y"]), 1.0, rtol=SOLVER)
    for axis, angle in ((0.0, motion[0, 0]), (72.0, turn_2)):
        cosine, sine = np.cos(angle), np.sin(angle)
        centre = np.array([axis + 36.0 * cosine + 20.0 * sine, 36.0 * sine - 20.0 * cosine])
        np.testing.assert_allclose(np.hypot(*(place - centre[:, None])), 20.0, rtol=PLACE)
    for s in ("s_1", "s_2"):
        assert ((column[s] > 0.0) & (column[s] < 12.0)).all()
    np.testing.assert_allclose(np.diff(column["s_1"]), column["cell"][0], rtol=0.01)
    assert column["force"] @ column["lever"] == pytest.approx(3600.0, rel=SOLVER)
    carries = column["force"] > 0.0
    assert 0 < carries.sum() < n
    assert np.abs(column["gap"][carries]).max() < 1e-12
    assert column["gap"][~carries].min() > 1e-9
    np.testing.assert_allclose(np.abs(column["friction"]), mu, rtol=SOLVER)
    assert (np.sign(column["sliding"]) == np.sign(column["friction"])).all()


def test_columns_of_pairs_have_one_order() -> None:
    source = (FORTRAN / "position" / "position_sweep.f90").read_text(encoding="utf-8")
    columns = re.findall(r"enumerator :: column_(\w+)", source)
    assert columns == [*COLUMNS, *FRICTION_COLUMNS]


def test_parts_have_one_order() -> None:
    source = (FORTRAN / "position" / "body_record.f90").read_text(encoding="utf-8")
    assert re.findall(r"enumerator :: part_(\w+)", source) == [*NAMES]


# --- the record of a mesh -------------------------------------------------------------------------
SETTINGS = [10.0, 30.0, 2.5, 0.0, 0.0]
AXES = np.array([[0.0, 72.0], [0.0, 0.0]], order="F")


def mesh_of(
    *parts: tuple[str, Any], settings: Any = SETTINGS, twist: float = 0.0
) -> NDArray[np.float64]:
    """Record of the mesh of both cylinders, with parts."""
    arguments = (SITES, AXES, twist, np.array(settings))
    values = [np.array(value, dtype=float).ravel(order="F") for _, value in parts]
    needed = _core.flankload_pack_mesh(*arguments, np.empty(0))
    record = np.empty(needed + sum(value.size for value in values))
    assert _core.flankload_pack_mesh(*arguments, record) == 0
    for (name, _), value in zip(parts, values, strict=True):
        assert part_info(name, value, record) == 0
    return record


def sweep_of_mesh(
    mesh: NDArray[np.float64], *bodies: NDArray[np.float64], **changes: Any
) -> tuple[Any, ...]:
    """Outputs of `flankload_sweep_mesh`; body 2 is body 1 turned over."""
    torques = changes.get("torques", np.array([3600.0]))
    unknown = np.zeros((1, torques.size), dtype=np.intc, order="F")
    arguments: dict[str, Any] = {
        "n_sites": SITES,
        "motion": np.array([[0.0], [np.pi], [1.0], [-1.0]], order="F"),
        "torques": torques,
        "mesh": mesh,
        "record_1": bodies[0],
        "record_2": bodies[1],
        "n_columns": 11,
        "control": np.zeros(2, dtype=np.intc),
        "pair_site": np.empty(0, dtype=np.intc),
        "pair_table": np.empty(0),
        "in_contact": np.empty(0, dtype=np.intc),
        "n_known": unknown,
        "first_known": unknown,
    }
    found: tuple[Any, ...] = _core.flankload_sweep_mesh(*(arguments | changes).values())
    return found


def mesh_info(
    mesh: NDArray[np.float64], *bodies: NDArray[np.float64], **changes: Any
) -> tuple[int, NDArray[np.float64]]:
    """Like `sweep_info`, with a record of the mesh."""
    outputs = sweep_of_mesh(mesh, *bodies, **changes)
    return int(outputs[-1]), outputs[1]


@pytest.mark.parametrize(
    ("part", "settings", "n_columns"),
    [
        ((), SETTINGS, 11),
        ((FRICTION,), SETTINGS, 13),
        ((EDGES,), [*SETTINGS[:3], 1.0, 0.0], 11),
        ((SIDES,), SETTINGS, 11),
    ],
    ids=["plane", "friction", "slices", "sides"],
)
def test_a_mesh_has_its_own_record(part: Any, settings: Any, n_columns: int) -> None:
    """Bitwise as with its parts in the record of body 1, which are an error beside it."""
    names = dict(part)
    own = [("axial", AXIAL)] if "slices" in names else []
    if "friction" in names:
        part = (("friction", [1.0, 0.1, 0.1]),)
    one, two = record_of(*own), record_of(*own)
    twist = AXIAL[3] if own else 0.0
    info, found = mesh_info(
        mesh_of(*part, settings=settings, twist=twist), one, two, n_columns=n_columns
    )
    together = record_of(*own, *part)
    assert info == 0
    assert np.isfinite(found).all()
    wanted = sweep_info(together, two, settings=np.array(settings), n_columns=n_columns)
    assert wanted[0] == 0
    np.testing.assert_array_equal(found, wanted[1])
    if part:
        assert mesh_info(mesh_of(settings=settings), together, two)[0] == -109


@pytest.mark.parametrize(
    ("argument", "arguments"),
    [
        (1, (0, AXES, 0.0, SETTINGS)),
        (2, (SITES, np.full((2, 2), NAN, order="F"), 0.0, SETTINGS)),
        (3, (SITES, AXES, NAN, SETTINGS)),
        (4, (SITES, AXES, 0.0, [0.0, *SETTINGS[1:]])),
        (4, (SITES, AXES, 0.0, [*SETTINGS[:3], 2.0, 0.0])),
        (4, (SITES, AXES, 0.0, [*SETTINGS[:3], 0.5, 0.0])),
        (4, (SITES, AXES, 0.0, [*SETTINGS[:4], -1.0])),
        (4, (SITES, AXES, 0.0, [*SETTINGS[:4], 1.5])),
    ],
)
def test_refused_arguments_of_a_mesh(argument: int, arguments: Any) -> None:
    record = np.full(200, 7.0)
    assert _core.flankload_pack_mesh(*arguments, record) == -100 - argument
    assert (record == 7.0).all()


def test_records_of_bodies_and_meshes_are_not_exchanged() -> None:
    mesh, body = mesh_of(), record_of()
    assert mesh_info(body, body, body)[0] == -107
    assert mesh_info(mesh, mesh, body)[0] == -109
    assert mesh_info(mesh, body, mesh)[0] == -111
    assert mesh_info(mesh, body, record_of(SIDES))[0] == -111
    # parts of a body have no place in the record of a mesh
    assert part_info("wedge", [0.0, 0.1], mesh) == -101
    # as many sites as both bodies
    long = np.empty(200)
    assert _core.flankload_pack_mesh(SITES + 1, AXES, 0.0, np.array(SETTINGS), long) == 0
    assert mesh_info(long, body, body)[0] == -103
    assert sweep_info(body, body, center_distance=NAN)[0] == -105


def test_slices_carry_on_both_flanks() -> None:
    """Lumped contacts beside cells; pressed by 10 um, with and without torque, helical, on a shaft.

    Sites 1 and 2 are slices of the working flank, 3 and 4 of the coast flank. Without torque and
    without twist, both flanks are mirror images of each other.
    """
    block = np.ones((4, 4), dtype=np.intc, order="F")
    for twist in (0.0, 2e-3):
        axial = [*AXIAL[:3], twist, *AXIAL[4:]]
        turns = twist * np.array([-0.5, 0.5, 0.5, -0.5])  # mirrored on coast flanks
        bodies = [
            record_of(
                ("axial", axial if z == 1 else [*axial[:3], -twist, *axial[4:]]),
                ("shaft", SHAFT),
                site_angles=turns if z == 1 else -turns,
                deviations=np.full(4, 5e-3),
                block=block,
            )
            for z in (1, 2)
        ]
        forces = {}
        for level in (0.0, 1.0):
            settings = np.array([*SETTINGS[:3], level, 0.0])
            mesh = np.empty(300)
            assert _core.flankload_pack_mesh(4, AXES, twist, settings, mesh) == 0
            assert part_info("slices", [-1.0, 0.0, 1.0], mesh) == 0
            assert part_info("sides", [1.0, 1.0, -1.0, -1.0], mesh) == 0
            outputs = sweep_of_mesh(mesh, *bodies, n_sites=4, torques=np.array([0.0, 3600.0]))
            assert outputs[-1] == 0
            forces[level] = outputs[5][:, 0, :]
        np.testing.assert_allclose(forces[1.0], forces[0.0], rtol=2e-2)
        if not twist:
            np.testing.assert_allclose(forces[1.0][:2, 0], forces[1.0][2:, 0], rtol=SOLVER)
