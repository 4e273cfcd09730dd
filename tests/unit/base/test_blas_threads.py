"""One thread for BLAS: the old number comes back when the last thread of Python has left."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from flankload.base.blas_threads import one_blas_thread


def numbers() -> set[int]:
    """Counts of libraries with one count per process; with OpenMP each thread has its own."""
    found = [part for part in threadpool_info() if part["user_api"] == "blas"]
    return {part["num_threads"] for part in found if part["threading_layer"] != "openmp"}


def test_threads_that_overlap_restore_the_number_of_blas_threads() -> None:
    """Regression: two bodies in three dimensions at once left BLAS at one thread."""
    np.ones((2, 2)) @ np.ones((2, 2))
    entered, left = threading.Event(), threading.Event()

    def second() -> None:
        with one_blas_thread():
            entered.set()
            left.wait()

    with threadpool_limits(2, user_api="blas"):
        if numbers() != {2}:
            pytest.skip("BLAS without threads")
        thread = threading.Thread(target=second)
        with one_blas_thread():
            thread.start()
            entered.wait()
        assert numbers() == {1}  # the other thread is still inside
        left.set()
        thread.join()
        assert numbers() == {2}
