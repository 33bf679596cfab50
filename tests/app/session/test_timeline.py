"""The timeline: every step again bit for bit, in bounded memory, whatever is recorded, sought, branched and dropped."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.session.timeline.runs_json import runs_from_json, runs_to_json
from cpm_app.session.timeline.timeline import MAX_TIMELINE_RUNS, Timeline
from cpm_app.session.timeline.timeline_nodes import JoinAction, StepAction
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from cpm_core import Engine, Parameters
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.regions import Regions
from cpm_core.model.coverage import no_coverage
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.starts import circle
from cpm_core.model.state import Particles
from cpm_core.shapes import Circle

AMPLE = 10**9


def toy(count: int = 5) -> PlaneState:
    """A state that costs next to nothing to step."""
    position = np.arange(2.0 * count).reshape(count, 2)
    return PlaneState(Particles.at_rest(position), position, (64, 64), 1, coverage=no_coverage((64, 64)))


@dataclass(frozen=True)
class Toy:
    """An action and its value."""

    kind: str
    value: float
    regions: None = None

    def apply_to(self, method: ToyMethod, state: PlaneState) -> PlaneState:
        """Take it; runs of other documents differ."""
        return toy_step(state, self, method.shift)


class ToyMethod:
    """The method of a run."""

    regions = None

    def __init__(self, document: Document) -> None:
        self.shift = document.parameters.beta

    def with_regions(self, regions: None) -> ToyMethod:
        return self


def toy_step(state: PlaneState, action: Toy, shift: float = 0.0) -> PlaneState:
    """A step that no two actions have in common, nor two runs, nor the same action twice."""
    kind, value = action.kind, action.value + 0.25 * shift
    particles = state.particles
    position = particles.position * 1.000001 + value + state.step
    moved = replace(state, particles=replace(particles, position=position))
    if kind == "change":
        return moved
    return replace(moved, step=state.step + 1, scale=0 if state.step >= 6 else 1)


def same(one: PlaneState, other: PlaneState) -> bool:
    """Whether two states agree in every bit."""
    arrays = ("position", "velocity", "force", "distance", "identity")
    alike = all(getattr(one.particles, name).tobytes() == getattr(other.particles, name).tobytes() for name in arrays)
    fields = ("step", "step_of_scale", "scale", "annealed", "next_identity", "idle", "quiet", "stop_reason", "steering")
    grounds = all(a.tobytes() == b.tobytes() for a, b in zip(one.coverage[:2], other.coverage[:2], strict=True))
    return alike and grounds and all(getattr(one, name) == getattr(other, name) for name in fields)


def begin(timeline: Timeline, beta: float = 0.0) -> PlaneState:
    """Begin a run of its own."""
    document = Document(parameters=Parameters(beta=beta))
    timeline.begin_run(toy(), document)
    return toy()


class TimelineMachine(RuleBasedStateMachine):
    """Operations in any order give the states of a simple model that keeps all states."""

    @initialize(budget=st.sampled_from([1, 3_000, 12_000, AMPLE]))
    def begin(self, budget: int) -> None:
        self.timeline = Timeline(ToyMethod, budget)
        self.begun, self.shifts = 0.0, {}
        self.book: dict[int, list[PlaneState]] = {}
        self.begin_a_run()

    @rule()
    def begin_a_run(self) -> None:
        self.begun += 0.01
        self.state = begin(self.timeline, self.begun)
        self.shifts[self.timeline.current_run] = self.begun
        self._forget_removed()
        self.book[self.timeline.current_step[0]] = [self.state]

    @rule()
    def leave(self) -> None:
        self.timeline.leave_run()
        self.state = None

    @precondition(lambda self: self.timeline.current_step is not None)
    @rule(value=st.integers(0, 2), count=st.integers(1, 9))
    def step(self, value: int, count: int) -> None:
        for _ in range(count):
            self._do(Toy("step", value))

    @precondition(lambda self: self.timeline.current_step is not None)
    @rule(value=st.integers(0, 2))
    def change(self, value: int) -> None:
        self._do(Toy("change", value))

    @rule(data=st.data())
    def go(self, data: st.DataObject) -> None:
        branch = data.draw(st.sampled_from(sorted(self.book)))
        step = data.draw(st.integers(0, len(self.book[branch]) - 1))
        state = self.timeline.go_to(branch, step)
        assert same(state, self.book[branch][step])
        self.state = state
        self._forget_removed()  # the run that it came from is the current one no longer

    @precondition(lambda self: len(self.book) > 1)
    @rule(data=st.data())
    def drop(self, data: st.DataObject) -> None:
        branch = data.draw(st.sampled_from(sorted(self.book)))
        self.timeline.remove_branch(branch)
        del self.book[branch]
        if self.timeline.current_step is not None:
            branch, step = self.timeline.current_step
            self.state = self.book[branch][step]

    @rule(budget=st.sampled_from([1, 3_000, 12_000, AMPLE]))
    def change_budget(self, budget: int) -> None:
        self.timeline.set_budget(budget)
        self._forget_removed()

    def _forget_removed(self) -> None:
        """Runs that have fallen are gone as a whole, and never the current one or the newest."""
        there = {branch.identity for branch in self.timeline.timeline_state.branches}
        self.book = {branch: states for branch, states in self.book.items() if branch in there}
        assert self.timeline.current_step is None or self.timeline.current_step[0] in there
        assert len({branch.run for branch in self.timeline.timeline_state.branches}) <= MAX_TIMELINE_RUNS

    def _do(self, action: Toy) -> None:
        timeline, before = self.timeline, self.timeline.current_step
        self.state = toy_step(self.state, action, self.shifts[timeline.current_run])
        if action.kind == "step":
            timeline.record_step(action, self.state, {})
        else:
            timeline.amend_state(action, self.state)
        self._forget_removed()
        branch, step = timeline.current_step
        if branch not in self.book:
            self.book[branch] = self.book[before[0]][: before[1] + 1]
        book = self.book[branch]
        if action.kind == "change":
            assert step == before[1] == len(book) - 1
            book[step] = self.state
        elif step < len(book):
            assert same(book[step], self.state)
        else:
            book.append(self.state)

    @invariant()
    def every_step_is_recovered_bit_for_bit(self) -> None:
        here = self.timeline.current_step
        assert here is None or same(self.timeline.compute_state(*here), self.state)
        for branch, states in self.book.items():
            for step in {0, len(states) // 2, len(states) - 1}:
                assert same(self.timeline.compute_state(branch, step), states[step])
        assert self.timeline.current_step == here

    @invariant()
    def steps_are_contiguous(self) -> None:
        branches = {branch.identity: branch for branch in self.timeline.timeline_state.branches}
        assert branches.keys() == self.book.keys()
        for branch in branches.values():
            last = self.timeline.compute_state(branch.identity, 10**6)
            assert last is not None and last.step == len(self.book[branch.identity]) - 1
            assert branch.parent is None or branches[branch.parent].first <= branch.first
        runs = [branch.run for branch in branches.values() if branch.parent is None]
        assert sorted(runs) == sorted({branch.run for branch in branches.values()})
        assert all(branches[b.parent].run == b.run for b in branches.values() if b.parent is not None)

    @invariant()
    def memory_stays_within_its_bounds(self) -> None:
        timeline = self.timeline
        assert timeline._states.used <= timeline._states.budget or len(timeline._states) <= 3
        kept = timeline._states._states.values()
        arrays = {
            id(array): array.nbytes
            for state in kept
            for array in (*(getattr(state.particles, name) for name in vars(state.particles)), *state.coverage[:2])
            if array is not None
        }
        assert timeline._states.used == sum(arrays.values())


TestTimeline = TimelineMachine.TestCase
TestTimeline.settings = settings(max_examples=30, stateful_step_count=25, deadline=None)


def recorded(count: int, budget: int = AMPLE) -> tuple[Timeline, list[PlaneState]]:
    """A timeline of one branch."""
    timeline = Timeline(ToyMethod, budget)
    states = [begin(timeline)]
    for _ in range(count):
        states.append(one_step(timeline, states[-1]))
    return timeline, states


def one_step(timeline: Timeline, state: PlaneState, value: float = 1.0) -> PlaneState:
    """The next state, recorded with its value as the figure of its step."""
    action = Toy("step", value)
    state = toy_step(state, action)
    timeline.record_step(action, state, {"epsilon": value})
    return state


def test_a_new_run_keeps_the_runs_before_it() -> None:
    timeline, states = recorded(10)
    one_step(timeline, begin(timeline, 0.5), 2.0)
    assert [branch.name for branch in timeline.timeline_state.branches] == ["Run 1", "Run 2"]
    assert same(timeline.go_to(1, 10), states[10])
    timeline.leave_run()
    assert timeline.current_step is None
    assert same(timeline.go_to(1, 7), states[7])


def test_the_oldest_runs_fall_first_and_those_with_a_name_of_their_own_last() -> None:
    timeline, _ = recorded(2)
    timeline.rename_branch(1, "the good one")
    for number in range(MAX_TIMELINE_RUNS + 2):
        one_step(timeline, begin(timeline, 0.01 * number + 0.01))
    branches = timeline.timeline_state.branches
    assert [branches[0].name, branches[1].name] == ["the good one", "Run 5"]
    timeline.set_budget(1)
    assert [branch.run for branch in timeline.timeline_state.branches] == [timeline.current_run]


def test_a_run_that_is_deleted_gives_way_to_the_one_before() -> None:
    timeline, states = recorded(4)
    one_step(timeline, begin(timeline, 0.5))
    timeline.remove_branch(2)
    assert timeline.current_step == (1, 4)
    assert same(timeline.compute_state(1, 4), states[4])


def test_going_on_by_the_same_actions_repeats_the_branch_and_by_others_begins_one() -> None:
    timeline, states = recorded(10)
    timeline.go_to(1, 4)
    one_step(timeline, states[4])
    assert timeline.current_step == (1, 5)
    assert len(timeline.timeline_state.branches) == 1
    one_step(timeline, states[5], 2.0)
    kept, new = timeline.timeline_state.branches
    assert (kept.last, new.parent, new.first, new.last) == (10, kept.identity, 5, 6)
    timeline.go_to(new.identity, 5)
    one_step(timeline, states[5])
    assert timeline.current_step == (kept.identity, 6)


_row, _col = np.indices((64, 64))
ENGINE = Engine(np.where(np.hypot(_row - 32, _col - 32) < 18.0, 200.0, 20.0), Parameters())


def test_branches_that_share_only_the_first_step_of_a_deleted_one_come_back_from_a_session(
    compiled_loops: None,
) -> None:
    reference = ImageReference("a.png", "a.png", (64, 64), 180.0)
    document, timeline = Document(reference, (Circle((32.0, 32.0), 6.0),)), Timeline(lambda _: ENGINE)
    state = ENGINE.start(document.collect_seeds())
    timeline.begin_run(state, document)
    for place in ((10.0, 10.0), (50.0, 50.0)):
        timeline.go_to(1, 0)
        action = JoinAction((place,))
        timeline.amend_state(action, action.apply_to(ENGINE, state), on_own_branch=True)
    timeline.remove_branch(1)
    stored, fault = runs_from_json(json.loads(json.dumps(runs_to_json(timeline.to_stored_runs({})))), reference)
    again = Timeline(lambda _: ENGINE)
    again.restore_runs(stored, lambda method, begun: method.start(begun.collect_seeds()))
    assert fault == ""
    assert [branch.parent for branch in again.timeline_state.branches] == [None, None]
    for branch in (2, 3):
        before, after = timeline.compute_state(branch, 0), again.compute_state(branch, 0)
        np.testing.assert_array_equal(after.position, before.position)
        assert after.count == state.count + 1


def test_steps_under_placed_charges_and_moved_barriers_are_recovered_bit_for_bit(compiled_loops: None) -> None:
    barrier = Regions(barriers=(((10.0, 20.0), (50.0, 20.0)),))
    charge = (PlacedCharge((20.0, 40.0), 2.0),)
    features = (
        StepAction(Parameters()),
        StepAction(Parameters(), charge),
        StepAction(Parameters(), charge, barrier),
        StepAction(Parameters(beta=0.4), (), barrier),
        StepAction(Parameters()),
    )
    engines = {None: ENGINE, barrier: ENGINE.with_regions(barrier)}
    timeline, states = Timeline(lambda _: ENGINE, 1), [ENGINE.start(circle((32.0, 32.0), 10.0))]
    timeline.begin_run(states[0], Document())
    for step in range(50):
        action = features[step // 10]
        engine = engines[action.regions]
        states.append(engine.step(states[-1], action.parameters, action.charges))
        timeline.record_step(action, states[-1], engine.measure_state(states[-1], action.parameters))
    assert len(timeline._states) <= 2
    for step in (49, 12, 31, 5):
        assert same(timeline.go_to(1, step), states[step])
        assert timeline.timeline_state.parameters == features[(step - 1) // 10].parameters
        assert list(timeline.metrics_until(1, step).step) == list(range(1, step + 1))


def test_records_for_plots_follow_their_branches() -> None:
    timeline, states = recorded(20)
    timeline.go_to(1, 5)
    state = states[5]
    for _ in range(10):
        state = one_step(timeline, state, 2.0)
    assert list(timeline.metrics_until(1, 20).epsilon) == [1.0] * 20
    assert list(timeline.metrics_until(2, 15).epsilon) == [1.0] * 5 + [2.0] * 10
    assert timeline.remove_branch(2).step == 5
    assert timeline.current_step == (1, 5)
