"""Runs as plain JSON of bounded size, and back; if they are damaged, that is reported in one message."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.modes import MODES
from cpm_app.model.document.saving import from_session_file, to_session_file
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.timeline.branches import (
    Branch,
    StoredRun,
    StoredRuns,
    TimelineBranch,
    describe_branches,
    starts_from_sources,
)
from cpm_app.session.timeline.timeline import MAX_TIMELINE_RUNS
from cpm_app.session.timeline.timeline_nodes import (
    FIGURE_NAMES,
    BranchMetrics,
    BranchStep,
    EraseAction,
    JoinAction,
    RunAction,
    StepAction,
    TimelineNode,
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
        size = len(branch["figures"]["data"])
        if size > remaining:
            del branch["figures"]
        else:
            remaining -= size
    here = None if stored.shown_step is None else list(stored.shown_step)
    shown = {} if stored.parameters is None else {"parameters": to_json(stored.parameters)}
    return {"here": here, **shown, "runs": runs, "states": states}


@lru_cache(2 * MAX_TIMELINE_RUNS)
def _encode_state(state: State) -> tuple[JsonDict, int]:
    """Return a state as plain JSON and its size [characters]; cached, as most states are collected repeatedly."""
    plain = state_to_json(state)
    return plain, len(json.dumps(plain))


def runs_from_json(plain: JsonObject, image: ImageReference) -> tuple[StoredRuns, str]:
    """Read the runs of a session file on its image; if one is damaged, return none, and a message."""
    try:
        return _read_runs(plain, image), ""
    except (ValueError, TypeError, KeyError, OverflowError, IndexError, AttributeError) as error:
        message = tr("The recorded runs are damaged and were skipped ({fault}); everything else was opened.")
        return StoredRuns(), message.format(fault=explain_error(error).rstrip("."))


def _read_runs(plain: JsonObject, image: ImageReference) -> StoredRuns:
    runs: list[StoredRun] = []
    places: dict[int, tuple[StoredRun, Branch]] = {}
    for entry in expect_list(plain.get("runs", []), "runs"):
        run = _read_run(expect_mapping(entry, "run"), image)
        if places.keys() & {branch.identity for branch in run.branches}:
            raise ValueError("two branches have the same number.")
        places |= {branch.identity: (run, branch) for branch in run.branches}
        runs.append(run)
    states = dict(
        _read_state(expect_mapping(entry, "state"), places, image)
        for entry in expect_list(plain.get("states", []), "states")
    )
    here = plain.get("here")
    if here is None:
        return StoredRuns(tuple(runs), states=states)
    branch, step = (int(expect_number(one, "here")) for one in here)
    shown = parameters_from_json(plain["parameters"])[0] if "parameters" in plain else None
    return StoredRuns(tuple(runs), (places[branch][1].identity, step), shown, states)


def _run_to_json(run: StoredRun) -> JsonDict:
    numbers: dict[RunAction, int] = {}
    branches = []
    lines = {line.identity: line for line in run.branches}
    for shown, line in zip(describe_branches(run.branches), run.branches, strict=True):
        steps = [node.actions for node in line.nodes[shown.first :]]
        if shown.parent is not None:  # its own actions, from the step at which it leaves its parent
            steps[0] = steps[0][len(lines[shown.parent].node_at(shown.first).actions) :]
        # run-length encoding: the actions of a step by their numbers, and for how many steps they are the same
        numbered = ([numbers.setdefault(action, len(numbers)) for action in step] for step in steps)
        alike = [[same, len(list(group))] for same, group in itertools.groupby(numbered)]
        branches.append({**to_json(shown), "steps": alike, "figures": array_to_json(line.figures.rows)})
    document = run.document
    acting = document.objects.barriers or document.outlined.objects  # a run depends on objects only then
    objects = document.objects if acting else SegmentedObjects()
    bare = replace(to_session_file(document, {}), image=None, objects=objects)
    return {
        "size": document.image and {"spacing": list(document.image.spacing), "unit": document.image.unit},
        "document": json.loads(encode_session(bare, Path())),
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
    branches: dict[int, Branch] = {}
    for entry in expect_list(plain.get("branches")):
        line = _read_branch(expect_mapping(entry, "branch"), actions, branches)
        branches[line.identity] = line
    if not branches:
        raise ValueError("a run has no branch.")
    return StoredRun(document, Document(shapes=drawn).start_counts, tuple(branches.values()))


def _read_branch(plain: JsonObject, actions: Sequence[RunAction], older: Mapping[int, Branch]) -> Branch:
    """Read a branch of a run; the run is numbered like its oldest branch."""
    given = {name: value for name, value in plain.items() if name not in ("steps", "figures")}
    shown, figures = from_json(TimelineBranch, given, "branch"), None
    if "figures" in plain:
        figures = array_from_json(plain["figures"], float, (len(FIGURE_NAMES), None), "figures of a branch")
    parent, first, run = older.get(shown.parent or 0), shown.first, next(iter(older), shown.identity)
    begins = not (shown.parent or first) and shown.scales and shown.scales[0][0] == 0
    if not (begins if parent is None else 0 <= first <= parent.last):
        raise ValueError(f"branch {shown.identity} leaves no step of its run.")
    if shown.identity < 1 or any(min(mark) < 0 for mark in shown.scales):
        raise ValueError(f"branch {shown.identity} is not one that a run can have.")
    root = next(iter(older.values())).nodes[0].nodes_of_step[0] if older else TimelineNode(run, 0)
    nodes = [root] if parent is None else parent.nodes[: first + 1]
    scales = [*([] if parent is None else parent.scales_until(first)), *shown.scales]
    steps: list[list[RunAction]] = []
    for entry in expect_list(plain.get("steps"), "steps"):
        numbers, count = expect_list(entry, "steps")
        if type(count) is not int or not 0 < count <= MAX_BRANCH_STEPS - len(steps):
            raise ValueError(f"steps repeat {quote_value(count)} times but must be {MAX_BRANCH_STEPS} at most.")
        if any(type(one) is not int or not 0 <= one < len(actions) for one in expect_list(numbers, "steps")):
            raise ValueError(f"steps name the action {quote_value(numbers)}, which does not exist.")
        steps += [[actions[one] for one in numbers]] * count
    if not steps:
        raise ValueError(f"branch {shown.identity} is not one that a run can have.")
    for step, taken in enumerate(steps, first):
        # every entry but the first is a step, followed by the changes of its state
        if [at for at, action in enumerate(taken) if isinstance(action, StepAction)] != ([0] if step > first else []):
            raise ValueError(f"branch {shown.identity} is not one that a run can have.")
        node = nodes[-1] if step > first else nodes.pop()
        for action in taken:
            node = TimelineNode(run, step, node, action)
        nodes.append(node)
    steered = bool(older) or bool(nodes[0].actions) or any(at.actions != nodes[1].actions for at in nodes[1:])
    metrics = BranchMetrics(figures)
    return Branch(shown.identity, shown.name[:40], run, nodes, scales, steered, shown.renamed, metrics)


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
    plain: JsonObject, places: Mapping[int, tuple[StoredRun, Branch]], image: ImageReference
) -> tuple[BranchStep, State]:
    """Read a state and its place; steering, regions and charges are those of the action of its step."""
    number, step = (int(expect_number(plain.get(name), f"{name} of a state")) for name in ("branch", "step"))
    run, line = places[number]
    if not 0 < step <= line.last:
        raise ValueError(f"there is no step {step} of branch {number}.")
    spacing = (run.document.image or image).spacing
    state = state_from_json(plain.get("state"), image.shape, run.document.parameters.scales, spacing)
    taken = line.nodes[step].actions[0]
    if state.step != step or not isinstance(taken, StepAction):
        raise ValueError(f"the state of step {step} is that of step {state.step}.")
    steering = RUN_METHODS[MODES[run.document.mode].method].steering(taken.parameters)
    regions, charges = taken.regions, sort_charges(taken.charges)
    return (number, step), replace(state, steering=steering, regions=regions, charges=charges)
