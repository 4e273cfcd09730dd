"""Drawing data of both bodies, as on a data sheet; each kind of drive fills it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SheetRow:
    """A line of a data sheet.

    Attributes
    ----------
    name, symbol : str
        Quantity and its symbol (ISO 21771 for involutes); the symbol may be empty.
    value : str
        Number with its unit.
    """

    name: str
    symbol: str
    value: str


@dataclass(frozen=True)
class PathPoint:
    """A point of the path of contact.

    Attributes
    ----------
    name : str
        A to E: start, end of single contact before, pitch point, start of single contact behind,
        end.
    path_mm : float
        Distance from the pitch point along the line of action, in the sense of motion.
    diameters_mm, roll_angles_deg : (float, float)
        Diameters and roll angles of both flanks at this point.
    """

    name: str
    path_mm: float
    diameters_mm: tuple[float, float]
    roll_angles_deg: tuple[float, float]


@dataclass(frozen=True)
class DataSheet:
    """Drawing data of two bodies and of their pair.

    Attributes
    ----------
    kinds : (str, str)
        Kinds of both bodies.
    bodies : two tuples of SheetRow
    path : tuple of PathPoint
        Empty unless both flanks are involutes that roll on each other.
    """

    kinds: tuple[str, str]
    bodies: tuple[tuple[SheetRow, ...], tuple[SheetRow, ...]]
    pair: tuple[SheetRow, ...]
    path: tuple[PathPoint, ...] = ()
