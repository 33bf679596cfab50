"""All methods that can be compared. A new one is a module and a line here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cpm_core.objects.methods.charged_particles import PARTICLES
from cpm_core.objects.methods.level_sets import GEODESIC, GEOMETRIC_GVF
from cpm_core.objects.methods.method import AnyMethod
from cpm_core.objects.methods.proposed_object import PROPOSED_OBJECT
from cpm_core.objects.methods.regions import (
    CHAN_VESE,
    GRAB_CUT,
    MORPHOLOGICAL_CHAN_VESE,
    MORPHOLOGICAL_GAC,
    RANDOM_WALKER,
)
from cpm_core.objects.methods.snakes import GVF_SNAKE, SNAKE
from cpm_core.parameters.quotation import shown

_ALL: tuple[AnyMethod, ...] = (
    PARTICLES,
    PROPOSED_OBJECT,
    SNAKE,
    GVF_SNAKE,
    GEODESIC,
    GEOMETRIC_GVF,
    CHAN_VESE,
    MORPHOLOGICAL_GAC,
    MORPHOLOGICAL_CHAN_VESE,
    RANDOM_WALKER,
    GRAB_CUT,
)

CONTOUR_METHODS: Mapping[str, AnyMethod] = MappingProxyType({method.name: method for method in _ALL})
"""All methods that can be compared, by name."""


def runnable(ndim: int = 2) -> tuple[str, ...]:
    """Names of the methods that lack nothing to run, in images or in volumes, which have three axes."""
    found = (method for method in CONTOUR_METHODS.values() if ndim == 2 or method.in_volumes)
    return tuple(method.name for method in found if not method.missing)


def method_named(name: str) -> AnyMethod:
    """The method of a name; ValueError with the names that there are when there is none."""
    if name not in CONTOUR_METHODS:
        raise ValueError(f"{shown(name)} is no method: choose among {', '.join(CONTOUR_METHODS)}.")
    return CONTOUR_METHODS[name]
