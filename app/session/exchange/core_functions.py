"""The functions of the core that the worker thread calls, in one place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from cpm_core import METHODS, Image, Method, Parameters, encoded, load_image, load_volume
from cpm_core.image import AnyRegions
from cpm_core.warm_up import warm_up_runs, warm_up_volumes


@dataclass(frozen=True, slots=True)
class Core:
    """The core's functions that run on the worker thread.

    `load_image` and `load_volume` take a path, what they may call while they read, which raises when the image is no
    longer wanted, and by name which part of the file is read;
    `methods` makes a method of an image, parameters and regions; `encode` makes the bytes of a file, as
    `cpm_core.formats.encoded` does; `warm_up` compiles or loads the kernels until its first argument
    returns True, and calls its second one with the fraction that is compiled; `warm_up_volumes` does so for volumes.
    """

    load_image: Callable[..., Image] = load_image
    load_volume: Callable[..., Image] = load_volume
    methods: Mapping[str, Callable[[Image, Parameters, AnyRegions | None], Method[Any]]] = field(
        default_factory=lambda: METHODS
    )
    encode: Callable[..., bytes] = encoded
    warm_up: Callable[[Callable[[], bool], Callable[[float], object]], None] = warm_up_runs
    warm_up_volumes: Callable[[Callable[[], bool], Callable[[float], object]], None] = warm_up_volumes
