"""No count depends on a last bit: quotients that are integers in exact arithmetic, and kernels
of BLAS, which sum in orders of their own."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from math import inf

import numpy as np
import pytest

import flankload as fl
from flankload.base.number_text import percent
from flankload.base.rounding import round_down, round_up
from flankload.meshes.blocks import even_breaks, growing_breaks
from tests.support.kernel_counts import pairs_in_contact
from tests.support.paths import ROOT
from tests.support.tolerances import SOLVER

#: Peaks of pressure follow from the inverse of influence numbers, with rounding of 1e-10.
PEAK = 1e-7
#: Kernels that every processor with AVX2 has; others are only slower where it has not.
KERNELS = ("Nehalem", "Sandybridge", "Haswell")


def beside(value: float, ulps: int) -> float:
    """A number so many representable ones further on."""
    for _ in range(abs(ulps)):
        value = float(np.nextafter(value, np.sign(ulps) * inf))
    return value


@pytest.mark.parametrize("ulps", [-8, -1, 0, 1, 8])
def test_whole_numbers_are_whole_whatever_rounding_left(ulps: int) -> None:
    near = beside(25.0, ulps)
    assert round_down(near) == round_up(near) == 25
    assert round_down(beside(-0.5 + 0.5, ulps)) == 0
    assert round_up(np.array([near, 25.1])).tolist() == [25, 26]
    assert round_down(np.array([near, 24.9])).tolist() == [25, 24]


@pytest.mark.parametrize("ulps", [-3, -1, 0, 1, 3])
def test_number_of_elements_does_not_hang_on_a_bit(ulps: int) -> None:
    assert even_breaks(0.0, beside(2.1, ulps), 0.3).size == 8
    # parts of 0.3, 0.6, 1.2 fill the length; a half part that sticks out stays
    assert growing_breaks(beside(2.1, ulps), 0.3, 2.0, None).size == 4
    assert growing_breaks(beside(3.3, ulps), 0.3, 2.0, None).size == 5


@pytest.mark.parametrize("name", ["external", "friction", "ring", "spline"])
def test_no_number_of_cells_hangs_on_the_last_bit_of_the_torque(name: str) -> None:
    scene = pairs_in_contact()[name]
    torque = float(scene["load"]["torque_Nm"])
    load = {"torque_Nm": [beside(torque, ulps) for ulps in range(-4, 5)]}
    several = fl.solve(fl.Scene.from_dict({**scene, "load": load})).by_torque
    cells = [[table.site.tolist() for table in result.pair_tables] for result in several]
    assert cells == [cells[0]] * len(several)


#: Begins with a product of columns in Fortran order, in which the OpenBLAS 0.3.34 of numpy 2.5
#: crashes with the kernel Haswell on a processor of the kind SkylakeX.
SCRIPT = """
import json, sys
import numpy as np
columns = np.ones((480, 40), order="F")
columns.T @ columns.copy(order="F")
print("multiplied", flush=True)
import flankload as fl
from tests.support.kernel_counts import counted, pairs_in_contact
found = {}
for name, scene in pairs_in_contact().items():
    result = fl.solve(fl.Scene.from_dict(scene))
    found[name] = {
        "counters": counted(result),
        "rotation": result.rotation_rad.tolist(),
        "force": result.site_force_N.tolist(),
        "peak": result.peak_pressure_MPa.tolist(),
    }
json.dump(found, sys.stdout)
"""


def _kernel_environment(kernel: str) -> dict[str, str]:
    return {**os.environ, "OPENBLAS_CORETYPE": kernel, "OPENBLAS_NUM_THREADS": "1"}


@pytest.mark.skipif(platform.machine() != "x86_64", reason="kernels of x86-64")
def test_every_kernel_of_blas_counts_alike() -> None:
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", SCRIPT],
            stdout=subprocess.PIPE,
            env=_kernel_environment(kernel),
            cwd=ROOT,
        )
        for kernel in KERNELS
    ]
    printed = [run.communicate()[0].splitlines() for run in runs]
    # without a line the product has crashed
    first, *others = [json.loads(line) for _, line in filter(None, printed)]
    assert others
    for other in others:
        for name, expected in first.items():
            found = other[name]
            assert found["counters"] == expected["counters"]
            for key, tolerance in (("rotation", SOLVER), ("force", SOLVER), ("peak", PEAK)):
                scale = np.abs(expected[key]).max()
                np.testing.assert_allclose(
                    found[key], expected[key], rtol=0, atol=tolerance * scale
                )


def test_percentages_have_no_exponent() -> None:
    """Regression: the error of a quantity near zero was printed as 4.7e+02 %."""
    assert [percent(part) for part in (4.7123, 0.1, 0.00123, 1e-15)] == [
        "470 %",
        "10 %",
        "0.12 %",
        "0 %",
    ]
