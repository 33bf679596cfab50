"""The run on the worker thread: how a document and its edits change it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import replace
from typing import Any

from app.model.document.document import Document
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import Overlays, Snapshot
from app.session.timeline.run_actions import Erased, Joined, RunAction
from app.session.timeline.stored_runs import StoredRuns
from app.session.worker.prepared_methods import OverlayMaker, PreparedMethods
from app.session.worker.reconstruction import Reconstructor
from app.session.worker.recorded_run import Begun
from app.session.worker.stepper import Stepper
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics.types import Place
from cpm_core.parameters import Parameters
from cpm_core.segmentation.method import Method, Steerable
from cpm_core.shapes.image_starts import ImageSeeds


class Run(Stepper):
    """The run that the worker thread steps; no other thread touches it."""

    def __init__(
        self,
        prepared: PreparedMethods,
        snapshots: Mailbox[Snapshot],
        overlays: Mailbox[Overlays],
        reconstructor: Reconstructor,
    ) -> None:
        super().__init__(snapshots, reconstructor, prepared.method)
        self.image_generation = 0
        self._prepared = prepared
        self._overlays = OverlayMaker(overlays)
        self._erasures: dict[int, tuple[tuple[int, int], tuple[int, int]]] = {}

    def use(self, generation: int, method: Method[Any], parameters: Parameters) -> None:
        """Change to another image, with the method that is prepared for it."""
        self.hand_edits = ()
        self.discard(generation)
        self.recorded.clear()
        self._erasures.clear()
        self.image_generation = generation
        self._prepared.use(method)
        self.method, self.charges, self.parameters = method, (), parameters
        self._refresh_overlays()

    def rescale(self, image: Image, document: Document) -> None:
        """Use another size of a pixel from the next start on; a run that exists keeps its own."""
        self._prepared.rescale(image)
        if self.state is None:
            self.method = self._prepared.method(document)
            self._refresh_overlays()

    def start(self, generation: int, document: Document) -> None:
        """Start a run from the initialization and the mode of a document, without a step."""
        self.discard(generation)
        if self.method is None:
            raise ValueError("There is no image to run on: open one first.")
        seeds = self._prepared.seeds(document)
        self.parameters, self.charges = document.parameters, document.charges
        self.method = self._prepared.method(document)
        self._refresh_overlays()
        self.state = self.method.start(seeds)
        self.recorded.begin(self.method, self.state, self._record, Begun(document, generation))
        self._send()

    def restore(self, stored: StoredRuns) -> str:
        """Take over the runs of a session, none of which is shown yet; what one of them failed at, if any."""
        if self.method is not None:
            self._reconstructor.number_as(self.method.image, stored.numbers)
        return self.recorded.restore(stored, lambda method, document: method.start(self._prepared.seeds(document)))

    def stored(self, drawn: Mapping[int, Counter[Hashable]]) -> StoredRuns:
        """All runs for a session, with the numbers of their contours; `drawn` as for `RecordedRun.stored`."""
        stored = self.recorded.stored(drawn)
        return (
            stored if self.method is None else replace(stored, numbers=self._reconstructor.numbers(self.method.image))
        )

    def seeds_for(self, document: Document) -> ImageSeeds:
        """Seeds of the starts of a document that depend on the image."""
        return self._prepared.image_seeds(document)

    def set_parameters(self, parameters: Parameters) -> None:
        """Use these from the next step on."""
        self.parameters = parameters
        self._refresh_overlays()
        if not self.stepping:
            self._reconstruct()

    def place(self, image_generation: int, charges: tuple[PlacedCharge, ...]) -> bool:
        """Use these placed charges on this image from the next step on; whether a run that had ended goes on."""
        if image_generation != self.image_generation:
            return False
        self.charges = charges
        self._refresh_overlays()
        return self._go_on()

    def limit(self, regions: AnyRegions | None) -> bool:
        """Use these regions and barriers from the next step on; whether a run that had ended goes on."""
        if self.method is None or regions == self.method.regions:
            return False
        self.method = self.method.with_regions(regions)
        self._prepared.keep(self.method)
        self._refresh_overlays()
        return self._go_on()

    def join(self, document: Document) -> bool:
        """Add the particles of a document's starts; whether a run that had ended goes on."""
        if not isinstance(self.method, Steerable) or self.state is None:
            return False
        ended = bool(self.state.stop_reason)
        self._do(Joined.at(self._prepared.seeds(document), self.method.regions))
        return ended and self._keep_going()

    def erase(self, path: tuple[Place, ...], radius: float, erasure: int) -> None:
        """Remove the particles near a path; those of one `erasure`, which has a number, are brought back together.

        The first that is removed begins a branch, so that the state before it is a place on the timeline.
        """
        here = self.recorded.timeline.here
        if not isinstance(self.method, Steerable) or self.state is None or here is None:
            return
        count, known = self.state.count, erasure in self._erasures
        action = Erased(path, radius, self.method.regions)
        removes = not known and action.apply(self.method, self.state).count < count
        if removes:
            self._record = self._record.until(len(self._record))
        self._do(action, apart=removes)
        after = self.recorded.timeline.here
        if (removes or known) and after is not None:
            self._erasures[erasure] = (self._erasures[erasure][0] if known else here, after)
        if self.state.stop_reason:
            self._remaining = 0.0

    def turn_erasures(self, erasures: tuple[int, ...], back: bool) -> None:
        """Go to the state before the last of some erasures, or to the one after it; stay where none removed any."""
        known = [self._erasures[erasure] for erasure in erasures if erasure in self._erasures]
        if known:
            before, after = known[-1]
            self.go_to(*(before if back else after), lambda: True)

    def _do(self, action: RunAction, apart: bool = False) -> None:
        """Apply an action to the current state; `apart` on a branch of its own."""
        assert self.method is not None
        self.state = action.apply(self.method, self.state)
        self.recorded.amend(action, self.state, self._record, apart)
        self._send()

    def set_overlays(self, names: frozenset[str]) -> None:
        """Keep only these overlays up to date."""
        self._overlays.want(names)
        self._refresh_overlays()

    def _go_on(self) -> bool:
        """Continue a run that has ended."""
        if not isinstance(self.method, Steerable) or self.state is None or not self.state.stop_reason:
            return False
        self.state = self.state.resumed()
        self._send()
        return self._keep_going()

    def _refresh_overlays(self) -> None:
        self._overlays.refresh(self.image_generation, self.method, self.parameters, self.charges)
