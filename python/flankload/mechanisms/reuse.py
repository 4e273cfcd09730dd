"""Parts of earlier runs that later ones reuse: bodies and compliances, by all they depend on."""

from __future__ import annotations

from collections import OrderedDict
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from flankload.base.digest import digest_of

if TYPE_CHECKING:
    from functools import partial

    T = TypeVar("T")

#: Largest number of parts that are held; the least recently used ones are dropped. A pair has four:
#: two bodies and their compliances.
MOST_PARTS = 64


class Parts:
    """Results of calls by the digest of the function and of all its arguments.

    A part is reused only for a call with the same bits, so a run gives the same bits with and
    without it.

    Parameters
    ----------
    most : int
        Largest number that is held.
    tangential, estimate : bool
        Whether all compliances are solved with loads along the flanks, and with the error of their
        elements: then runs with and without friction or estimates share them.
    """

    def __init__(
        self, most: int = MOST_PARTS, *, tangential: bool = False, estimate: bool = False
    ) -> None:
        self.tangential, self.estimate = tangential, estimate
        self._held: OrderedDict[bytes, Any] = OrderedDict()
        self._most = most

    def __len__(self) -> int:
        return len(self._held)

    def find(self, call: partial[Any]) -> tuple[bytes, Any]:
        """Key of a call of a stateless function, whose result is never None, and a held result."""
        key = digest_of(call)
        found = self._held.get(key)
        if found is not None:
            with suppress(KeyError):  # dropped by another thread in the meantime
                self._held.move_to_end(key)
        return key, found

    def add(self, key: bytes, part: object) -> None:
        """Hold the result of a call with this key."""
        self._held[key] = part
        while len(self._held) > self._most:
            self._held.popitem(last=False)


def made_once(call: partial[T], parts: Parts | None) -> T:
    """Result of a call, held for later runs in `parts` unless they are None."""
    if parts is None:
        return call()
    key, found = parts.find(call)
    if found is None:
        parts.add(key, found := call())
    part: T = found
    return part
