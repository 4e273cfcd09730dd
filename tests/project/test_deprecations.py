"""Deprecations: an error where the package calls what is deprecated, a word where others do."""

from __future__ import annotations

import warnings

import pytest


def deprecated_in(module: str) -> None:
    warnings.warn_explicit("old", DeprecationWarning, "some.py", 1, module=module)


@pytest.mark.parametrize("module", ["flankload", "flankload.plot.style"])
def test_deprecations_of_the_package_are_errors(module) -> None:
    with pytest.raises(DeprecationWarning):
        deprecated_in(module)


@pytest.mark.parametrize("module", ["matplotlib._fontconfig_pattern", "flankloader"])
def test_deprecations_of_other_packages_are_not(module) -> None:
    with warnings.catch_warnings(record=True) as said:
        deprecated_in(module)
    assert [str(warning.message) for warning in said] == ["old"]


def test_other_warnings_are_errors_wherever_they_come_from() -> None:
    with pytest.raises(RuntimeWarning):
        warnings.warn_explicit("odd", RuntimeWarning, "some.py", 1, module="scipy")
