"""The parameters of the charged-particle model, each defined once.

`Parameters` holds the values; `PARAMETERS` describes every field: its symbol, unit, range and meaning, and what a
change invalidates. The window's sliders, the command line's flags and the error messages are all derived from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal, cast

import numpy as np

from cpm_core.parameters.choices import CHOICE_PARAMETERS, Accuracy, Channel, Edges, check_choice
from cpm_core.parameters.formatting import format_call, format_choice, quote_value
from cpm_core.parameters.table import (
    AUTOMATIC_PARAMETERS,
    PARAMETERS,
    UNLIMITED_REACH,
    ParameterInfo,
    find_invalidating,
)


@dataclass(frozen=True)
class Parameters:
    """Parameters of a run; the defaults are the paper's (section 4.1). `PARAMETERS` has the range of each.

    Parameters
    ----------
    reach : float
        Distance that particles creep along edges outside the area of their start, at the paper's damping, weights and
        annealing [px]; at `UNLIMITED_REACH`, as always in a volume, there is no area, and with these values every
        connected edge is reached.
    weakest_edge : float
        Edges weaker than this fraction of those around the area of the start hold no particles.
    beta : float
        Damping coefficient β of eq. (12).
    w1 : float
        Weight of the Coulomb force, eq. (12).
    w2 : float
        Weight of the Lorentz force, eq. (12); larger than `w1`, since the repulsion on a curved contour has unit size
        outward and only a stronger attraction holds the particles on the edge.
    annealing : float
        Annealing factor a: ``d_max`` of a particle is multiplied by it at every step in which nothing new is found near
        it.
    time_step : float
        Δt of eq. (14).
    d_min : float
        Spacing of particles [px]; of two nearer than half of it, one is deleted.
    d_max : float
        Range beyond `d_min` in which a gap between two neighbors is filled, at the start of each scale [px].
    smoothing : float or "auto"
        Standard deviation σ of the Gaussian before the gradient [px], or ``"auto"`` to choose it from the image's
        noise.
    gamma : float or "auto"
        Exponent of the gray levels, over their range in the image, before edges are taken, or ``"auto"`` to choose it
        from the image: 1/2 for objects on a dark background, 0.7 on a bright one, 1 where the image has none.
    scales : int
        Number of scales.
    edge_floor : float
        Fraction of the largest edge strength below which no fixed charge is placed.
    exponent : float or "auto"
        Power of the distance with which the force of a fixed charge decays, eq. (8), or ``"auto"`` for the number of
        dimensions: the paper's inverse square in an image, 3 in a volume. The repulsion of particles keeps its own.
    max_border : float
        Largest width of the image border, as a fraction of the shorter side; 0 for no border.
    max_gap : float
        Loose ends of contours up to this far apart are joined along the edge map [px]; at 0 gaps stay open.
    min_strength : float
        Contours with a lower mean edge strength are left out, as are such parts of contours with a loose end [gray
        levels / px].
    sure_edge : float
        Contours whose edge strength is below this fraction of the largest stay only if they are connected to a stronger
        one.
    min_contrast : float
        Contours between regions with a lower contrast are left out, as are such parts of contours with a loose end.
    min_length : float
        Shorter contours are left out [px].
    polarity : float
        Below 0, dark structures get a skeleton, above 0 light ones; at 0 the image decides.
    max_width : float
        Parts wider than this have no skeleton [px]; 0 means no limit if outlines are closed, else a limit derived from
        the widths in the image.
    pruning : float
        How far a shape may extend beyond the one that its skeleton represents [px].
    edges : {"gradient", "vessels"}
        Source of the edges: the gray levels, or a vessel measure.
    accuracy : {"standard", "exact"}
        Accuracy of the field of the fixed charges of a volume: from blocks of two voxels, or from every voxel; in an
        image the field is always exact. `cpm_core.field.convolution` documents the error of blocks.
    channel : {"luminance", "red", "green", "blue", "hematoxylin", "eosin", "dab"}
        Source of the gray levels of a color image; no effect on a gray one.

    Raises
    ------
    ValueError
        When a value lies outside its range; the message names the field, the value and the range.

    Examples
    --------
    >>> cpm.Parameters(beta=0.6, smoothing="auto")
    Parameters(beta=0.6, smoothing='auto')
    >>> cpm.Parameters().exponent_in(2), cpm.Parameters().exponent_in(3)
    (2.0, 3.0)
    >>> cpm.Parameters(beta=0.6).steering == cpm.Parameters(beta=0.6, max_gap=20).steering
    True
    >>> try:
    ...     cpm.Parameters(beta=-1)
    ... except ValueError as error:
    ...     print(error)
    beta is -1 but must be a number from 0 to 4.
    """

    reach: float = UNLIMITED_REACH
    weakest_edge: float = 0.0
    beta: float = 0.8
    w1: float = 1.6
    w2: float = 1.75
    annealing: float = 0.99
    time_step: float = 0.5
    d_min: float = 2.0
    d_max: float = 3.0
    smoothing: float | Literal["auto"] = 1.0
    gamma: float | Literal["auto"] = 1.0
    scales: int = 3
    edge_floor: float = 0.0
    exponent: float | Literal["auto"] = "auto"
    max_border: float = 0.0
    max_gap: float = 0.0
    min_strength: float = 0.0
    sure_edge: float = 0.0
    min_contrast: float = 0.0
    min_length: float = 0.0
    polarity: float = 0.0
    max_width: float = 0.0
    pruning: float = 1.0
    edges: Edges = "gradient"
    accuracy: Accuracy = "standard"
    channel: Channel = "luminance"

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.generic):
                object.__setattr__(self, field.name, value.item())
            if field.name in CHOICE_PARAMETERS:
                check_choice(CHOICE_PARAMETERS[field.name], getattr(self, field.name))
            else:
                _check_parameter(PARAMETERS[field.name], getattr(self, field.name))
        object.__setattr__(self, "scales", int(self.scales))
        if not self.w2 > self.w1:
            raise ValueError(
                f"w2 is {self.w2:g} but must be above w1, which is {self.w1:g}: "
                "otherwise repulsion tears the particles off the edges."
            )

    @cached_property
    def steering(self) -> tuple[object, ...]:
        """Values that affect the motion of the particles: all but those that concern only the start or the contours."""
        return tuple(getattr(self, name) for name in find_invalidating("nothing", "field"))

    def exponent_in(self, dimension: int) -> float:
        """Return `exponent` for an image of this many dimensions."""
        return float(dimension) if self.exponent == "auto" else float(self.exponent)

    def __repr__(self) -> str:
        changed = [
            f"{field.name}={getattr(self, field.name)!r}"
            for field in fields(self)
            if getattr(self, field.name) != field.default
        ]
        return format_call("Parameters", changed)


def _check_parameter(info: ParameterInfo, value: object) -> None:
    """Raise a `ValueError` that names field, value and range unless `value` fits."""
    if info.name in AUTOMATIC_PARAMETERS and isinstance(value, str) and value == "auto":
        return
    whole = info.name == "scales"
    fits = isinstance(value, (int, float)) and not isinstance(value, bool) and info.low <= value <= info.high
    if not fits or (whole and value != int(cast("float", value))):
        kind = "a whole number" if whole else "a number"
        words = f"{kind} from {info.low:g} to {info.high:g}" + (
            ' or "auto"' if info.name in AUTOMATIC_PARAMETERS else ""
        )
        raise ValueError(f"{info.name} is {quote_value(value)} but must be {words}.")


DEFAULT_VALUES: dict[str, float | str] = {
    name: getattr(Parameters(), name) for name in (*PARAMETERS, *CHOICE_PARAMETERS)
}
"""Default value of every parameter: the paper's."""

_AUTOMATIC_PRESET = Parameters(
    w1=0.6, w2=0.7, beta=0.4, smoothing=2.5, gamma="auto", edge_floor=0.2, max_border=0.08, sure_edge=0.3
)
"""Settings for automatic segmentation, from which other presets are derived."""

PRESETS: Mapping[str, Parameters] = MappingProxyType(
    {
        "shape": Parameters(reach=2.0, weakest_edge=0.5),
        "automatic": _AUTOMATIC_PRESET,
        "vessels": Parameters(
            w1=0.6, w2=0.7, beta=0.4, smoothing=1.5, edge_floor=0.05, max_border=0.08, min_length=30.0, edges="vessels"
        ),
        "noisy": Parameters(smoothing="auto"),
        "published": Parameters(),
        "fluorescence": replace(_AUTOMATIC_PRESET, smoothing=4.0),
        "angiogram": replace(_AUTOMATIC_PRESET, gamma=1.0, sure_edge=0.4, edges="vessels"),
        "ultrasound": replace(_AUTOMATIC_PRESET, smoothing=6.0, sure_edge=0.7),
        "volume": Parameters(w1=0.6, w2=0.7, beta=0.4, smoothing="auto", edge_floor=0.16, scales=1),
    }
)
"""Named settings: shape recovery (section 4.1), automatic segmentation (section 5.2), vessels and noisy images,
automatic segmentation of kinds of images whose boundaries other settings find better, and volumes (section 5.4)."""

PLANE_PRESETS = {name: preset for name, preset in PRESETS.items() if name != "volume"}
"""Presets for images: all but the one for volumes."""


def choose_parameters(given: Parameters | str | None, default: Parameters) -> Parameters:
    """Return the parameters that a caller names: those given, a preset by its name, or the default for None.

    ValueError for anything else.
    """
    if given is None or isinstance(given, Parameters):
        return given or default
    if isinstance(given, str) and given in PRESETS:
        return PRESETS[given]
    raise ValueError(
        f"parameters is {quote_value(given)} but must be Parameters, or {format_choice(str(given), PRESETS)}"
    )
