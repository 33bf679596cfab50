"""The worker executes all commands in order; of snapshots the newest wins; no window is needed."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.session.exchange.mailbox import Mailbox
from cpm_app.session.exchange.messages import (
    ImageOpened,
    Reconstruction,
    RunContinued,
    RunFailed,
    SeedsFound,
    Snapshot,
)
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.session.worker import commands, prepared_methods
from cpm_app.session.worker.commands import (
    WorkerCommand,
    call_run,
    compile_kernels,
    find_seeds,
    start_run,
    write_files,
)
from cpm_app.session.worker.run import Run
from cpm_app.session.worker.worker_thread import WorkerThread
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Image, Parameters, Regions, uniform_grid
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.model.state import Particles
from cpm_core.parameters.provenance import Provenance
from cpm_core.shapes import Barrier, Everywhere, Points


def disc() -> np.ndarray:
    """A bright disc of radius 18 in the middle."""
    row, col = np.indices((64, 64))
    return np.where(np.hypot(row - 32, col - 32) < 18, 200.0, 20.0)


DOCUMENT = Document(shapes=(Points(((5.0, 5.0), (6.0, 6.0))),))


@dataclass(frozen=True)
class FakeState:
    """A state that counts its steps and remembers the damping of each."""

    step: int = 0
    betas: tuple[float, ...] = ()
    scale: int = 0
    epsilon: float = 0.5
    count: int = 2
    born: int = 0
    deleted: int = 0
    next_identity: int = 2
    charges: tuple[PlacedCharge, ...] = ()
    stop_reason: str = ""
    converged: bool = False
    steering: tuple[object, ...] = ()
    position: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))
    particles: Particles = field(default_factory=lambda: Particles.at_rest(np.zeros((2, 2))))

    def resume(self) -> FakeState:
        return replace(self, stop_reason="")

    def list_arrays(self) -> tuple[np.ndarray, ...]:
        return (self.position,)


@dataclass(frozen=True)
class FakeResult:
    """A result without contours."""

    steps: int
    contours: tuple[()] = ()
    spacing: tuple[float, ...] = (1.0, 1.0)
    shape: tuple[int, ...] = (9, 9)
    surface: None = None
    provenance: Provenance = field(default_factory=Provenance, compare=False)


class FakeEngine:
    """An engine without physics."""

    name, title, parameters, seeded = "cpm", "Fake", ("beta",), True

    def __init__(
        self, image: Image, parameters: Parameters, regions: Regions | None, made: list[FakeEngine] | None = None
    ) -> None:
        self.image = image
        self.regions = regions
        self.scales = parameters.scales
        self.of = parameters
        self.made = [] if made is None else made
        self.made.append(self)
        self.charges: list[tuple[PlacedCharge, ...]] = []
        self.states: list[FakeState] = []
        self.last_step, self.unfinished = 10**9, False
        self.gate = threading.Event()
        self.gate.set()
        self.reconstructing = threading.Event()
        self.reconstructing.set()

    def start(self, seeds: np.ndarray) -> FakeState:
        self.seeds = seeds
        return FakeState()

    def with_regions(self, regions: Regions | None) -> FakeEngine:
        other = FakeEngine(self.image, self.of, regions, self.made)
        other.last_step = self.last_step
        return other

    def step(self, state: FakeState, parameters: Parameters, charges: tuple[PlacedCharge, ...] = ()) -> FakeState:
        assert self.gate.wait(20)
        self.charges.append(charges)
        if parameters.beta == 4.0:
            raise RuntimeError("kernel fell over")
        reason = "far enough" if state.step + 1 >= self.last_step else ""
        following = replace(
            state,
            step=state.step + 1,
            betas=(*state.betas, parameters.beta),
            stop_reason=reason,
            converged=bool(reason) and not self.unfinished,
            steering=parameters.steering,
        )
        self.states.append(following)
        return following

    steering = staticmethod(lambda parameters: parameters.steering)
    edge_map = force_field = potential = add_particles = erase_particles = forces = lambda *_: None  # not used here

    def can_start(self, parameters: Parameters) -> bool:
        return parameters.scales == self.scales

    def measure_state(self, state: FakeState, parameters: Parameters) -> dict[str, float]:
        return {"epsilon": state.epsilon, "count": state.count}

    def result(self, state: FakeState, parameters: Parameters) -> FakeResult:
        assert self.reconstructing.wait(20)
        return FakeResult(state.step)


class Bench:
    """A runner on fake engines."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.engines: list[FakeEngine] = []
        self.warm = threading.Event()
        self.hold = threading.Event()
        self.hold.set()
        self._build = partial(FakeEngine, made=self.engines)
        self._build.seeded = True  # type: ignore[attr-defined]
        monkeypatch.setattr(prepared_methods, "RUN_METHODS", {"cpm": self._build})
        monkeypatch.setattr(commands, "to_bytes", self._encode)
        monkeypatch.setattr(commands, "warm_up_runs", self._warm_up)
        self.worker_thread = WorkerThread()
        self.reports: list[object] = []
        self.written: list[object] = []
        self.shown: Reconstruction | None = None

    def _encode(self, result: object, *_: object, **__: object) -> bytes:
        self.written.append(result)
        return b""

    def _warm_up(self, unwanted: Callable[[], bool], told: Callable[[float], object]) -> None:
        assert self.hold.wait(20)
        self.warm.set()

    def open(self, generation: int = 1) -> FakeEngine:
        image = Image(np.eye(64), source="good.png")
        engine = self._build(image, Parameters(), None)
        opened = ImageOpened(image, engine, None, Path("good.png"), Parameters(), ())  # type: ignore[arg-type]
        self.worker_thread.post_command(call_run(None, Run.use_image, generation, opened.method, opened.parameters))
        return engine

    def take(self) -> None:
        self.reports += self.worker_thread.take_reports()

    def take_contours(self) -> Reconstruction | None:
        """Show the newest contours, as a window does."""
        newest = self.worker_thread.run.reconstructor.results.take()
        self.shown = newest or self.shown
        return newest

    def wait(self, condition: Callable[[], object]) -> None:
        end = time.monotonic() + 20
        while not condition():
            self.take()
            assert time.monotonic() < end
            time.sleep(0.001)
        self.take()

    def run_to_the_end(self, last_step: int) -> tuple[FakeEngine, Snapshot | None]:
        """Open, start as run 2 and run to the end; return the newest snapshot too."""
        engine = self.open()
        engine.last_step = last_step
        self.worker_thread.post_command(start_run(2, 1, DOCUMENT))
        self.worker_thread.post_command(call_run(2, Run.take_steps))
        return engine, self.settle()

    def settle(self) -> Snapshot | None:
        """Wait until nothing goes on; return the newest snapshot."""
        newest: list[Snapshot] = []

        def idle() -> bool:
            snapshot = self.worker_thread.run.snapshots.take()
            if snapshot is not None:
                newest.append(snapshot)
            self.worker_thread.run.overlays.take()
            self.take_contours()
            self.take()
            return self.worker_thread.idle

        self.wait(idle)
        return newest[-1] if newest else None


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    made = Bench(monkeypatch)
    yield made
    for engine in made.engines:
        engine.gate.set()
    made.worker_thread.close()


def test_commands_are_obeyed_in_order_and_none_is_lost(bench: Bench) -> None:
    engine = bench.open()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    betas = [0.1 * k for k in range(1, 40)]
    for beta in betas:
        bench.worker_thread.post_command(call_run(None, Run.set_parameters, Parameters(beta=beta)))
        bench.worker_thread.post_command(call_run(2, Run.take_steps, 1))
        bench.worker_thread.post_command(call_run(None, Run.halt))
        bench.worker_thread.post_command(call_run(2, Run.take_steps, 1))
    snapshot = bench.settle()
    # Halt may be executed before or after the step, but later parameters never act on earlier steps.
    assert snapshot is not None
    seen = engine.states[-1].betas
    assert list(seen) == sorted(seen)
    assert snapshot.state.step == len(seen)
    assert set(seen) <= set(betas)


def test_parameters_sent_between_steps_act_at_exactly_the_next_one(bench: Bench) -> None:
    engine = bench.open()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    for beta in (0.5, 1.5, 1.0):
        bench.worker_thread.post_command(call_run(None, Run.set_parameters, Parameters(beta=beta)))
        bench.worker_thread.post_command(call_run(2, Run.take_steps, 1))
        bench.settle()
    assert engine.states[-1].betas == (0.5, 1.5, 1.0)


def test_a_stopped_run_does_not_go_on(bench: Bench) -> None:
    engine, _ = bench.run_to_the_end(3)
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    assert bench.settle() is None
    assert len(engine.states) == 3


def test_a_stopped_run_goes_on_with_other_parameters(bench: Bench) -> None:
    engine, _ = bench.run_to_the_end(3)
    bench.worker_thread.post_command(call_run(None, Run.set_parameters, Parameters(beta=1.5)))
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    bench.settle()
    assert [state.betas[-1] for state in engine.states] == [0.8, 0.8, 0.8, 1.5]


def test_a_run_that_ended_before_it_came_to_rest_goes_on_from_there(bench: Bench) -> None:
    engine = bench.open()
    engine.last_step, engine.unfinished = 3, True
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    assert bench.settle().state.stop_reason
    engine.last_step, engine.unfinished = 7, False
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    snapshot = bench.settle()
    assert (snapshot.state.step, snapshot.state.converged) == (7, True)
    assert len(snapshot.timeline.branches) == 1
    assert len(engine.states) == 7


def test_what_was_meant_for_another_image_or_run_is_not_obeyed(bench: Bench) -> None:
    engine = bench.open(generation=5)
    bench.worker_thread.post_command(start_run(6, 4, DOCUMENT))
    bench.worker_thread.post_command(call_run(6, Run.take_steps))
    bench.worker_thread.post_command(start_run(7, 5, DOCUMENT))
    bench.worker_thread.post_command(call_run(None, Run.discard_state, 8))
    bench.worker_thread.post_command(call_run(7, Run.take_steps))
    bench.settle()
    assert engine.states == []


def test_other_scales_make_another_engine_at_the_next_start_only(bench: Bench) -> None:
    bench.open()
    bench.worker_thread.post_command(call_run(None, Run.set_parameters, Parameters(scales=2)))
    bench.settle()
    assert len(bench.engines) == 1
    bench.worker_thread.post_command(start_run(2, 1, replace(DOCUMENT, parameters=Parameters(scales=2))))
    bench.settle()
    assert [engine.scales for engine in bench.engines] == [3, 2]


def test_limits_go_to_another_engine_at_the_next_start_and_stay_until_they_change(bench: Bench) -> None:
    bench.open()
    barrier = Barrier(((1.0, 1.0), (1.0, 9.0)))
    limited = replace(DOCUMENT, shapes=(*DOCUMENT.shapes, barrier))
    for generation, document in enumerate((limited, limited, DOCUMENT), start=2):
        bench.worker_thread.post_command(start_run(generation, 1, document))
        bench.settle()
    assert [engine.regions for engine in bench.engines] == [None, Regions(barriers=(barrier.points,)), None]


def test_placed_charges_act_at_the_next_step_and_of_many_moves_the_last_wins(bench: Bench) -> None:
    engine = bench.open()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    charges = [(PlacedCharge((1.0, float(col)), 1.0),) for col in range(9)]
    moves = [call_run(None, Run.set_charges, 1, placed) for placed in charges]
    while_busy(bench, (*moves, call_run(2, Run.take_steps, 1)))
    bench.worker_thread.post_command(call_run(None, Run.set_charges, 1, ()))
    bench.worker_thread.post_command(call_run(None, Run.set_charges, 0, charges[3]))
    bench.worker_thread.post_command(call_run(None, Run.set_charges, 1, ()))
    bench.worker_thread.post_command(call_run(2, Run.take_steps, 1))
    bench.settle()
    assert engine.charges == [charges[-1], ()]


def test_a_run_that_has_ended_goes_on_when_a_charge_is_placed_and_a_halted_one_does_not(bench: Bench) -> None:
    engine = bench.open()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    bench.worker_thread.post_command(call_run(2, Run.take_steps, 2))
    bench.settle()
    bench.worker_thread.post_command(call_run(None, Run.set_charges, 1, (PlacedCharge((1.0, 1.0), 1.0),)))
    bench.settle()
    assert len(engine.states) == 2
    engine.last_step = 3
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    bench.settle()
    assert engine.states[-1].stop_reason
    engine.last_step = 6
    bench.worker_thread.post_command(call_run(None, Run.set_charges, 1, ()))
    bench.settle()
    assert len(engine.states) == 6
    assert [report.generation for report in bench.reports if isinstance(report, RunContinued)] == [2]


def test_of_many_wishes_for_places_to_start_from_only_the_last_is_worked_out(bench: Bench) -> None:
    bench.open()
    documents = [edits.toggle_everywhere(replace(DOCUMENT, parameters=Parameters(smoothing=s)), "grid") for s in (1, 2)]
    while_busy(bench, (find_seeds(1, document) for document in (*documents, *documents)))
    (found,) = [report for report in bench.reports if isinstance(report, SeedsFound)]
    assert found.generation == 1
    np.testing.assert_array_equal(found.image_seeds[Everywhere("grid")], uniform_grid((64, 64)))


def while_busy(bench: Bench, commands: Iterable[WorkerCommand]) -> None:
    """Post commands that all wait before the first of them is executed."""
    bench.settle()
    bench.hold = threading.Event()
    bench.worker_thread.post_command(compile_kernels())
    for command in commands:
        bench.worker_thread.post_command(command)
    bench.hold.set()
    bench.settle()


def test_of_sixty_moves_of_a_slider_only_the_last_is_executed_and_drawn(bench: Bench, monkeypatch) -> None:
    engine, drawn, used = bench.open(), [], []
    engine.edge_map = lambda parameters: drawn.append(parameters.smoothing) or np.eye(64)
    bench.worker_thread.post_command(call_run(None, Run.set_overlays, frozenset({"edge_map"})))
    bench.settle()
    drawn.clear()
    monkeypatch.setattr(Run, "reconstruct_if_halted", lambda run: used.append(run.parameters.smoothing))
    moves = [Parameters(smoothing=0.05 * k) for k in range(1, 61)]
    seeded = edits.toggle_everywhere(DOCUMENT, "grid")  # whose seeds are looked for after each move
    while_busy(
        bench,
        (
            command
            for move in moves
            for command in (call_run(None, Run.set_parameters, move), find_seeds(1, replace(seeded, parameters=move)))
        ),
    )
    assert used == drawn == [3.0]


@given(st.lists(st.integers(0, 9), min_size=2, max_size=24))
@settings(max_examples=25, deadline=None)
def test_commands_that_are_left_out_change_nothing(picked: list[int]) -> None:
    def make(number: int, choice: int) -> WorkerCommand:
        placed = (PlacedCharge((1.0, float(number)), 1.0),)
        makers = (
            lambda: call_run(None, Run.set_parameters, Parameters(beta=0.1 + 0.01 * number)),
            lambda: call_run(None, Run.set_parameters, Parameters(beta=1.0)),
            lambda: call_run(None, Run.set_charges, 1, placed),
            lambda: call_run(2, Run.set_regions, Regions(barriers=(((1.0, 1.0), (1.0, number + 2.0)),))),
            lambda: call_run(2, Run.take_steps, 1),
            lambda: call_run(2, Run.take_steps, 2),
            lambda: call_run(None, Run.halt),
            lambda: start_run(2, 1, replace(DOCUMENT, parameters=Parameters(beta=0.5 + 0.01 * number))),
            lambda: call_run(2, Run.go_to, 0, 1),
            lambda: find_seeds(1, DOCUMENT),
        )
        return makers[choice]()

    ends = []
    with pytest.MonkeyPatch.context() as patch:
        for every in (True, False):
            bench = Bench(patch)
            bench.run_to_the_end(2)
            commands = [make(number, choice) for number, choice in enumerate(picked)]
            while_busy(bench, (replace(command, kind=None) if every else command for command in commands))
            run = bench.worker_thread.run
            ends.append((run.parameters, run.charges, run.method.regions, run.state.betas, run.timeline.current_step))
            bench.worker_thread.close()
    assert ends[0] == ends[1]


def test_an_engine_that_fails_is_reported_in_a_sentence_and_the_worker_lives(bench: Bench, caplog) -> None:
    bench.open()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    bench.worker_thread.post_command(call_run(None, Run.set_parameters, Parameters(beta=4.0)))
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    bench.settle()
    (failed,) = [report for report in bench.reports if isinstance(report, RunFailed)]
    assert failed.generation == 2
    assert "kernel fell over" in failed.message
    assert "kernel fell over" in caplog.text
    bench.worker_thread.post_command(call_run(None, Run.set_parameters, Parameters()))
    bench.worker_thread.post_command(call_run(2, Run.take_steps, 2))
    snapshot = bench.settle()
    assert snapshot is not None
    assert snapshot.state.step == 2


def test_the_last_state_is_always_reconstructed(bench: Bench) -> None:
    engine = bench.open()
    engine.last_step = 400
    results = []
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    bench.worker_thread.post_command(call_run(2, Run.take_steps))

    def done() -> bool:
        bench.worker_thread.run.snapshots.take()
        reconstruction = bench.worker_thread.run.reconstructor.results.take()
        if reconstruction is not None:
            results.append(reconstruction.result.steps)
        return bench.worker_thread.idle

    bench.wait(done)
    assert results[-1] == 400
    assert results == sorted(results)


def test_closing_waits_for_the_step_that_is_being_taken_and_no_more(bench: Bench) -> None:
    engine = bench.open()
    engine.gate.clear()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    bench.wait(lambda: bench.worker_thread.run.snapshots.take() is not None)
    closing = threading.Thread(target=bench.worker_thread.close)
    closing.start()
    engine.gate.set()
    closing.join(20)
    assert not closing.is_alive()
    bench.worker_thread.close()


def test_a_mailbox_gives_the_newest_once() -> None:
    box: Mailbox[int] = Mailbox()
    assert box.take() is None
    for number in (1, 2, 3):
        box.put(number)
    assert box.take() == 3
    assert box.take() is None


def export(bench: Bench, shown: Reconstruction | None = None) -> None:
    order = ExportOrder((ExportFile(Path("a.csv"), "contours", ".csv"),))
    bench.worker_thread.post_command(
        write_files(BackgroundTask("Writing a.csv…"), shown, Document(), order, lambda contents: None)
    )


def test_what_is_written_is_the_very_reconstruction_that_is_shown(bench: Bench) -> None:
    bench.run_to_the_end(3)
    export(bench)
    bench.settle()
    assert bench.written == [bench.shown.result]
    assert bench.written[0].steps == 3


def test_the_export_of_a_held_run_waits_for_the_contours_of_its_last_state(bench: Bench) -> None:
    engine = bench.open()
    engine.reconstructing.clear()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    bench.worker_thread.post_command(call_run(2, Run.take_steps, 5))
    bench.wait(lambda: len(engine.states) == 5)
    export(bench)
    time.sleep(0.1)
    assert bench.written == []
    engine.reconstructing.set()
    bench.settle()
    assert [result.steps for result in bench.written] == [5]
    assert bench.written == [bench.shown.result]


def test_the_export_during_a_run_writes_the_contours_shown_at_its_request(bench: Bench) -> None:
    engine = bench.open()
    bench.worker_thread.post_command(start_run(2, 1, DOCUMENT))
    bench.worker_thread.post_command(call_run(2, Run.take_steps))
    bench.wait(lambda: bench.take_contours() is not None)
    shown = bench.shown
    steps = len(engine.states)
    bench.wait(lambda: len(engine.states) > steps + 100)
    export(bench, shown)
    bench.wait(lambda: bench.written)
    bench.worker_thread.post_command(call_run(None, Run.halt))
    bench.settle()
    assert bench.written == [shown.result]
