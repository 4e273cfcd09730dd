"""The list of faults that `./dev mutate` puts in fits the sources."""

from __future__ import annotations

from tests.mutations.faults import CORE, FAULTS
from tests.support.paths import ROOT


def test_every_fault_has_its_place_and_its_tests() -> None:
    assert len(FAULTS) >= 60
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)
    for fault in FAULTS:
        text = (ROOT / fault.file).read_text(encoding="utf-8")
        assert text.count(fault.before) == 1, (
            f"occurs {text.count(fault.before)} times: {fault.name}"
        )
        assert fault.after != fault.before, fault.name
        for owner in fault.owners:
            path = ROOT / owner.split("::")[0]
            assert owner == CORE or path.exists(), f"no such tests: {owner}"
