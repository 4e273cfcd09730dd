# SPDX-License-Identifier: BSD-3-Clause
# ruff: noqa: F403, F405
from spack.package import *


class PyFlankload(PythonPackage):
    """Load distribution on the flanks of two elastic bodies that turn about parallel axes."""

    # The project has no public address yet: a checkout is built by
    # spack dev-build -d CHECKOUT py-flankload@0.1.0
    version("0.1.0")

    depends_on("c", type="build")
    depends_on("fortran", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("openblas threads=openmp")

    depends_on("python@3.11:", type=("build", "run"))
    depends_on("py-meson-python@0.18:", type="build")
    depends_on("meson@1.3:", type="build")
    depends_on("ninja@1.10:", type="build")
    depends_on("py-numpy@2:", type=("build", "run"))
    depends_on("py-scipy@1.13:", type="run")
    depends_on("py-meshio@5.3.5:", type="run")
    depends_on("py-msgspec@0.20:", type="run")
    depends_on("py-matplotlib@3.8.4:", type="run")
    depends_on("py-jinja2@3.1:", type="run")
    depends_on("py-rich@13:", type="run")
    depends_on("py-threadpoolctl@3.1:", type="run")
