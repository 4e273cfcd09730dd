"""REXS files: XML (.rexs), JSON (.rexsj), or one of them in a ZIP archive (.rexsz, .rexs.zip)."""

from __future__ import annotations

import json
import re
import zipfile
import zlib
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn
from xml.etree import ElementTree

from flankload.errors import SceneError
from flankload.exchange.rexs.parts import Builder, json_model, xml_model

if TYPE_CHECKING:
    from flankload.exchange.rexs.model import Model

#: Largest model, bytes, unpacked: a gearbox of a hundred gears with all results has 20 MB.
LARGEST = 64 * 2**20
XML, JSON, ZIP = (".rexs", ".xml"), (".rexsj", ".json"), (".rexsz", ".zip")


def read_model(path: str | Path) -> Model:
    """Read a REXS file: .rexs (XML), .rexsj (JSON), .rexsz or .rexs.zip (ZIP with one of these).

    Raises SceneError if the file cannot be read, is too large, is not well-formed, or is no REXS
    model of version 1; if an id is used twice or a relation refers to a component that is missing.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in XML + JSON + ZIP:
        _refuse(path, "a REXS file (.rexs, .rexsj, .rexsz)", path.name)
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST + 1)
    except OSError as error:
        _refuse(path, "a REXS file to read", (error.strerror or str(error)).lower())
    if len(data) > LARGEST:
        _refuse(path, f"at most {LARGEST >> 20} MiB", "a larger file")
    if suffix in ZIP:
        suffix, data = _unpacked(path, data)
    return _json(path, data) if suffix in JSON else _xml(path, data)


def _unpacked(path: Path, data: bytes) -> tuple[str, bytes]:
    """Suffix and content of the only model in an archive."""
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            models = [
                info
                for info in archive.infolist()
                if info.filename.lower().endswith((".rexs", ".rexsj"))
            ]
            if len(models) != 1:
                _refuse(path, "one file .rexs or .rexsj in the archive", f"{len(models)}")
            with archive.open(models[0]) as member:
                # the header of a member may understate its size
                content = member.read(LARGEST + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError) as error:
        _refuse(path, "a ZIP archive", str(error).lower() or type(error).__name__)
    except (RuntimeError, NotImplementedError) as error:
        _refuse(path, "a ZIP archive without encryption, compressed by deflate", str(error))
    if len(content) > LARGEST:
        _refuse(path, f"a model of at most {LARGEST >> 20} MiB", "a larger one in the archive")
    return Path(models[0].filename).suffix.lower(), content


def _xml(path: Path, data: bytes) -> Model:
    parser = ElementTree.XMLParser(target=Builder(path))
    try:
        parser.feed(data)
        root = parser.close()
    except ElementTree.ParseError as error:
        _refuse(path, "well-formed XML", str(error))
    except (LookupError, ValueError) as error:  # an unknown encoding
        _refuse(path, "XML in UTF-8", str(error))
    return xml_model(path, root)


def _json(path: Path, data: bytes) -> Model:
    try:
        tree = json.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        _refuse(path, "text in UTF-8", f"byte 0x{error.object[error.start]:02x}")
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        _refuse(path, "valid JSON", f"{place}: {error.msg.lower()}")
    except RecursionError:
        _refuse(path, "JSON of a few levels", "too many levels")
    except ValueError as error:  # an integer of thousands of digits
        _refuse(path, "valid JSON", re.sub(r";.*", "", str(error)).lower())
    return json_model(path, tree)


def _refuse(path: Path, expected: str, found: str) -> NoReturn:
    raise SceneError(file=path, key="file", expected=expected, found=found)
