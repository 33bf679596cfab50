"""The run on the worker thread: its steps, moves along the timeline, and changes by the document and its edits."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_app.model.display.display_image import DisplayImage, shade_area
from cpm_app.model.document.document import Document
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.mailbox import Mailbox, Pacer
from cpm_app.session.exchange.messages import OverlayData, Overlays, Reconstruction, Snapshot, explain_failure
from cpm_app.session.timeline.branches import StoredRuns
from cpm_app.session.timeline.timeline import Timeline
from cpm_app.session.timeline.timeline_nodes import EraseAction, JoinAction, RunAction, StepAction
from cpm_app.session.worker.prepared_methods import AREA_OVERLAY, PreparedMethods, compute_overlay
from cpm_app.session.worker.reconstruction import ReconstructionRequest, Reconstructor
from cpm_core import Engine, Image, Method, Parameters, PlacedCharge, Result, Skeleton, State
from cpm_core.formats import describe_shapes
from cpm_core.image import AnyRegions
from cpm_core.numerics import Place
from cpm_core.numerics.polyline import as_line
from cpm_core.parameters import UNLIMITED_REACH, find_invalidating
from cpm_core.segmentation import MethodState, Steerable
from cpm_core.shapes import ImageSeeds

RESTING_SPEED = 0.1
"""Speed below which a particle is shown as at rest [px per unit of time]."""

_NO_OVERLAY = ((), None, "")
"""An overlay that has not been made yet."""


class Run:
    """The run that the worker thread steps: a method, its state and its parameters; no other thread touches it."""

    def __init__(self, prepared: PreparedMethods, is_closing: Callable[[], bool]) -> None:
        self.snapshots: Mailbox[Snapshot] = Mailbox()
        self.overlays: Mailbox[Overlays] = Mailbox()
        self.reconstructor = Reconstructor()
        self.pacer = Pacer()
        self.timeline = Timeline(prepared.method_for)
        self.generation = 0
        self.image_generation = 0
        self.method: Method[Any] | None = None
        self.state: MethodState | None = None
        self.parameters = Parameters()
        self.charges: tuple[PlacedCharge, ...] = ()
        self._drawn = Document()
        self._prepared, self._is_closing = prepared, is_closing
        self._overlays: dict[str, tuple[tuple[object, ...], OverlayData | None, str]] = {}
        """What each requested overlay has been made of, the overlay, and the error; the one made last is the last."""
        self._erasing_gesture = ""
        """The gesture that has begun a branch by the removal of particles last."""
        self._remaining = 0.0

    # The image and the document

    def use_image(self, generation: int, method: Method[Any], parameters: Parameters) -> None:
        """Change to another image, with the method that has been prepared for it."""
        self.discard_state(generation)
        self.timeline.clear()
        self.image_generation = generation
        self._prepared.use_image(method)
        self.method, self.charges, self.parameters = method, (), parameters
        self._overlays = dict.fromkeys(self._overlays, _NO_OVERLAY)

    def change_pixel_size(self, image: Image, document: Document) -> None:
        """Use another pixel size from the next start on; an existing run keeps its own."""
        self._prepared.change_pixel_size(image)
        if self.state is None:
            self.method = self._prepared.method_for(document)

    def start(self, generation: int, document: Document) -> None:
        """Start a run from the initialization and the mode of a document, without a step."""
        self.discard_state(generation)
        if self.method is None:
            raise ValueError("There is no image to run on: open one first.")
        seeds = self._prepared.compute_seeds(document)
        self.parameters, self.charges = document.parameters, document.charges
        self.method = self._prepared.method_for(document)
        self.state = self.method.start(seeds)
        self.timeline.begin_run(self.state, document, generation)
        self._send_snapshot()

    def restore_runs(self, stored: StoredRuns) -> None:
        """Take over the runs of a session, none of which is shown yet; raise ValueError if one cannot begin."""
        self.timeline.restore_runs(
            stored, lambda method, document: method.start(self._prepared.compute_seeds(document))
        )

    def compute_image_seeds(self, document: Document) -> ImageSeeds:
        """Return the seeds of the starts of a document that depend on the image."""
        return self._prepared.compute_image_seeds(document)

    def set_parameters(self, parameters: Parameters, goes_on: bool = False) -> bool:
        """Use these parameters from the next step on; return whether a run that had ended continues.

        It `goes_on` if they were set during the run, which may have ended before they arrive.
        """
        if parameters == self.parameters:
            return False
        self.parameters = parameters
        self.reconstruct_if_halted()
        if not goes_on or self.method is None or self.state is None:
            return False
        return self.state.steering != self.method.steering(parameters) and self._resume_ended()

    def set_start(self, document: Document) -> None:
        """Show the area of a document's start as long as there is no run."""
        self._drawn = document

    def set_charges(self, image_generation: int, charges: tuple[PlacedCharge, ...], resumes: bool = True) -> bool:
        """Use these placed charges from the next step on this image; return whether a run that had ended continues."""
        if image_generation != self.image_generation:
            return False
        self.charges = charges
        return resumes and self._resume_ended()

    def set_regions(self, regions: AnyRegions | None, resumes: bool = True) -> bool:
        """Use these regions and barriers from the next step on; return whether a run that had ended continues."""
        if self.method is None or regions == self.method.regions:
            return False
        self.method = self.method.with_regions(regions)
        self._prepared.keep_method(self.method)
        return resumes and self._resume_ended()

    def add_particles(self, document: Document) -> bool:
        """Add the particles of a document's starts; return whether a run that had ended continues, on a branch."""
        if not isinstance(self.method, Steerable) or self.state is None:
            return False
        ended = bool(self.state.stop_reason)
        joined = JoinAction(as_line(self._prepared.compute_seeds(document)), self.method.regions)
        self._apply_action(joined, on_own_branch=ended)
        return ended and self._step_without_limit()

    def erase_particles(self, path: tuple[Place, ...], radius: float, gesture: str) -> None:
        """Remove the particles near a path.

        The first removal of a gesture begins a branch, so that the state before it stays on the timeline.
        """
        if not isinstance(self.method, Steerable) or self.state is None:
            return
        action = EraseAction(path, radius, self.method.regions)
        begins = gesture != self._erasing_gesture
        begins = begins and action.apply_to(self.method, self.state).count < self.state.count
        self._apply_action(action, on_own_branch=begins)
        if begins:
            self._erasing_gesture = gesture
        if self.state.stop_reason:
            self._remaining = 0.0

    def _apply_action(self, action: RunAction, on_own_branch: bool) -> None:
        """Apply an action to the current state; if `on_own_branch`, on a branch of its own."""
        assert self.method is not None
        self.state = action.apply_to(self.method, self.state)
        self.timeline.amend_state(action, self.state, on_own_branch)
        self._send_snapshot()

    def set_overlays(self, names: frozenset[str]) -> None:
        """Keep only these overlays up to date."""
        self._overlays = {name: self._overlays.get(name, _NO_OVERLAY) for name in names}

    def _resume_ended(self) -> bool:
        """Continue a run that has ended."""
        if not isinstance(self.method, Steerable) or self.state is None or not self.state.stop_reason:
            return False
        self.state = self.state.resume()
        self._send_snapshot()
        return self._step_without_limit()

    def refresh_overlay(self) -> bool:
        """Compute one of the requested overlays that would differ from its last version; return whether there was one.

        The one made longest ago comes first, so that all of them follow a slider that is moved.
        """
        made_of = [getattr(self.parameters, name) for name in find_invalidating("field")]
        keys: dict[str, tuple[object, ...]] = dict.fromkeys(self._overlays, (self.method, self.charges, *made_of))
        if AREA_OVERLAY in keys:
            keys[AREA_OVERLAY] = self._start_inputs(*made_of)
        name = next((name for name, made in self._overlays.items() if made[0] != keys[name]), None)
        if self.method is None or name is None:
            return False
        overlay: OverlayData | None = None
        trouble = ""
        try:
            if name == AREA_OVERLAY:
                overlay = self._compute_start_area() if keys[name] else None
            else:
                overlay = compute_overlay(name, self.method, self.parameters, self.charges)
        except Exception as error:  # the run does not depend on overlays
            trouble = explain_failure(error, tr("preparing the overlays"))
        del self._overlays[name]
        self._overlays[name] = keys[name], overlay, trouble
        arrays = {name: overlay for name, (_, overlay, _) in self._overlays.items() if overlay is not None}
        troubles = (trouble for *_, trouble in self._overlays.values() if trouble)
        self.overlays.put(Overlays(self.image_generation, arrays, next(troubles, "")))
        return True

    def _start_inputs(self, *made_of: object) -> tuple[object, ...]:
        """Return what the area of the start depends on besides what the field is `made_of`; empty if there is none."""
        if self.parameters.reach >= UNLIMITED_REACH:
            return ()
        if isinstance(self.state, State):
            return self.method, self.state.start.tobytes(), *made_of
        return self.image_generation, self.state is None, self._drawn, *made_of

    def _compute_start_area(self) -> DisplayImage | None:
        """Compute the overlay of the area of the run, or of one from the document; without edges, the whole image."""
        method, state = self.method, self.state
        if state is None and self._drawn.starts:
            method = self._prepared.method_for(self._drawn)
        if not isinstance(method, Engine) or method.image.ndim == 3:
            return None
        if state is None and self._drawn.starts:
            with suppress(ValueError):  # nothing of the start is in the image: said when a run is to begin there
                state = method.start(self._prepared.compute_seeds(self._drawn))
        if not isinstance(state, State):
            return None
        area = method.start_area(state.start, self.parameters)
        if area is None:
            area = np.ones(method.image.shape, bool)
        return DisplayImage.from_shades(shade_area(area))

    # Steps

    @property
    def is_stepping(self) -> bool:
        """Whether steps remain to be taken."""
        return self._remaining > 0

    def take_steps(self, steps: int | None = None) -> None:
        """Take a number of steps, or all until `halt`; a run at rest continues only with other parameters."""
        if self.method is None or self.state is None:
            return
        unfinished = self.state.count and not self.state.converged
        if self.state.stop_reason and (unfinished or self.state.steering != self.method.steering(self.parameters)):
            self.state = self.state.resume()
        if not self.state.stop_reason:
            self._remaining = float("inf") if steps is None else self._remaining + steps
            self.pacer.start_measuring()

    def halt(self) -> None:
        """Stop and keep the particles."""
        self._remaining = 0.0
        self._request_contours()

    def reconstruct_if_halted(self) -> None:
        """Reconstruct the contours of the present state at once, unless steps remain to be taken."""
        if not self.is_stepping:
            self._request_contours()

    def discard_state(self, generation: int) -> None:
        """Stop and remove the particles; the run stays on the timeline, the next one has this generation."""
        self.generation = generation
        self._remaining = 0.0
        self.state = None
        self.timeline.leave_run()
        self.reconstructor.drop_waiting()

    def take_step(self) -> None:
        """Take one step and send a snapshot."""
        if self.method is None or self.state is None:
            self._remaining = 0.0
            return
        method, parameters = self.method, self.parameters
        state = self.state = method.step(self.state, parameters, self.charges)
        self._remaining = 0.0 if state.stop_reason else self._remaining - 1
        self.pacer.count_step()
        measures = method.measure_state(state, parameters)
        self.timeline.record_step(StepAction(parameters, self.charges, method.regions), state, measures)
        self._send_snapshot()

    def go_to(self, branch: int, step: int, is_wanted: Callable[[], bool] = lambda: True) -> None:
        """Pause and go to another step of the timeline; if that is no longer wanted, only pause."""
        self._remaining = 0.0
        before = self.timeline.current_run

        def is_still_wanted() -> bool:
            return is_wanted() and not self._is_closing()

        state = self.timeline.go_to(branch, step, is_still_wanted) if is_still_wanted() else None
        if state is not None:
            self._show_state(state, before)

    def remove_branch(self, branch: int) -> None:
        """Remove a branch of the timeline; if the run is on it, go back to where it began."""
        before = self.timeline.current_run
        state = self.timeline.remove_branch(branch)
        if state is not None:
            if state is not self.state:
                self._remaining = 0.0
            self._show_state(state, before)

    def _show_state(self, state: MethodState, before: int) -> None:
        """Use and show a state of the timeline; `before` is the number of the previous run."""
        self.state = state
        if self.timeline.current_run != before:
            self.method = self.timeline.method_of_run(
                self.timeline.current_run, None if self.method is None else self.method.regions
            )
        self._send_snapshot(looking_back=True)

    def rename_branch(self, branch: int, name: str) -> None:
        """Rename a branch of the timeline."""
        self.timeline.rename_branch(branch, name)
        self._send_snapshot()

    def set_timeline_budget(self, budget: int) -> None:
        """Set the largest size of the states that the timeline keeps [bytes]."""
        self.timeline.set_budget(budget)
        self._send_snapshot()

    def set_pace(self, steps_per_second: float | None) -> None:
        """Set the largest number of steps per second; None for no limit."""
        self.pacer.set_limit(steps_per_second)

    def wait_for_reconstruction(
        self, shown: Reconstruction | None, is_wanted: Callable[[], bool]
    ) -> Reconstruction | None:
        """Return the contours that the user sees: `shown` during a run, else the contours of its last state.

        Waits for contours that are still being made; None if they are no longer wanted.
        """
        if self.is_stepping and shown is not None and shown.generation == self.generation:
            return shown
        found = self.reconstructor.wait_for_latest(self.generation, is_wanted)
        if found is None and is_wanted():
            raise ValueError("There is nothing to export yet: start a run first.")
        return found

    def with_provenance(self, result: Result | Skeleton) -> Result | Skeleton:
        """Add to a result, for files, the shapes drawn for the run and whether it was steered."""
        if self.state is None:
            return result
        shapes = describe_shapes(self.timeline.starting_shapes)
        made = replace(result.provenance, shapes=shapes, steered=self.timeline.steered)
        return replace(result, provenance=made)

    def reconstruct_state(self, branch: int, state: MethodState) -> Result | Skeleton:
        """Reconstruct the contours of a state of another branch."""
        if self.method is None:
            raise ValueError("There is no image to run on: open one first.")
        method = self.timeline.method_of_run(self.timeline.run_of(branch), self.method.regions)
        return method.result(state, self.parameters)

    def take_snapshot(self, branch: int, step: int, is_wanted: Callable[[], bool]) -> Snapshot | None:
        """Return a snapshot of another step, without going there; None if it is no longer wanted."""
        state = self.timeline.compute_state(branch, step, is_wanted)
        return None if state is None else self._make_snapshot(state, branch)

    def _step_without_limit(self) -> bool:
        self._remaining = float("inf")
        self.pacer.start_measuring()
        return True

    def _send_snapshot(self, looking_back: bool = False) -> None:
        if self.state is not None and self.timeline.current_step is not None:
            self.snapshots.put(self._make_snapshot(self.state, self.timeline.current_step[0]))
            self._request_contours(looking_back)

    def _make_snapshot(self, state: MethodState, branch: int) -> Snapshot:
        assert self.method is not None
        speed = np.linalg.norm(state.particles.velocity, axis=1) * 2.0**state.scale
        return Snapshot(
            generation=self.generation,
            method=self.method.name,
            state=state,
            position=state.position,
            resting=speed < RESTING_SPEED,
            steps_per_second=self.pacer.per_second,
            metrics=self.timeline.metrics_until(branch, state.step),
            timeline=self.timeline.timeline_state,
        )

    def _request_contours(self, looking_back: bool = False) -> None:
        """Request contours; of the first state only if the run goes back to it, to show that there are none."""
        if self.method is None or self.state is None or not (self.state.step or looking_back):
            return
        # While the user scrubs, only the step at which this ends needs its contours at once.
        last = not self.is_stepping and not looking_back
        self.reconstructor.submit(
            ReconstructionRequest(self.generation, self.method, self.state, self.parameters, last)
        )
