"""The contours of a method as a result, for everything that takes one: writers, measurements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour, sampled
from cpm_core.contours.result import Result
from cpm_core.contours.surface import Surface
from cpm_core.field.edge_map import edge_map
from cpm_core.field.interpolation import interpolate
from cpm_core.image.image import Image
from cpm_core.objects.methods.method import Start
from cpm_core.objects.methods.run import Facts
from cpm_core.parameters.provenance import Provenance

_SMOOTHING = 1.0
"""Width of the Gaussian before the edge strength along the contours is taken [px]."""


def result_of(
    facts: Facts, contours: Sequence[Contour], image: Image, start: Start, settings: Any, surface: Surface | None = None
) -> Result:
    """Make a result of the contours that a method has found.

    Parameters
    ----------
    facts : Facts
        What is said of the run.
    contours : sequence of Contour
        The contours of its last state [px].
    image : Image
        The image.
    start : Start
        What the method began from.
    settings : Settings or Parameters
        Settings of the method.
    surface : Surface, optional
        In a volume the surface of its last state.

    Returns
    -------
    Result
        The contours with numbers from 1 and the mean edge strength along them; no particles.
    """
    strength = edge_map(image.values, _SMOOTHING) if contours else image.values
    numbered = []
    for number, contour in enumerate(contours, start=1):
        mean = float(interpolate(strength[None], sampled([contour])).mean())
        numbered.append(replace(contour, number=number, strength=mean))
    shapes: list[dict[str, Any]] = [{"shape": "polygon", "points": outline.tolist()} for outline in start.outlines]
    shapes += [{"shape": "sphere", "center": center, "radius": radius} for *center, radius in start.spheres]
    made = Provenance(
        facts.method, asdict(settings), None, tuple(shapes), sha256=image.sha256, of_file=bool(image.file_sha256)
    )
    return Result(
        particles=np.empty((0, image.ndim)),
        contours=tuple(numbered),
        surface=None if surface is None else replace(surface, spacing=image.spacing, unit=image.unit),
        steps=facts.steps,
        converged=facts.converged,
        stop_reason=facts.stop_reason,
        shape=image.shape,
        spacing=image.spacing,
        unit=image.unit,
        source=image.source,
        image=image,
        provenance=made,
    )
