"""Puts the licence texts of the libraries that a wheel carries into the wheel.

bundled_licenses.py WHEEL, on the machine (Debian, Ubuntu) whose libraries were put into it.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

NAME = "LICENSES_bundled.txt"
DOCUMENTS, COMMON = Path("/usr/share/doc"), Path("/usr/share/common-licenses")
#: Texts that the notices of the packages only point to; others there are of documents and tests.
POINTED_TO = re.compile(r"common-licenses/((?:GPL-3|LGPL-2\.1|LGPL-3)\b)")


def bundled(wheel: ZipFile) -> list[str]:
    """Shared libraries beside the package, as the wheel names them."""
    return sorted(name for name in wheel.namelist() if re.match(r"\w+\.libs/lib", name))


def stem(name: str) -> str:
    """libgfortran of libgfortran-91cc3cb1.so.5, as of libgfortran.so.5.0.0."""
    return re.split(r"[-.]", Path(name).name)[0]


def package_of(library: str) -> str:
    """The Debian package that a bundled library came from."""
    printed = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=True).stdout
    known = [line.split(" => ")[1] for line in printed.splitlines() if " => " in line]
    for path in known:
        real = os.path.realpath(path)
        if stem(library) not in (stem(path), stem(real)):
            continue
        # On a machine with merged folders the package may know the file by its old one.
        for place in (real, real.removeprefix("/usr")):
            asked = ["dpkg-query", "--search", place]
            found = subprocess.run(asked, capture_output=True, text=True, check=False)
            if found.returncode == 0:
                return found.stdout.split(":")[0]
    raise SystemExit(f"bundled_licenses: no package has {library}, so its licence is unknown")


def text_of(libraries: list[str]) -> str:
    """Who is inside under which licence, then the notices of the packages, each once."""
    packages = {library: package_of(library) for library in libraries}
    notices: dict[str, list[str]] = {}
    for package in packages.values():
        text = (DOCUMENTS / package / "copyright").read_text(encoding="utf-8")
        if package not in notices.setdefault(text, []):
            notices[text].append(package)
    head = ["This wheel of flankload carries these libraries, unchanged:", ""]
    head += [f"  {library}  (Debian package {package})" for library, package in packages.items()]
    parts = ["\n".join(head)]
    parts += [f"Notice of {', '.join(names)}\n\n{text}" for text, names in notices.items()]
    pointed = {name for text in notices for name in POINTED_TO.findall(text)}
    parts += [f"{name}\n\n{(COMMON / name).read_text('utf-8')}" for name in sorted(pointed)]
    return f"\n\n{'=' * 80}\n".join(parts)


def add(path: Path) -> None:
    """Write the wheel anew, with the texts, named in its metadata and its record."""
    with ZipFile(path) as wheel:
        contents = {info.filename: (info, wheel.read(info)) for info in wheel.infolist()}
        text = text_of(bundled(wheel))
    [record] = [name for name in contents if name.endswith(".dist-info/RECORD")]
    folder = record.rpartition("/")[0]
    place, metadata = f"{folder}/licenses/{NAME}", f"{folder}/METADATA"
    described = contents[metadata][1].replace(
        b"License-File: LICENSE\n", f"License-File: LICENSE\nLicense-File: {NAME}\n".encode()
    )
    changed = {place: text.encode(), metadata: described}
    rows = [row for row in csv.reader(io.StringIO(contents[record][1].decode())) if row]
    rows = [row for row in rows if row[0] not in changed]
    for name, data in changed.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        rows.append([name, f"sha256={digest}", str(len(data))])
        info = contents[name][0] if name in contents else ZipInfo(name)
        info.external_attr = info.external_attr or 0o644 << 16
        contents[name] = (info, data)
    listed = io.StringIO()
    csv.writer(listed, lineterminator="\n").writerows(rows)
    contents[record] = (contents[record][0], listed.getvalue().encode())
    new = path.with_suffix(".new")
    with ZipFile(new, "w", ZIP_DEFLATED) as wheel:
        for info, data in contents.values():
            wheel.writestr(info, data, ZIP_DEFLATED)
    new.replace(path)


if __name__ == "__main__":
    add(Path(sys.argv[1]))
