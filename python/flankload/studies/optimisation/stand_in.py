"""Private stand-in for sensitivities by differences."""

from __future__ import annotations

import numpy as np

from flankload.errors import FlankloadError


def _t(r):
    return r if isinstance(r, tuple) else (r,)


class Sensitivity:
    def __init__(self, prepared, paths):
        self.results = _t(prepared.solve())
        tree = prepared.scene
        self._sides = []
        for path in paths:
            x = value_at(tree, path)
            h = 1e-4 * max(abs(x), 1.0)
            sides = []
            for y in (x + h, x - h):
                try:
                    sides.append((y, _t(prepared.solve({path: y}))))
                except FlankloadError:
                    sides.append((x, self.results))
            self._sides.append(sides)

    def derivative(self, quantity):
        def q(r):
            if callable(quantity):
                return np.asarray(quantity(r), float)
            if quantity in r.summary:
                return np.asarray(r.summary[quantity], float)
            return np.asarray(getattr(r, quantity), float)

        return np.array(
            [
                [(q(a) - q(b)) / (ya - yb) for a, b in zip(ra, rb)]
                for (ya, ra), (yb, rb) in self._sides
            ]
        )


def value_at(scene, path):
    import re

    x = scene
    for part in re.findall(r"\w+", path):
        x = x[int(part)] if part.isdigit() else getattr(x, part)
    return float(x)


def sensitivity(prepared, paths):
    return Sensitivity(prepared, paths)
