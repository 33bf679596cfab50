"""The run on the worker thread: engine, state and parameters, and what is sent up after each step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from app.model.document.document import Document
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import Overlays, Snapshot
from app.session.exchange.pacing import Pacer
from app.session.timeline.run_actions import Erased, Joined, RunAction, Stepped
from app.session.worker.overlays import OVERLAYS
from app.session.worker.potential_energy import PotentialEnergySampler
from app.session.worker.reconstruction import Reconstructor, Request
from app.session.worker.recorded_run import RecordedRun
from app.session.worker.run_record import RunRecord
from cpm_core.contours.result import Result
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Position
from cpm_core.parameters import PARAMETERS, Parameters
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine
from cpm_core.shapes.image_starts import NO_SEEDS, ImageSeeds, SeedCache

RESTING_SPEED = 0.1
"""Speed under which a particle is shown as resting [px per unit of time]."""


class Run:
    """What the worker thread works on; only that thread touches it.

    Parameters
    ----------
    build : callable
        Image, parameters and what limits the particles to engine.
    snapshots, overlays : Mailbox
        Where the newest particles and overlays are left.
    reconstructor : Reconstructor
        Who makes contours of the newest particles.
    """

    def __init__(
        self,
        build: Callable[[Image, Parameters, Regions | None], Engine],
        snapshots: Mailbox[Snapshot],
        overlays: Mailbox[Overlays],
        reconstructor: Reconstructor,
    ) -> None:
        self.pacer = Pacer()
        self.recorded = RecordedRun()
        self.energy_sampler = PotentialEnergySampler()
        self.generation = 0
        self.image_generation = 0
        self._build = build
        self._snapshots = snapshots
        self._overlays = overlays
        self._reconstructor = reconstructor
        self._engine: Engine | None = None
        self._charges: tuple[PlacedCharge, ...] = ()
        self._seed_cache: SeedCache | None = None
        self._state: State | None = None
        self._parameters = Parameters()
        self._record = RunRecord()
        self._remaining = 0.0
        self._wanted: frozenset[str] = frozenset()
        self._shown: tuple[object, ...] = ()

    @property
    def stepping(self) -> bool:
        """Whether steps are to be taken."""
        return self._remaining > 0

    @property
    def engine(self) -> Engine | None:
        """The engine of the image, None while there is none."""
        return self._engine

    @property
    def state(self) -> State | None:
        """The particles as they are now, None where none have been started."""
        return self._state

    @property
    def parameters(self) -> Parameters:
        """Those of the next step."""
        return self._parameters

    def use(self, generation: int, engine: Engine, parameters: Parameters) -> None:
        """Change to another image, with the engine that has been built for it."""
        self.discard(generation)
        self.image_generation = generation
        self._engine, self._charges, self._parameters = engine, (), parameters
        self._seed_cache = SeedCache(engine.image)
        self._refresh_overlays()

    def start(self, generation: int, document: Document) -> None:
        """Begin with the particles that a document's drawing gives; they do not move yet."""
        self.discard(generation)
        if self._engine is None:
            raise ValueError("There is no image to run on: open one first.")
        seeds = document.seeds(self.seeds_for(document))
        self._parameters, self._charges = document.parameters, document.charges
        if document.parameters.scales != self._engine.scales:
            self._engine = self._build(self._engine.image, document.parameters, document.regions)
        elif document.regions != self._engine.regions:
            self._engine = self._engine.with_regions(document.regions)
        self._refresh_overlays()
        self._state = self._engine.start(seeds)
        self.recorded.begin(self._engine, self._state, self._record)
        self._send()

    def seeds_for(self, document: Document) -> ImageSeeds:
        """Positions from which a document starts all over the image."""
        if self._seed_cache is None:
            return NO_SEEDS
        return self._seed_cache.seeds_for(document.sowable, document.parameters.smoothing, document.regions)

    def go(self, steps: int | None) -> None:
        """Step from now on, `steps` times or until told otherwise; a run that has ended only with other parameters."""
        if self._state is not None and self._state.stop_reason and self._state.steering != self._parameters.steering:
            self._state = self._state.resumed()
        if self._state is not None and not self._state.stop_reason:
            self._remaining = float("inf") if steps is None else self._remaining + steps
            self.pacer.begin()

    def halt(self) -> None:
        """Stop and keep the particles."""
        self._remaining = 0.0
        self._reconstruct()

    def discard(self, generation: int) -> None:
        """Stop and forget the particles."""
        self.generation = generation
        self._remaining = 0.0
        self._state = None
        self._record = RunRecord()
        self.recorded.clear()
        self._reconstructor.forget()

    def set_parameters(self, parameters: Parameters) -> None:
        """Use these from the next step on."""
        self._parameters = parameters
        self._refresh_overlays()
        if not self.stepping:
            self._reconstruct()

    def place(self, charges: tuple[PlacedCharge, ...]) -> bool:
        """Let the particles feel these from the next step on; whether a run goes on with them that had ended."""
        self._charges = charges
        self._refresh_overlays()
        return self._go_on()

    def limit(self, regions: Regions | None) -> bool:
        """Hold the particles back by these from the next step on; whether a run goes on with them that had ended."""
        if self._engine is None or regions == self._engine.regions:
            return False
        self._engine = self._engine.with_regions(regions)
        self._refresh_overlays()
        return self._go_on()

    def join(self, document: Document) -> bool:
        """Add the particles of a document's starts; whether a run goes on with them that had ended."""
        if self._engine is None or self._state is None:
            return False
        ended = bool(self._state.stop_reason)
        self._do(Joined(document.seeds(self.seeds_for(document)).tobytes(), self._engine.regions))
        return ended and self._keep_going()

    def erase(self, path: tuple[Position, ...], radius: float) -> None:
        """Take away the particles near a path."""
        if self._engine is not None and self._state is not None:
            self._do(Erased(path, radius, self._engine.regions))
            if self._state.stop_reason:
                self._remaining = 0.0

    def _do(self, action: RunAction) -> None:
        """Change the particles where the run stands."""
        if self._engine is not None and self._state is not None:
            self._state = action.apply(self._engine, self._state)
            self.recorded.amend(action, self._state, self._record)
            self._send()

    def set_overlays(self, names: frozenset[str]) -> None:
        """Keep these up to date."""
        self._wanted, self._shown = names, ()
        self._refresh_overlays()

    def step(self) -> None:
        """Take one step and send up what came of it."""
        if self._engine is None or self._state is None:
            self._remaining = 0.0
            return
        self._state = self._engine.step(self._state, self._parameters, self._charges)
        self._remaining = 0.0 if self._state.stop_reason else self._remaining - 1
        self.pacer.stepped()
        self._record.record(self._state, self.energy_sampler.potential(self._engine, self._state, self._parameters))
        action = Stepped(self._parameters, self._charges, self._engine.regions)
        self.recorded.record(action, self._state, self._record)
        self._send()

    def go_to(self, branch: int, step: int, wanted: Callable[[], bool]) -> None:
        """Hold, and stand at another step of the timeline; nothing but that changes when it is no longer wanted."""
        self._remaining = 0.0
        there = self.recorded.go(branch, step, wanted)
        if there is not None:
            self._state, self._record = there
            self._send(looking_back=True)

    def drop_branch(self, branch: int) -> None:
        """Forget a branch of the timeline; whoever stood on it stands where it began."""
        before = self._state
        self._state, self._record = self.recorded.drop(branch)
        if self._state is not before:
            self._remaining = 0.0
        self._send(looking_back=True)

    def tell(self) -> None:
        """Send up how things stand, where there is anything."""
        self._send()

    def result(self) -> Result:
        """Contours of the particles as they are now."""
        if self._engine is None or self._state is None:
            raise ValueError("There is nothing to export yet: let the particles run first.")
        return self._engine.result(self._state, self._parameters)

    def result_of(self, state: State) -> Result:
        """Contours of another state of the run."""
        if self._engine is None:
            raise ValueError("There is no image to run on: open one first.")
        return self._engine.result(state, self._parameters)

    def moment(self, branch: int, step: int, wanted: Callable[[], bool]) -> Snapshot | None:
        """Another moment of the run as it would be shown, without going there; None when no longer wanted."""
        found = self.recorded.moment(branch, step, wanted)
        return None if found is None else self._snapshot(*found)

    def _go_on(self) -> bool:
        """Set a run going again that has ended."""
        if self._state is None or not self._state.stop_reason:
            return False
        self._state = self._state.resumed()
        self._send()
        return self._keep_going()

    def _keep_going(self) -> bool:
        self._remaining = float("inf")
        self.pacer.begin()
        return True

    def _send(self, looking_back: bool = False) -> None:
        if self._state is not None:
            self._snapshots.put(self._snapshot(self._state, self._record))
            self._reconstruct(looking_back)

    def _snapshot(self, state: State, record: RunRecord) -> Snapshot:
        speed = np.linalg.norm(state.particles.velocity, axis=1) * 2.0**state.scale
        return Snapshot(
            generation=self.generation,
            state=state,
            position=state.position,
            resting=speed < RESTING_SPEED,
            steps_per_second=self.pacer.per_second,
            metrics=record.metrics(),
            timeline=self.recorded.outline,
        )

    def _reconstruct(self, looking_back: bool = False) -> None:
        """Ask for contours; of the drawing only to show that there are none, where somebody goes back to it."""
        if self._engine is not None and self._state is not None and (self._state.step > 0 or looking_back):
            # Whoever scrubs wants the next moment at once, and contours only of where he stays.
            last = not self.stepping and not looking_back
            self._reconstructor.ask(Request(self.generation, self._engine, self._state, self._parameters, last))

    def _refresh_overlays(self) -> None:
        """Send overlays up when some are wanted and differ from those last sent."""
        if self._engine is None or not self._wanted:
            return
        made_of = [getattr(self._parameters, name) for name, info in PARAMETERS.items() if info.invalidates == "field"]
        key = (self._engine, self._wanted, self._charges, *made_of)
        if key == self._shown:
            return
        arrays = {name: OVERLAYS[name](self._engine, self._parameters, self._charges) for name in self._wanted}
        self._overlays.put(Overlays(self.image_generation, arrays))
        self._shown = key
