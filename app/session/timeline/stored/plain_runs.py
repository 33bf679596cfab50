"""Runs as plain JSON, of bounded size, and back: what is damaged is left out with one sentence."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from app.model.display.plots import RunMetrics
from app.model.document.document import Document, ImageReference
from app.model.document.saving import restored, to_file
from app.model.text.language import reason, tr
from app.session.timeline.moments import BranchStep, Stepped
from app.session.timeline.stored.plain_actions import ActionTable, actions_from_plain, steps_from_plain
from app.session.timeline.stored_runs import StoredBranch, StoredRun, StoredRuns
from app.session.timeline.timeline import MOST_RUNS
from cpm_core.field.placed_charges import in_order
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.particle_state import state_from_plain, state_to_plain
from cpm_core.formats.sessions.plain import (
    array_from_plain,
    array_to_plain,
    items,
    mapping,
    number,
    shape_from_plain,
    shape_to_plain,
)
from cpm_core.formats.sessions.session_file import decode, encode
from cpm_core.model.state import State
from cpm_core.numerics.types import Position
from cpm_core.objects.segmented.segmented_object import SegmentedObjects
from cpm_core.parameters.quotation import shown
from cpm_core.shapes import Points, Start

MOST = 24 * 2**20
"""Largest size of states and figures in a session file [characters]; actions, which repeat all, come in any case."""

FIGURES = len(fields(RunMetrics))
"""Rows of the figures of a branch."""

Plain = Mapping[str, Any]


class RunsWriter:
    """Writes runs as plain JSON; a state that has been written before is not packed again."""

    def __init__(self) -> None:
        self._packed: dict[int, tuple[State, dict[str, Any], int]] = {}

    def to_plain(self, stored: StoredRuns, most: int = MOST) -> Plain:
        """All runs with as many states and figures as `most` characters hold: the state shown, then the newest ones."""
        if not stored.runs:
            return {}
        left, states, packed = most, [], {}
        for place in sorted(stored.states, key=lambda place: (place != stored.here, -place[0], -place[1])):
            state = stored.states[place]
            if not isinstance(state, State):
                continue
            known = self._packed.get(id(state))
            if known is None:
                plain = state_to_plain(state)
                known = (state, plain, len(json.dumps(plain)))
            packed[id(state)] = known
            if known[2] <= left:
                left -= known[2]
                states.append({"branch": place[0], "step": place[1], "state": known[1]})
        self._packed = packed
        runs = [_run_to_plain(run) for run in stored.runs]
        for branch in (branch for run in reversed(runs) for branch in run["branches"]):
            size = len(branch["figures"]["data"])
            if size > left:
                del branch["figures"]
            else:
                left -= size
        here = None if stored.here is None else list(stored.here)
        numbers = [[number, *place] for number, place in stored.numbers.items()]
        return {"here": here, "runs": runs, "states": states, "numbers": numbers}


def from_plain(plain: Plain, image: ImageReference) -> tuple[StoredRuns, str]:
    """The runs of a session file on its image, and a sentence on what had to be left out, empty if nothing had."""
    try:
        given = items(plain.get("runs", []))[-MOST_RUNS:]
    except ValueError as error:
        return StoredRuns(), _sentence(error)
    runs, faults, numbers = [], [], set[int]()
    for entry in given:
        try:
            run = _run(mapping(entry, "run"), image)
            found = {branch.number for branch in run.branches}
            if numbers & found or len(found) < len(run.branches):
                raise ValueError("two branches have the same number.")
            numbers |= found
            runs.append(run)
        except (ValueError, TypeError, OverflowError) as error:
            faults.append(error)
    branches = {branch.number: (run, branch) for run in runs for branch in run.branches}
    states: dict[BranchStep, State] = {}
    for place, load in _states(plain.get("states", []), branches, image):
        try:
            states[place] = load()
        except (ValueError, TypeError, OverflowError) as error:
            faults.append(error)
    here = plain.get("here")
    try:
        shown_at = None if here is None else _pair(here)
    except ValueError:
        shown_at = None
    there = shown_at if shown_at is not None and shown_at[0] in branches else None
    try:
        places = _numbers(plain.get("numbers", []))
    except ValueError as error:
        faults.append(error)
        places = {}
    return StoredRuns(tuple(runs), there, states, places), _sentence(*faults[:1])


def _numbers(plain: object) -> dict[int, Position]:
    """Numbers of contours and their places."""
    places: dict[int, Position] = {}
    for entry in items(plain):
        of, *place = entry if isinstance(entry, list) and len(entry) == 3 else (None,)
        if type(of) is not int or not 0 < of < 2**31 or of in places:
            raise ValueError(f"{shown(entry)} is not the number of a contour and its place.")
        row, col = (number(one, f"the place of contour {of}") for one in place)
        places[of] = row, col
    return places


def _sentence(*faults: Exception) -> str:
    if not faults:
        return ""
    message = tr("A part of the recorded runs is damaged and was left out ({fault}); all else was opened.")
    return message.format(fault=reason(faults[0]).rstrip("."))


def _run_to_plain(run: StoredRun) -> dict[str, Any]:
    table, sources = ActionTable(run.document.parameters), list(run.drawn.elements())
    points = tuple(source for source in sources if isinstance(source, tuple))
    starts: list[Start] = [source for source in sources if isinstance(source, Start)]
    if points:
        starts.append(Points(points))
    branches = [
        {
            "number": branch.number,
            "name": branch.name,
            "named": branch.renamed,
            "parent": branch.parent,
            "first": branch.first,
            "steps": table.steps_to_plain(branch.steps),
            "scales": [list(mark) for mark in branch.scales],
            "figures": array_to_plain(branch.figures),
        }
        for branch in run.branches
    ]
    bare = Document(
        None, run.document.shapes, run.document.parameters, mode=run.document.mode, objects=_acting(run.document),
        outlined=run.document.outlined,
    )  # fmt: skip
    image = run.document.image
    size = None if image is None else {"spacing": list(image.spacing), "unit": image.unit}
    return {
        "size": size,
        "document": json.loads(encode(to_file(bare, {}), Path())),
        "drawn": [shape_to_plain(start) for start in starts],
        "actions": table.to_plain(),
        "branches": branches,
    }


def _acting(document: Document) -> SegmentedObjects:
    """The objects of a document if a run depends on them."""
    acting = document.objects.barriers or document.outlined.objects
    return document.objects if acting else SegmentedObjects()


def _run(plain: Plain, image: ImageReference) -> StoredRun:
    if plain.get("size") is not None:  # it may have been changed since
        size = Reading.of(mapping(plain["size"], "size"))
        if size.spacing is None or len(size.spacing) != len(image.shape):
            raise ValueError(
                f"the size of a pixel is {shown(plain['size'])} but the image has {len(image.shape)} axes."
            )
        image = replace(image, spacing=size.spacing, unit=size.unit)
    file = decode(json.dumps(plain.get("document")).encode(), "its beginning")
    document = restored(file, image, file.parameters)
    shapes = [shape_from_plain(one, "a start of a run") for one in items(plain.get("drawn", []))]
    drawn: Counter[Hashable] = Counter()
    for shape in shapes:
        drawn.update(shape.positions if isinstance(shape, Points) else (shape,))
    actions = actions_from_plain(plain.get("actions"), document.parameters)
    branches: dict[int, StoredBranch] = {}
    for entry in items(plain.get("branches")):
        branch = _branch(mapping(entry, "branch"), actions)
        parent = branches.get(branch.parent) if branch.parent is not None else None
        if (parent is None) != (not branches):
            raise ValueError(f"branch {branch.number} leaves no branch of its run.")
        if parent is not None and not parent.first <= branch.first < parent.first + len(parent.steps):
            raise ValueError(f"branch {branch.number} leaves a step that there is not.")
        if parent is None and (branch.first != 0 or not branch.scales or branch.scales[0][0] != 0):
            raise ValueError("a run does not begin with its first step.")
        branches[branch.number] = branch
    if not branches:
        raise ValueError("a run has no branch.")
    return StoredRun(document, drawn, tuple(branches.values()))


def _branch(plain: Plain, actions: list[Any]) -> StoredBranch:
    number, parent, first, name = (plain.get(key) for key in ("number", "parent", "first", "name"))
    if type(number) is not int or type(first) is not int or not 0 < number < 2**31 or first < 0:
        raise ValueError(f"the number of a branch is {shown(number)} but must be a whole one.")
    if not isinstance(name, str) or not (parent is None or type(parent) is int):
        raise ValueError(f"branch {number} has no name, or no parent that can be one.")
    scales = tuple((step, scale) for step, scale in (_pair(mark) for mark in items(plain.get("scales", []))))
    figures = np.empty((FIGURES, 0))
    if "figures" in plain:
        figures = array_from_plain(plain["figures"], float, (FIGURES, None), f"figures of branch {number}")
    steps = steps_from_plain(plain.get("steps"), actions)
    return StoredBranch(number, name[:40], plain.get("named") is True, parent, first, steps, scales, figures)


def _pair(plain: object) -> tuple[int, int]:
    if not (
        isinstance(plain, list) and len(plain) == 2 and all(type(one) is int and 0 <= one < 2**31 for one in plain)
    ):
        raise ValueError(f"{shown(plain)} is not a step and a scale.")
    return plain[0], plain[1]


def _states(
    plain: object, branches: Mapping[int, tuple[StoredRun, StoredBranch]], image: ImageReference
) -> Iterator[tuple[BranchStep, Callable[[], State]]]:
    """Places of states, and what reads each of them."""
    for entry in plain if isinstance(plain, list) else []:
        given = entry if isinstance(entry, dict) else {}
        number, step = given.get("branch"), given.get("step")
        if type(number) is not int or type(step) is not int or number not in branches:
            continue
        run, branch = branches[number]
        if branch.first < step < branch.first + len(branch.steps):
            yield (number, step), _reader(given.get("state"), run, branch, step, image)


def _reader(
    plain: object, run: StoredRun, branch: StoredBranch, step: int, image: ImageReference
) -> Callable[[], State]:
    def load() -> State:
        state = state_from_plain(plain, image.shape, run.document.parameters.scales)
        taken = branch.steps[step - branch.first][0]
        if state.step != step or not isinstance(taken, Stepped):
            raise ValueError(f"the state of step {step} is that of step {state.step}.")
        steering, regions, charges = taken.parameters.steering, taken.regions, in_order(taken.charges)
        return replace(state, steering=steering, regions=regions, charges=charges)

    return load
