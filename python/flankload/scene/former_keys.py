"""Keys of earlier versions, accepted once more with a warning."""

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Keys that no longer have an effect, with the reason; their values were Booleans.
WITHOUT_EFFECT = {
    "accuracy.unmodified_elements": "finite elements always follow the unmodified flanks"
}


def without_former_keys(tables: Mapping[str, Any], file: Path | None) -> Mapping[str, Any]:
    """Tables of a scene without the keys of earlier versions; each one found gives a warning."""
    for path, reason in WITHOUT_EFFECT.items():
        name, _, key = path.partition(".")
        table = tables.get(name) if isinstance(tables, Mapping) else None
        if isinstance(table, Mapping) and isinstance(table.get(key), bool):
            where = "" if file is None else f"{file}: "
            text = f"{where}{path} no longer has an effect ({reason}): remove it"
            warnings.warn(text, FutureWarning, stacklevel=2)
            tables = {**tables, name: {k: x for k, x in table.items() if k != key}}
    return tables
