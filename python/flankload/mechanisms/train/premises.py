"""Premises of the model that a gear train can violate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.several.premises import broken_rims_and_ratios

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.train.assembly import TrainAssembly

#: Keys of the centre distances of both meshes.
DISTANCES = ("pair.center_distance_mm", "train.center_distance_2_mm")


def broken_by_geometry(assembly: TrainAssembly) -> Iterator[Broken]:
    """Premises that are violated at any load: rims, contact ratios."""
    pairing = assembly.pairing
    yield from broken_rims_and_ratios(
        # the halves of double helical gears have one distance
        assembly,
        [(m, pairing.title(m), key) for m, key in enumerate(DISTANCES[: len(assembly.bodies) - 1])],
    )
