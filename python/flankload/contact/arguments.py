"""Validation of the arguments of the contact loop, with one error line that names them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flankload.errors import InputError

Vector = NDArray[np.float64]


def array(name: str, values: Any, n_axes: int | None, *, finite: bool = True) -> Vector:
    """Double-precision numbers, or an InputError that names the argument."""
    try:
        given = np.asarray(values)
        real = not np.iscomplexobj(given)
        # a cast would drop imaginary parts without a warning
        numbers = given.astype(np.float64, copy=False) if real else np.empty(0)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected an array of numbers, found {error}") from None
    if not real:
        raise InputError(f"{name}: expected real numbers, found {given.dtype}")
    if n_axes and numbers.ndim == 0:
        shape = "(n,)" if n_axes == 1 else "(n, n)"
        raise InputError(f"{name}: expected an array of shape {shape}, found a single number")
    if n_axes is not None and numbers.ndim != n_axes:
        kind = ("a number", "1 axis")[n_axes] if n_axes < 2 else f"{n_axes} axes"
        raise InputError(f"{name}: expected {kind}, found shape {numbers.shape}")
    if finite:
        expect_finite(name, numbers)
    return numbers


def expect_finite(name: str, numbers: Vector) -> None:
    """Raise an InputError if a number is NaN or infinite."""
    # The sum of squares is the fastest check; if it overflows, each number is checked.
    flat = numbers.ravel(order="K")
    if not np.vdot(flat, flat) < np.inf and not np.isfinite(flat).all():
        place = np.argwhere(~np.isfinite(numbers))[0].tolist()
        found = numbers[tuple(place)]
        at = f" at {place}" if place else ""
        raise InputError(f"{name}: expected finite numbers, found {found}{at}")


def expect_shape(name: str, numbers: Vector, shape: tuple[int, ...]) -> None:
    """Raise an InputError if the shape differs from the expected one."""
    if numbers.shape != shape:
        raise InputError(f"{name}: expected shape {shape}, found {numbers.shape}")


def columns(name: str, values: ArrayLike, shape: tuple[int, int]) -> Vector:
    """An array with one column per motion; a vector is one column."""
    result = array(name, values, None)
    if result.ndim == 1 and shape[1] == 1:
        result = result[:, np.newaxis]
    expect_shape(name, result, shape)
    return result


def pair_numbers(warm_pairs: ArrayLike | Sequence[int] | None, n: int) -> NDArray[np.int32]:
    """Distinct numbers of pairs, from 0."""
    if warm_pairs is None:
        return np.empty(0, dtype=np.int32)
    pairs = np.asarray(warm_pairs)
    if pairs.size == 0:
        return np.empty(0, dtype=np.int32)
    if pairs.ndim != 1 or not np.issubdtype(pairs.dtype, np.integer):
        raise InputError(
            f"warm_pairs: expected a list of integers, found shape {pairs.shape} of {pairs.dtype}"
        )
    if pairs.min() < 0 or pairs.max() >= n:
        raise InputError(
            f"warm_pairs: expected numbers from 0 to {n - 1}, found {pairs.min()} to {pairs.max()}"
        )
    if np.unique(pairs).size != pairs.size:
        raise InputError("warm_pairs: expected each pair once, found a pair twice")
    return pairs.astype(np.int32)
