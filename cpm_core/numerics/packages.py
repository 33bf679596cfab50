"""Packages that are not installed with the program, since few files need them."""

from __future__ import annotations

from importlib.util import find_spec


class MissingPackageError(ValueError):
    """Something needs a package that is not installed."""

    def __init__(self, what: str, package: str) -> None:
        name = package.replace("_", "-")
        super().__init__(f"{what} needs the package {name}, which is not installed: run pip install {name}.")


def has_package(package: str) -> bool:
    """Return whether a package is installed."""
    return find_spec(package) is not None


def require_package(package: str, what: str) -> None:
    """Raise MissingPackageError, saying what to install, where a package is not installed that something needs."""
    if not has_package(package):
        raise MissingPackageError(what, package)
