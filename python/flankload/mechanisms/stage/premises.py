"""Premises of the model that a planetary stage can violate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.several.premises import broken_rims_and_ratios

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.stage.assembly import StageAssembly


def broken_by_geometry(assembly: StageAssembly) -> Iterator[Broken]:
    """Premises that are violated at any load: rims, contact ratios."""
    key = "pair.center_distance_mm"
    yield from broken_rims_and_ratios(
        assembly,
        [(0, "sun and planets", key), (assembly.pairing.count, "planets and ring", key)],
    )
