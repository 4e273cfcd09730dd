"""What estimates tell of the quantities that a tolerance binds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.steering.laws import BOUND

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.result import Result

    Errors = dict[str, float]

#: It is bound as part of the largest transmission error, not of itself: a curve that hardly varies
#: need not be known to a part of nothing.
OF_LARGEST = "transmission_error_peak_to_peak"


def told_by_source(results: Sequence[Result]) -> dict[str, Errors] | None:
    """Errors by source and bound quantity, the largest over the torques.

    Each is what its source alone would leave. Sources may cancel: they do not add up to `told`.

    Parameters
    ----------
    results : sequence of Result
        Of one scene.

    Returns
    -------
    dict of dict, or None
        None where nothing is estimated.
    """
    found: dict[str, Errors] = {}
    known = [result for result in results if result.estimate is not None]
    for result in known:
        assert result.estimate is not None
        for source, errors in _one_of_elements(result.estimate["by_source"]).items():
            row = found.setdefault(source, dict.fromkeys(BOUND, 0.0))
            for quantity, error in _bound(errors, result).items():
                row[quantity] = max(row[quantity], error)
    return found if known else None


def _one_of_elements(by_source: Mapping[str, Mapping[str, float]]) -> dict[str, Errors]:
    """Elements of both bodies are turned by one knob: one source, where they are told apart."""
    found: dict[str, Errors] = {}
    for source, errors in by_source.items():
        row = found.setdefault("elements" if source.startswith("elements") else source, {})
        for quantity, error in errors.items():
            row[quantity] = float(np.hypot(row.get(quantity, 0.0), error))
    return found


def told(results: Sequence[Result]) -> Errors:
    """Errors of the bound quantities, the largest over the torques.

    Parameters
    ----------
    results : sequence of Result

    Returns
    -------
    dict of str to float
        Those that are estimated.
    """
    found: Errors = {}
    for result in results:
        for quantity, error in _bound(result.estimate or {}, result).items():
            found[quantity] = max(found.get(quantity, 0.0), error)
    return found


def _bound(errors: Any, result: Result) -> Errors:
    """Bound quantities of a table of the estimate."""
    found = {quantity: float(errors[quantity]) for quantity in BOUND if quantity in errors}
    if OF_LARGEST in found:
        found[OF_LARGEST] *= _variation(result)
    return found


def _variation(result: Result) -> float:
    """Peak to peak of the transmission error over its largest amount."""
    curve = result.transmission_error_um
    largest = float(np.abs(curve).max())
    return float(np.ptp(curve)) / largest if largest > 0 else 0.0
