"""Common tables and rules of chain and belt drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from flankload.scene.refusal import refuse, shown
from flankload.scene.table import BodyTable, EvenBody

if TYPE_CHECKING:
    from flankload.scene.scene import SceneFile


class DriveTable(EvenBody, frozen=True, kw_only=True):
    """A body of a chain or belt drive."""

    is_drive: ClassVar[bool] = True


class WrappedTable(DriveTable, frozen=True, kw_only=True):
    """A chain or a belt, which is wrapped around body 1.

    Attributes
    ----------
    known : mapping of str to frozenset of str
        Keys of [positions] and [accuracy] that the drive accepts.
    no_pair : str
        Reason why the scene has no table [pair].
    """

    known: ClassVar[Mapping[str, frozenset[str]]] = {}
    no_pair: ClassVar[str] = ""

    def check_around(self, body_1: BodyTable, given: Mapping[str, Any]) -> None:
        """Check that the chain or belt fits its wheel; `given`: keys of body 1 in the scene."""


def check_drive(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Refuse keys that do not apply to drives, or only to them; `given`: scene as in the file."""
    body_1, body_2, slack = asked.body_1, asked.body_2, asked.load.slack_tension_N
    if not isinstance(body_2, WrappedTable):
        if slack is not None:
            kind = body_2.kind
            refuse("load.slack_tension_N", f"nothing: a {kind} has no slack strand", f"{slack:g}")
        if asked.pair is None:
            refuse("pair", "a table", "nothing")
        return
    body_2.check_around(body_1, given.get("body_1", {}))
    if slack is None:
        expected = f"a number > 0: the tension of the slack strand of the {body_2.kind}"
        refuse("load.slack_tension_N", expected, "nothing")
    if asked.pair is not None:
        refuse("pair", f"nothing: {body_2.no_pair}", "a table")
    for table, known in body_2.known.items():
        for key, value in given.get(table, {}).items():
            if key == "plane" and not body_1.rigid:
                continue  # for the elements of body 1
            if key not in known:
                expected = f"nothing: it does not apply to a {body_2.kind} and its {body_1.kind}"
                refuse(f"{table}.{key}", expected, shown(value))
