"""Run actions as plain JSON: each one once, and how often it follows itself."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from app.session.timeline.moments import Erased, Joined, RunAction, Stepped
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.formats.sessions.plain import (
    NAMES,
    array_from_plain,
    array_to_plain,
    from_plain,
    items,
    mapping,
    parameters_from_plain,
    regions_from_plain,
    regions_to_plain,
    to_plain,
)
from cpm_core.numerics.types import Place
from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import shown

MOST_STEPS = 200_000
"""Most steps of a branch that are read."""

Steps = tuple[tuple[RunAction, ...], ...]


@dataclass(frozen=True, slots=True)
class _Rub:
    """What an eraser goes over."""

    erase: tuple[Place, ...]
    radius: float


class ActionTable:
    """The actions of a run by number; parameters are written as far as they differ from those it began with."""

    def __init__(self, usual: Parameters) -> None:
        self._usual = usual
        self._numbers: dict[RunAction, int] = {}

    def steps_to_plain(self, steps: Steps) -> list[Any]:
        """The actions of steps, as their numbers and how often they follow."""
        numbered = ([self._numbers.setdefault(action, len(self._numbers)) for action in step] for step in steps)
        return [[numbers, len(list(alike))] for numbers, alike in itertools.groupby(numbered)]

    def to_plain(self) -> list[Any]:
        """The actions by number."""
        return [self._action(action) for action in self._numbers]

    def _action(self, action: RunAction) -> dict[str, Any]:
        plain: dict[str, Any] = {}
        if isinstance(action, Stepped):
            usual, taken = to_plain(self._usual), to_plain(action.parameters)
            plain["step"] = {name: value for name, value in taken.items() if value != usual[name]}
            plain["charges"] = [to_plain(charge) for charge in action.charges]
        elif isinstance(action, Joined):
            plain["join"] = array_to_plain(action.places)
        elif isinstance(action, Erased):
            plain |= {"erase": to_plain(action.path), "radius": action.radius}
        return plain | regions_to_plain(action.regions)


def actions_from_plain(plain: object, usual: Parameters) -> list[RunAction]:
    """The actions of a run by number; ValueError for one that cannot be done."""
    return [_action(mapping(one, f"action {number}"), usual, number) for number, one in enumerate(items(plain), 1)]


def steps_from_plain(plain: object, actions: Sequence[RunAction]) -> Steps:
    """The actions of steps; ValueError unless each step but the first begins with a step, and only with one."""
    steps: list[tuple[RunAction, ...]] = []
    for entry in items(plain):
        numbers, count = entry if isinstance(entry, list) and len(entry) == 2 else ([], 0)
        if type(count) is not int or not 0 < count <= MOST_STEPS - len(steps):
            raise ValueError(f"steps repeat {shown(count)} times but must be {MOST_STEPS} at most.")
        known = [number for number in items(numbers) if type(number) is int and 0 <= number < len(actions)]
        if len(known) < len(items(numbers)):
            raise ValueError(f"steps name the action {shown(numbers)}, which there is not.")
        steps += [tuple(actions[number] for number in known)] * count
    for index, step in enumerate(steps):
        if [isinstance(action, Stepped) for action in step] != [index > 0 and place == 0 for place in range(len(step))]:
            raise ValueError(f"step {index} is not one step and what was changed after it.")
        if index > 0 and not step:
            raise ValueError(f"step {index} is empty.")
    if not steps:
        raise ValueError("there are no steps.")
    return tuple(steps)


def _action(plain: Mapping[str, Any], usual: Parameters, number: int) -> RunAction:
    where = f"action {number}"
    regions = regions_from_plain(plain, f"regions of {where}")
    if "step" in plain:
        values = {field.name: getattr(usual, field.name) for field in fields(Parameters)}
        parameters, _ = parameters_from_plain({**values, **mapping(plain["step"], where)})
        charges = tuple(from_plain(PlacedCharge, one, f"charge of {where}") for one in items(plain.get("charges", [])))
        return Stepped(parameters, charges, regions)
    if "join" in plain:
        axes = 3 if _has_three_axes(plain["join"]) else 2
        seeds = array_from_plain(plain["join"], float, (None, axes), f"particles of {where}")
        if not np.isfinite(seeds).all():
            raise ValueError(f"particles of {where} hold a value that is not a number.")
        return Joined.at(seeds, regions)
    rub = from_plain(_Rub, {name: value for name, value in plain.items() if name not in NAMES}, where)
    return Erased(rub.erase, rub.radius, regions)


def _has_three_axes(plain: object) -> bool:
    shape = plain.get("shape") if isinstance(plain, Mapping) else None
    return isinstance(shape, list) and len(shape) == 2 and shape[1] == 3
