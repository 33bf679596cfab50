"""Nodes of the timeline: states of runs, of which as many are kept as memory allows, linked by recorded actions."""

from __future__ import annotations

import math
from array import array
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cpm_app.model.display.plots import RunMetrics
from cpm_core import Method, Parameters, PlacedCharge
from cpm_core.image import AnyRegions
from cpm_core.numerics import Array, Place, polyline
from cpm_core.numerics.types import Sides, frozen
from cpm_core.segmentation import MethodState

BranchStep = tuple[int, int]
"""Branch and step."""

FIGURE_NAMES = tuple(field.name for field in fields(RunMetrics))
"""Names of the figures recorded for each step."""

_RECENT_SHARE = 3
"""Ratio of the states kept at multiples of the stride to those kept only because they were used recently."""


@dataclass(eq=False)
class TimelineNode:
    """A state of a run: its step, the node before it and the action that led from there; the first one has neither.

    An action that changes a state without a step leads to another node of the same step.
    """

    run: int
    step: int
    previous: TimelineNode | None = None
    action: RunAction | None = None

    @property
    def nodes_of_step(self) -> tuple[TimelineNode, ...]:
        """The nodes of its step up to itself: the one that the step led to, then one for each change of it."""
        before = self.previous
        return (*(() if before is None or before.step != self.step else before.nodes_of_step), self)

    @property
    def actions(self) -> tuple[RunAction, ...]:
        """The action that took the step, and those that changed its state afterwards."""
        return tuple(node.action for node in self.nodes_of_step if node.action is not None)


class StateCache:
    """States of at most `budget` bytes; the first of each run and the one at `current` are kept in any case.

    States whose step is a multiple of the stride are kept, so that every other state is a few steps from one of them.
    States in between are kept until a newer one needs their memory, so that single steps backward are fast. When the
    memory is full, the stride is doubled. Arrays shared by several states, such as the far force of successive steps,
    are counted once.
    """

    def __init__(self, budget: int) -> None:
        self.budget = budget
        self.current: TimelineNode | None = None
        self.clear()

    def __len__(self) -> int:
        return len(self._states)

    def get(self, node: TimelineNode) -> MethodState | None:
        """Return the state of a node and mark it as recently used; None if it is not kept."""
        state = self._states.pop(node, None)
        if state is not None:
            self._states[node] = state
        return state

    def put(self, node: TimelineNode, state: MethodState) -> None:
        """Keep the state of a node in place of the previous one."""
        self.drop(node)
        self._states[node] = state
        for values in state.list_arrays():
            self.used += 0 if self._owners[id(values)] else values.nbytes
            self._owners[id(values)] += 1
        self.evict_states()

    def drop(self, *nodes: TimelineNode) -> None:
        """Remove states."""
        for node in nodes:
            state = self._states.pop(node, None)
            for values in () if state is None else state.list_arrays():
                self._owners[id(values)] -= 1
                if not self._owners[id(values)]:
                    del self._owners[id(values)]
                    self.used -= values.nbytes

    def keep_only(self, run: int, nodes: set[TimelineNode]) -> None:
        """Remove the states of a run except for these nodes and the first one; without any nodes, remove all."""
        self.drop(*(one for one in self._states if one.run == run and one not in nodes and (one.previous or not nodes)))

    def clear(self) -> None:
        """Remove all states and restore the finest stride."""
        self.used, self.stride = 0, 1
        self._states: dict[TimelineNode, MethodState] = {}
        self._owners: Counter[int] = Counter()

    def evict_states(self) -> None:
        """Remove states until the others fit into the budget, the least recently used first."""
        while self.used > self.budget:
            free = [node for node in self._states if node.previous is not None and node is not self.current]
            if not free:
                return
            recent = [node for node in free if node.step % self.stride]
            if recent and _RECENT_SHARE * len(recent) > len(self._states) - len(recent):
                self.drop(recent[0])
            elif self.stride > max(node.step for node in free):
                self.drop(free[0])
            else:
                self.stride *= 2


class BranchMetrics:
    """Figures of a branch for plots, step by step, each in the order of `FIGURE_NAMES`."""

    def __init__(self, rows: Array | None = None) -> None:
        self._values = array("d", () if rows is None else rows.T.ravel())

    @property
    def rows(self) -> Array:
        """The figures of N steps, shape (K, N), one row for each name of `FIGURE_NAMES`."""
        return np.array(self._values).reshape(-1, len(FIGURE_NAMES)).T

    def add_step(self, step: int, measures: Mapping[str, float]) -> None:
        """Add one step unless it has been recorded already."""
        if not self._values or step > self._values[-len(FIGURE_NAMES)]:
            row = {"step": step, **measures}
            self._values.extend(row.get(name, math.nan) for name in FIGURE_NAMES)

    def copy_until(self, step: int) -> BranchMetrics:
        """Return a copy up to a step."""
        rows = self.rows
        return BranchMetrics(rows[:, rows[0] <= step])

    def metrics_until(self, step: float = math.inf) -> RunMetrics:
        """Return the metrics up to a step."""
        rows = self.rows
        return RunMetrics(*rows[:, : np.searchsorted(rows[0], step, side="right")])


@frozen
class StepAction:
    """One step with these parameters, placed charges and regions; it continues a run that had ended."""

    parameters: Parameters
    charges: tuple[PlacedCharge, ...] = ()
    regions: AnyRegions | None = None

    def apply_to(self, method: Method[Any], state: Any) -> Any:
        """Return the state after the step."""
        state = state.resume() if state.stop_reason else state
        return method.step(state, self.parameters, self.charges)


@frozen
class JoinAction:
    """Particles added at seeds."""

    seeds: tuple[tuple[float, ...], ...]
    regions: AnyRegions | None = None

    def apply_to(self, method: Any, state: Any) -> Any:
        """Return the state with the particles."""
        return method.add_particles(state, np.array(self.seeds))


@frozen
class EraseAction:
    """Removal of the particles within a radius of a path, in sides of the smallest pixel or voxel."""

    path: tuple[Place, ...]
    radius: float
    regions: AnyRegions | None = None

    def apply_to(self, method: Any, state: Any) -> Any:
        """Return the state without the particles."""
        return method.erase_particles(state, lambda at: self.is_near_path(at, method.image.spacing))

    def is_near_path(self, places: Array, spacing: Sides) -> ArrayLike:
        """Return whether each place, shape (N, D) [px], is within the radius of the path, shape (N,) bool."""
        sides = np.array(spacing) / min(spacing) if len(self.path[0]) == 3 else 1.0
        return polyline.distances_to_path(np.array(self.path) * sides, places * sides) <= self.radius


RunAction = StepAction | JoinAction | EraseAction
"""What changed a state, and the regions then: equal actions on equal states give equal states."""
