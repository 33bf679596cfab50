"""The run of one method on its own thread: it can be held, led on by single steps, and looked back on."""

from __future__ import annotations

import threading
import time
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.model.text.language import tr
from app.session.exchange.error_messages import sentence
from app.session.exchange.mailbox import Mailbox
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.objects.methods import CONTOUR_METHODS, Facts, Moment, Start, facts_of, moments

_LEAST_PAUSE, _SHARE = 0.005, 4.0
"""Time after a state that is shown in which none is: at least so long [s], and so many times what showing it took."""

_MOST_KEPT = 200
"""How many states of a run are kept to look back on; from there on every second one is forgotten."""


@dataclass(frozen=True, eq=False, slots=True)
class Order:
    """What is run: a method on an image from a start, with its settings."""

    method: str
    image: Image
    start: Start
    settings: Any
    truth: Truth | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """What is shown of a run: lines and particles at a step, with the facts; `trouble` is why it failed."""

    order: Order
    contours: tuple[Contour, ...] = ()
    points: Array = field(default_factory=lambda: np.empty((0, 2)))
    facts: Facts | None = None
    over: bool = False
    trouble: str = ""

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.order.method

    @property
    def step(self) -> int:
        """Number of steps so far."""
        return self.facts.steps if self.facts else 0


class History:
    """States of a run by their steps: its newest one, and some of all before."""

    def __init__(self) -> None:
        self._frames: tuple[Frame, ...] = ()  # replaced as a whole, so that no thread waits for another

    def __len__(self) -> int:
        return len(self._frames)

    def add(self, frame: Frame) -> None:
        """Keep a state; when there are too many, every second one but the newest is forgotten."""
        frames = self._frames
        if len(frames) >= _MOST_KEPT:
            frames = frames[::2]
        self._frames = (*frames, frame)

    def at(self, share: float) -> Frame | None:
        """The last state that is kept up to a share of the steps, from 0 to 1; None while there is none."""
        frames = self._frames
        if not frames:
            return None
        steps = [frame.step for frame in frames]
        return frames[max(bisect_right(steps, share * steps[-1]) - 1, 0)]


class MethodRun:
    """A method on its own thread; the newest frame waits in a mailbox. `held`: it waits after its start."""

    def __init__(self, order: Order, held: bool) -> None:
        self.frames: Mailbox[Frame] = Mailbox()
        self.history = History()
        self._order = order
        self._gate = threading.Condition()
        self._held, self._steps, self._stopped = held, 0, False
        self.thread = threading.Thread(target=self._run, name=f"cpm-compare-{order.method}", daemon=True)
        self.thread.start()

    def hold(self) -> None:
        """Wait after the present step."""
        with self._gate:
            self._held, self._steps = True, 0

    def go_on(self) -> None:
        """Run on."""
        with self._gate:
            self._held = False
            self._gate.notify()

    def step(self) -> None:
        """Do one more step while it is held."""
        with self._gate:
            self._steps += 1
            self._gate.notify()

    def stop(self) -> None:
        """End after the present step."""
        with self._gate:
            self._stopped = True
            self._gate.notify()

    def _run(self) -> None:
        method = self._order.method
        try:
            for frame in self._shown():
                self.history.add(frame)
                self.frames.put(frame)
        except Exception as error:  # an error is shown in its place, and the others go on
            title = CONTOUR_METHODS[method].title
            trouble = sentence(error, tr("running {name}").format(name=title))
            self.frames.put(Frame(self._order, over=True, trouble=trouble))

    def _shown(self) -> Iterator[Frame]:
        order, due = self._order, 0.0
        for moment in moments(CONTOUR_METHODS[order.method], order.image, order.start, order.settings):
            over = bool(moment.state.stop_reason)
            began = time.perf_counter()
            shown = over or began >= due
            if shown:
                yield _frame(order, moment, over)
                ended = time.perf_counter()
                due = ended + max(_LEAST_PAUSE, _SHARE * (ended - began))
            while not self._let_on(wait=shown):  # what is seen while it waits is where it waits
                yield _frame(order, moment, over)
                shown = True
            if self._stopped:
                return

    def _let_on(self, wait: bool) -> bool:
        """Whether the next step may be done, or all is to end; waits for that if it is told to."""
        with self._gate:
            free = self._gate.wait_for(self._may_go_on, None if wait else 0.0)
            if free:
                self._steps = max(self._steps - 1, 0)
            return free

    def _may_go_on(self) -> bool:
        return self._stopped or not self._held or self._steps > 0


def _frame(order: Order, moment: Moment, over: bool) -> Frame:
    """What is shown of a moment: of particles that move only the particles, whose contours take longer to find."""
    state, points = moment.state, moment.state.points
    if len(points) and not over:
        return Frame(order, (), points, Facts(order.method, state.step, moment.seconds, False, "", 0))
    return Frame(order, state.contours, points, facts_of(moment, order.truth if over else None), over)
