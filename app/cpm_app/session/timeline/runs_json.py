"""Runs as plain JSON of bounded size, and back; damaged ones are left out and reported in one message."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import numpy as np

from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.modes import MODES
from cpm_app.model.document.saving import from_session_file, to_session_file
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.timeline.stored_runs import (
    StoredBranch,
    StoredRun,
    StoredRuns,
    TimelineBranch,
    starts_from_sources,
)
from cpm_app.session.timeline.timeline import MAX_TIMELINE_RUNS
from cpm_app.session.timeline.timeline_nodes import (
    FIGURE_NAMES,
    BranchStep,
    EraseAction,
    JoinAction,
    RunAction,
    StepAction,
)
from cpm_core import RUN_METHODS, Parameters, PlacedCharge, State
from cpm_core.field import sort_charges
from cpm_core.formats import (
    Reading,
    array_from_json,
    array_to_json,
    decode_session,
    encode_session,
    expect_list,
    expect_mapping,
    expect_number,
    from_json,
    parameters_from_json,
    regions_from_json,
    regions_to_json,
    shape_from_json,
    shape_to_json,
    state_from_json,
    state_to_json,
    to_json,
)
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import JsonDict, JsonObject
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.parameters import quote_value

MAX_STORED_CHARACTERS = 24 * 2**20
"""Largest size of states and figures in a session file [characters]; actions always fit, as all can be repeated."""

MAX_BRANCH_STEPS = 200_000
"""Largest number of steps of a branch that are read."""

Entry = TypeVar("Entry")


def runs_to_json(stored: StoredRuns) -> JsonObject:
    """Encode all runs; states, the shown and then the newest, and figures as far as `MAX_STORED_CHARACTERS` allows."""
    if not stored.runs:
        return {}
    remaining, states = MAX_STORED_CHARACTERS, []
    for at in sorted(stored.states, key=lambda at: (at != stored.shown_step, -at[0], -at[1])):
        state = stored.states[at]
        plain, size = _encode_state(state) if isinstance(state, State) else ({}, MAX_STORED_CHARACTERS + 1)
        if size <= remaining:
            remaining -= size
            states.append({"branch": at[0], "step": at[1], "state": plain})
    runs = [_run_to_json(run) for run in stored.runs]
    for branch in (branch for run in reversed(runs) for branch in run["branches"]):
        size = len(branch["figures"]["data"]) if "figures" in branch else 0
        if size > remaining:
            del branch["figures"]
        else:
            remaining -= size
    here = None if stored.shown_step is None else list(stored.shown_step)
    return {"here": here, "runs": runs, "states": states}


@lru_cache(2 * MAX_TIMELINE_RUNS)
def _encode_state(state: State) -> tuple[JsonDict, int]:
    """Return a state as plain JSON and its size [characters]; cached, as most states are collected repeatedly."""
    plain = state_to_json(state)
    return plain, len(json.dumps(plain))


def runs_from_json(plain: JsonObject, image: ImageReference) -> tuple[StoredRuns, str]:
    """Read the runs of a session file on its image; return them and a message on what was left out, or ""."""
    faults: list[Exception] = []
    runs: list[StoredRun] = []
    branches: dict[int, tuple[StoredRun, StoredBranch]] = {}
    for run in read_valid_entries(plain, "runs", lambda entry: _read_run(entry, image), faults)[-MAX_TIMELINE_RUNS:]:
        found = {stored.branch.identity: (run, stored) for stored in run.branches}
        if branches.keys() & found:
            faults.append(ValueError("two branches have the same number."))
        else:
            branches.update(found)
            runs.append(run)

    def read_state(entry: JsonObject) -> tuple[BranchStep, State] | None:
        return (
            _read_state(entry, branches, image) if entry.get("branch") in branches else None
        )  # the oldest may be left out

    states = dict(filter(None, read_valid_entries(plain, "states", read_state, faults)))
    here = None
    try:
        branch, step = (int(expect_number(one, "here")) for one in plain.get("here") or (0, 0))
        here = (branch, step) if branch in branches else None
    except (ValueError, TypeError) as error:
        faults.append(error)
    message = tr("Part of the recorded runs is damaged and was skipped ({fault}); everything else was opened.")
    fault = message.format(fault=explain_error(faults[0]).rstrip(".")) if faults else ""
    return StoredRuns(tuple(runs), here, states), fault


def read_valid_entries(
    plain: JsonObject, name: str, read: Callable[[JsonObject], Entry], errors: list[Exception]
) -> list[Entry]:
    """Read the valid entries of a list; the errors of the others are added to `errors`."""
    found, entries = [], plain.get(name, [])
    for entry in entries if isinstance(entries, list) else [entries]:
        try:
            found.append(read(expect_mapping(entry, name)))
        except (ValueError, TypeError, KeyError, OverflowError, IndexError, AttributeError) as error:
            errors.append(error)
    return found


def _run_to_json(run: StoredRun) -> JsonDict:
    numbers: dict[RunAction, int] = {}
    branches = []
    for stored in run.branches:
        plain = to_json(stored.branch)
        # run-length encoding: the actions of a step by their numbers, and for how many steps they are the same
        numbered = ([numbers.setdefault(action, len(numbers)) for action in step] for step in stored.steps)
        plain["steps"] = [[alike, len(list(group))] for alike, group in itertools.groupby(numbered)]
        if stored.figures is not None:
            plain["figures"] = array_to_json(stored.figures)
        branches.append(plain)
    document = run.document
    acting = document.objects.barriers or document.outlined.objects  # a run depends on objects only then
    bare = replace(to_session_file(document, {}), image=None)
    return {
        "size": document.image and {"spacing": list(document.image.spacing), "unit": document.image.unit},
        "document": json.loads(encode_session(bare if acting else replace(bare, objects=SegmentedObjects()), Path())),
        "drawn": [shape_to_json(start) for start in starts_from_sources(run.sources)],
        "actions": [_action_to_json(action, document.parameters) for action in numbers],
        "branches": branches,
    }


def _action_to_json(action: RunAction, usual: Parameters) -> JsonDict:
    """Encode an action; of its parameters only those that differ from the usual ones."""
    plain: JsonDict = {}
    if isinstance(action, StepAction):
        known, taken = to_json(usual), to_json(action.parameters)
        plain["step"] = {name: value for name, value in taken.items() if value != known[name]}
        plain["charges"] = [to_json(charge) for charge in action.charges]
    elif isinstance(action, JoinAction):
        plain["join"] = array_to_json(np.array(action.seeds))
    elif isinstance(action, EraseAction):
        plain |= {"erase": to_json(action.path), "radius": action.radius}
    return plain | regions_to_json(action.regions)


def _read_run(plain: JsonObject, image: ImageReference) -> StoredRun:
    if plain.get("size") is not None:  # the pixel size may have been changed since
        size = from_json(Reading, plain["size"], "size")
        if size.spacing is None or len(size.spacing) != len(image.shape):
            raise ValueError(
                f"the size of a pixel is {quote_value(plain['size'])} but the image has {len(image.shape)} axes."
            )
        image = replace(image, spacing=size.spacing, unit=size.unit)
    file = decode_session(json.dumps(plain.get("document")).encode(), "its beginning")
    document = from_session_file(file, image, file.parameters)
    drawn = tuple(shape_from_json(one, "a start of a run") for one in expect_list(plain.get("drawn", [])))
    listed = expect_list(plain.get("actions"), "actions")
    actions = [_read_action(expect_mapping(one, "action"), document.parameters) for one in listed]
    branches: dict[int, StoredBranch] = {}
    for entry in expect_list(plain.get("branches")):
        stored = _read_branch(expect_mapping(entry, "branch"), actions)
        branch, parent = stored.branch, branches.get(stored.branch.parent or 0)
        begins = not (branches or branch.parent or branch.first) and branch.scales and branch.scales[0][0] == 0
        if not (begins if parent is None else branch.first <= parent.branch.last):
            raise ValueError(f"branch {branch.identity} leaves no step of its run.")
        branches[branch.identity] = stored
    if not branches:
        raise ValueError("a run has no branch.")
    return StoredRun(document, Document(shapes=drawn).start_counts, tuple(branches.values()))


def _read_branch(plain: JsonObject, actions: Sequence[RunAction]) -> StoredBranch:
    given = {name: value for name, value in plain.items() if name not in ("steps", "figures")}
    branch = from_json(TimelineBranch, given, "branch")
    figures = None
    if "figures" in plain:
        figures = array_from_json(plain["figures"], float, (len(FIGURE_NAMES), None), "figures of a branch")
    steps: list[tuple[RunAction, ...]] = []
    for entry in expect_list(plain.get("steps"), "steps"):
        numbers, count = expect_list(entry, "steps")
        if type(count) is not int or not 0 < count <= MAX_BRANCH_STEPS - len(steps):
            raise ValueError(f"steps repeat {quote_value(count)} times but must be {MAX_BRANCH_STEPS} at most.")
        if any(type(one) is not int or not 0 <= one < len(actions) for one in expect_list(numbers, "steps")):
            raise ValueError(f"steps name the action {quote_value(numbers)}, which does not exist.")
        steps += [tuple(actions[one] for one in numbers)] * count
    # every entry but the first is a step, followed by the changes of its state
    stepped = [[index for index, action in enumerate(step) if isinstance(action, StepAction)] for step in steps]
    valid = stepped[:1] == [[]] and all(places == [0] for places in stepped[1:])
    if not valid or branch.identity < 1 or branch.first < 0 or any(min(mark) < 0 for mark in branch.scales):
        raise ValueError(f"branch {branch.identity} is not one that a run can have.")
    last = branch.first + len(steps) - 1
    return StoredBranch(replace(branch, name=branch.name[:40], last=last), tuple(steps), figures)


def _read_action(plain: JsonObject, usual: Parameters) -> RunAction:
    regions = regions_from_json(plain, "regions of a run")
    if "step" in plain:
        parameters, _ = parameters_from_json({**to_json(usual), **expect_mapping(plain["step"], "step")})
        charges = tuple(
            from_json(PlacedCharge, one, "charge") for one in expect_list(plain.get("charges", []), "charges")
        )
        return StepAction(parameters, charges, regions)
    if "join" in plain:
        axes = 3 if expect_mapping(plain["join"], "join").get("shape", [])[-1:] == [3] else 2
        seeds = array_from_json(plain["join"], float, (None, axes), "particles that were added")
        if not np.isfinite(seeds).all():
            raise ValueError("particles that were added hold a value that is not a number.")
        return JoinAction(as_line(seeds), regions)
    erased = from_json(EraseAction, {"path": plain.get("erase"), "radius": plain.get("radius")}, "eraser")
    return replace(erased, regions=regions)


def _read_state(
    plain: JsonObject, branches: Mapping[int, tuple[StoredRun, StoredBranch]], image: ImageReference
) -> tuple[BranchStep, State]:
    """Read a state and its place; steering, regions and charges are those of the action of its step."""
    number_of, step = (int(expect_number(plain.get(name), f"{name} of a state")) for name in ("branch", "step"))
    run, stored = branches[number_of]
    if not stored.branch.first < step <= stored.branch.last:
        raise ValueError(f"there is no step {step} of branch {number_of}.")
    spacing = (run.document.image or image).spacing
    state = state_from_json(plain.get("state"), image.shape, run.document.parameters.scales, spacing)
    taken = stored.steps[step - stored.branch.first][0]
    if state.step != step or not isinstance(taken, StepAction):
        raise ValueError(f"the state of step {step} is that of step {state.step}.")
    steering = RUN_METHODS[MODES[run.document.mode].method].steering(taken.parameters)
    regions, charges = taken.regions, sort_charges(taken.charges)
    return (number_of, step), replace(state, steering=steering, regions=regions, charges=charges)
