"""Make references anew: ``python -m tests.regression [NAME …] [--check]``.

A name may be the beginning of several; without a name all are made. Changes are printed quantity
by quantity; with ``--check`` nothing is written.
"""

from __future__ import annotations

import sys

from .compare import movements, path_of, read_reference, reference_of, table, write_reference
from .contact_cases import contact_cases
from .nodal_cases import nodal_cases
from .scene_cases import scene_cases


def main(arguments: list[str]) -> int:
    """Make the selected references."""
    wanted = [argument for argument in arguments if argument != "--check"]
    cases = contact_cases() | nodal_cases() | scene_cases()
    names = [name for name in cases if not wanted or name.startswith(tuple(wanted))]
    if not names:
        print(f"no such reference; there are: {', '.join(cases)}", file=sys.stderr)
        return 2
    drifted = False
    for name in names:
        made = reference_of(name, cases[name])
        if path_of(name).exists():
            rows = [row for row in movements(read_reference(name), made) if row.moved > 0]
            drifted = drifted or any(row.is_drift for row in rows)
            print(table(name, rows) if rows else f"{name}: nothing moved")
        else:
            print(f"{name}: new")
        if "--check" not in arguments:
            write_reference(made)
    return int(drifted and "--check" in arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
