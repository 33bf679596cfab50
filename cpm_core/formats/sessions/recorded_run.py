"""Runs in session files: recorded for the window to show with their contours, and the state shown is restored."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from cpm_core.field.placed_charges import PlacedCharge, sort_charges
from cpm_core.formats.common.json_values import (
    expect_mapping,
    from_json,
    parameters_from_json,
    regions_from_json,
    regions_to_json,
    shape_to_json,
    to_json,
)
from cpm_core.formats.sessions.particle_state import state_from_json, state_to_json
from cpm_core.formats.sessions.session_file import SessionFile, decode_session, encode_session
from cpm_core.formats.sessions.session_run import method_of
from cpm_core.image.image import Image
from cpm_core.model.state import State
from cpm_core.numerics.types import JsonDict
from cpm_core.parameters import Parameters
from cpm_core.shapes.document_shapes import collect_charges, collect_regions, select_starts

_ONLY_BRANCH = 1
"""Number of the only branch of a written run."""


@dataclass
class RunRecorder:
    """Recorder of the last state of a run and of the steps at which its scales begin; called with each state."""

    state: State | None = None
    scales: list[tuple[int, int]] = field(default_factory=list)

    def __call__(self, state: State) -> None:
        """Record a state."""
        if not self.scales or self.scales[-1][1] != state.scale:
            self.scales.append((state.step if self.scales else 0, state.scale))
        self.state = state


def add_recorded_run(session: SessionFile, recorder: RunRecorder, name: str = "Run 1") -> SessionFile:
    """Add the run made by the shapes and parameters of a session, at its end."""
    state = recorder.state
    if state is None:
        return session
    regions = collect_regions(session.shapes, session.objects.barriers)
    action: JsonDict = {"step": {}, "charges": [to_json(charge) for charge in collect_charges(session.shapes)]}
    action |= regions_to_json(regions)
    bare = replace(session, image=None, view={}, extra={}, runs={}, truth=None)
    branch = {
        "identity": _ONLY_BRANCH,
        "name": name,
        "parent": None,
        "first": 0,
        "last": state.step,
        "steps": [[[], 1], [[0], state.step]],
        "scales": [list(scale) for scale in recorder.scales],
    }
    run = {
        "document": json.loads(encode_session(replace(bare, pages={}), Path())),
        "drawn": [shape_to_json(start) for start in select_starts(session.shapes)],
        "actions": [action],
        "branches": [branch],
    }
    kept = {"branch": _ONLY_BRANCH, "step": state.step, "state": state_to_json(state)}
    runs = {"here": [_ONLY_BRANCH, state.step], "runs": [run], "states": [kept]}
    return replace(session, runs=runs)


def restore_shown_state(session: SessionFile, image: Image) -> tuple[State, str, Parameters, Parameters] | None:
    """Restore the state of a run that the window shows; None if it was not kept.

    Returned with it are the name of the run's method, the parameters of its step, and those with which its contours are
    shown.
    """
    runs = session.runs
    try:
        number, step = runs["here"]
        run, branch = next((run, one) for run in runs["runs"] for one in run["branches"] if one["identity"] == number)
        plain = next(one["state"] for one in runs["states"] if (one["branch"], one["step"]) == (number, step))
        begun = decode_session(json.dumps(run["document"]).encode(), "the beginning of a run")
        begins = np.cumsum([branch["first"], *(count for _, count in branch["steps"])])
        numbers, _ = branch["steps"][np.searchsorted(begins, step, "right") - 1]
        action = run["actions"][numbers[0]]
        parameters, _ = parameters_from_json({**to_json(begun.parameters), **expect_mapping(action["step"], "action")})
        shown = parameters_from_json(runs["parameters"])[0] if "parameters" in runs else parameters
        charges = tuple(from_json(PlacedCharge, one, "charge") for one in action.get("charges", []))
        regions = regions_from_json(action, "regions")
        state = state_from_json(plain, image.shape, begun.parameters.scales, image.spacing)
    except (KeyError, TypeError, ValueError, IndexError, OverflowError, StopIteration):
        return None
    state = replace(state, steering=parameters.steering, regions=regions, charges=sort_charges(charges))
    return state, method_of(begun), parameters, shown
