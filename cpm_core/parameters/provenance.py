"""Provenance: the image, method, parameters and starting positions behind a result."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from cpm_core.parameters.parameters import Parameters


@dataclass(frozen=True, eq=False)
class Provenance:
    """How a result was found; files state it along with the program version and the outcome of the run.

    Attributes
    ----------
    method : str
        Name of the method; "objects" for the boundaries of objects. Empty if unknown.
    parameters : mapping
        Parameters of the method, by name.
    seeds : int or None
        Number of positions that particles started from; None for a method without seeds.
    shapes : tuple of mapping
        What was drawn: starts, limits and charges, as plain JSON. Empty where only the seeds are known.
    scale : int or None
        Scale of the image pyramid at the end, 0 for the image itself; None for a method without scales.
    steered : bool
        Whether parameters, charges, regions or particles were changed during the run.
    sha256 : str
        Hash of the image, for a file as returned by `compute_fingerprint`; empty if unknown.
    of_file : bool
        Whether the hash is of the bytes of a file rather than of an array; see `Image.sha256`.
    model : str
        The larger models that found objects, if any; see `Selection.model`.
    """

    method: str = ""
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    seeds: int | None = None
    shapes: tuple[Mapping[str, Any], ...] = ()
    scale: int | None = None
    steered: bool = False
    sha256: str = ""
    of_file: bool = True
    model: str = ""


def select_parameters(parameters: Parameters, names: Iterable[str]) -> dict[str, float | str]:
    """Select the values of the named parameters, for `Provenance.parameters`."""
    return {name: getattr(parameters, name) for name in names}
