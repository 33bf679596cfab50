"""Runs to compare: combinations of values of one or two parameters, or methods."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

from cpm_app.model.display.lengths import format_short_number
from cpm_app.model.parameters.controls import Control, control_value, set_control_value, slider_range
from cpm_app.model.text.language import tr, translate_core_text
from cpm_core import CONTOUR_METHODS, Parameters
from cpm_core.methods import MethodComparison
from cpm_core.numerics.types import frozen, record

MIN_AXIS_VALUES = 2
"""Smallest number of values of a parameter."""

MAX_AXIS_VALUES = 6
"""Largest number of values of a parameter."""

FIRST_AXES = ("smoothing", "min_strength")
"""Parameters that are proposed first: they decide which edges count."""

_PROPOSED_COUNT = 3
"""Number of values that are proposed."""

_PROPOSED_SPREAD = 0.5
"""Fraction of the slider's range that the proposed values span."""


@frozen
class TrialAxis:
    """A parameter that runs differ in, with its values in ascending order."""

    control: Control
    values: tuple[float, ...]


@record
class Trial:
    """A run that is compared with others.

    With a `method`, it runs from the drawn outlines with `settings`. Without one, it is the document's run with the
    parameters `settings`, which differ from the document's in `values`.
    """

    title: str
    settings: Any
    values: tuple[tuple[str, float], ...] = ()
    method: str = ""


def plan_parameter_trials(parameters: Parameters, axes: Sequence[TrialAxis]) -> tuple[Trial, ...]:
    """Plan a run for each combination of the values of one or two parameters.

    ValueError when both are the same parameter, or a value is out of its range.
    """
    names = [axis.control.name for axis in axes]
    if len(set(names)) < len(names):
        raise ValueError(tr("Both parameters are the same: choose two different ones."))
    trials = []
    for values in itertools.product(*(axis.values for axis in axes)):
        title = ", ".join(f"{axis.control.symbol} {format_short_number(value)}"
                          for axis, value in zip(axes, values, strict=True))  # fmt: skip
        chosen = tuple(zip(names, values, strict=True))
        trials.append(Trial(title, set_control_values(parameters, chosen), chosen))
    return tuple(trials)


def plan_method_trials(compared: MethodComparison, parameters: Parameters) -> tuple[Trial, ...]:
    """Plan a run of each selected method; ValueError when there is none."""
    if not compared.methods:
        raise ValueError(tr("Select at least one method."))
    return tuple(
        Trial(
            translate_core_text(method.title),
            parameters if method.of_particles else compared.settings_of(name),
            method=name,
        )
        for name, method in ((name, CONTOUR_METHODS[name]) for name in compared.methods)
    )


def propose_values(control: Control, parameters: Parameters, contrast: float) -> tuple[float, ...]:
    """Propose evenly spaced values around the current one, itself included, over part of the slider's range.

    There are three, fewer if there are not as many whole numbers; parameters in gray levels are scaled by the contrast
    of the image.
    """
    low, high = slider_range(control, contrast)
    step = 1.0 if control.is_whole else control.step
    present = control_value(parameters, control.name)
    middle = min(max(float(present), low), high) if isinstance(present, int | float) else 0.5 * (low + high)
    apart = max(1, round(_PROPOSED_SPREAD * (high - low) / (_PROPOSED_COUNT - 1) / step)) * step
    around = (middle, *(round((middle + index * apart) / step) * step for index in (-1, 1, -2, 2)))
    within = dict.fromkeys(round(value, 9) for value in around if low <= value <= high)
    return tuple(sorted([*within][:_PROPOSED_COUNT]))


def parse_values(control: Control, text: str) -> tuple[float, ...]:
    """Parse the numbers in a text, separated by spaces, semicolons or commas.

    ValueError when there are too few or too many, or one is not a number.
    """
    words = text.replace(";", " ").replace(",", " ").split()
    values = set()
    for word in words:
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            message = tr("{title}: “{word}” is not a number; write numbers such as 0.4, 0.6, 0.8.")
            raise ValueError(message.format(title=control.title, word=word)) from None
        values.add(value)
    if not MIN_AXIS_VALUES <= len(values) <= MAX_AXIS_VALUES:
        message = tr("{title} has {count} different values but must have from {fewest} to {most}.")
        raise ValueError(
            message.format(title=control.title, count=len(values), fewest=MIN_AXIS_VALUES, most=MAX_AXIS_VALUES)
        )
    return tuple(sorted(values))


def set_control_values(parameters: Parameters, values: Sequence[tuple[str, float]]) -> Parameters:
    """Return the parameters with some values replaced."""
    for name, value in values:
        parameters = set_control_value(parameters, name, value)
    return parameters
