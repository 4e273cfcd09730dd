"""Halving: to the last bit, and refused without a change of sign."""

from __future__ import annotations

from math import cos, nextafter, pi

import pytest

from flankload.bodies.bisection import sign_change


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_change_of_sign_is_found_to_the_last_bit(sign: float) -> None:
    found = sign_change(lambda x: sign * cos(x), 0.0, 3.0)
    assert nextafter(0.5 * pi, 0.0) <= found <= nextafter(0.5 * pi, 4.0)


@pytest.mark.parametrize("ends", [(-2.0, 1.0), (1.0, 5.0)])
def test_an_end_may_be_the_place(ends: tuple[float, float]) -> None:
    assert sign_change(lambda x: x - 1.0, *ends) == 1.0


def test_like_signs_are_refused() -> None:
    with pytest.raises(ValueError, match="expected opposite signs, found 1 and 4"):
        sign_change(lambda x: x * x, 1.0, 2.0)
