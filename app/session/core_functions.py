"""The functions of the core that the worker thread calls, in one place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cpm_core.contours.result import Result
from cpm_core.formats import export, load_image
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.objects.warm_up import warm_up
from cpm_core.parameters import Parameters
from cpm_core.segmentation.method import METHODS, Method


@dataclass(frozen=True, slots=True)
class Core:
    """The core's functions that run on the worker thread.

    `methods` makes a method of an image, parameters and regions; `export` writes a result to a path; `warm_up` compiles
    or loads the kernels until its argument returns True.
    """

    load_image: Callable[[Path], Image] = load_image
    methods: Mapping[str, Callable[[Image, Parameters, Regions | None], Method[Any]]] = field(
        default_factory=lambda: METHODS
    )
    export: Callable[[Result | Skeleton, Path], None] = export
    warm_up: Callable[[Callable[[], bool]], None] = warm_up
