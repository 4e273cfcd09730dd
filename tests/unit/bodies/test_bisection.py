"""Changes of sign: to the last bit, in few steps, and refused without one."""

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


def test_a_smooth_function_takes_few_steps() -> None:
    places: list[float] = []

    def function(x: float) -> float:
        places.append(x)
        return cos(x)

    sign_change(function, 0.0, 3.0)
    assert len(places) < 20


def test_a_jump_is_found_to_the_last_bit() -> None:
    found = sign_change(lambda x: 1.0 if x > 0.123 else -1.0, 0.0, 1.0)
    assert nextafter(0.123, 0.0) <= found <= nextafter(0.123, 1.0)
