"""Packages that need not be installed, and the sentence that names the one that is missing."""

from __future__ import annotations

import importlib
from typing import Any

from cpm_core.formats.images.decoded import UnreadableError


def package(name: str, what: str, extra: str = "medical") -> Any:
    """A package; UnreadableError, which says how it is installed, when it is not there.

    Parameters
    ----------
    name : str
        The package, or a part of it.
    what : str
        The beginning of the sentence, such as "brain.nii is a NIfTI volume".
    extra : str
        What is installed for it.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise UnreadableError(
            f"{what}, which needs the package {name.partition('.')[0]}: install it "
            f'(pip install "cpm-particles[{extra}]").'
        ) from None
