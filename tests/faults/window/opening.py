"""Damaged sessions, opened in the window: each is refused in one sentence, or shown, run on, and saved."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from random import Random

from cpm_app.session.exchange.messages import NotOpened, Opened
from cpm_app.views.features.files import OpenSaveFeature

from cpm_core.formats.sessions.session_file import load_session

from ..fuzzing.inputs.session_samples import IMAGE, SAMPLES, SESSION, write_images
from ..fuzzing.limits import check_sentence
from ..fuzzing.sessions import damaged
from ..report import Budget, Report, going_on
from .program import await_true, destroyed, discarding, opened, settled, surroundings
from .watch import Watch

_A_WINDOW = 20
"""Sessions that one window opens, one after the other."""

_STEPS = 3
_PATIENCE = 20.0
"""Time that opening, a step or the contours may take [s]."""


class Visitor:
    """A window in which a person opens one session after the other."""

    def __init__(self, image: Path) -> None:
        self.window = opened(image)
        self._said: list[tuple[str, bool]] = []
        self.opened = self._refused = 0
        session = self.window.session
        session.said.connect(lambda sentence, trouble, topic: self._said.append((sentence, trouble)))
        session.listen(Opened, self._count_opened)
        session.listen(NotOpened, self._count_refused)

    def look_at(self, path: Path) -> list[str]:
        """Open a session, look at it, let it run for a step, and save it; give what does not hold."""
        self._said.clear()
        before = self.opened, self._refused
        self.window.open_image(str(path))
        self._rest("opening")
        is_open, refused = self.opened > before[0], self._refused > before[1]
        broken = []
        if is_open == refused:
            broken.append("it is neither opened nor refused" if refused is False else "it is opened and refused")
        if refused and not any(trouble for _, trouble in self._said):
            broken.append("it is refused without a word")
        if is_open:
            self._use(path.with_name("again.cpm"))
        for sentence, trouble in self._said:
            try:
                check_sentence(ValueError(sentence if trouble else f"{sentence}."))  # "Saved: PATH" is none
            except AssertionError as error:
                broken.append(str(error))
        return broken

    def saved(self, path: Path) -> None:
        """Save what is open, with a run of some steps."""
        for _ in range(_STEPS):
            self.window.session.step()
            self._rest("a step")
        self._save(path)

    def leave(self) -> None:
        """Close the window."""
        self.window.close()
        destroyed(self.window)

    def _use(self, saved: Path) -> None:
        """What a person does with a session that is open."""
        self.window.grab()
        self.window.session.step()
        self._rest("a step")
        self.window.grab()
        self.window.session.reset()
        self._rest("a reset")
        self._save(saved)
        load_session(saved)
        saved.unlink()

    def _save(self, path: Path) -> None:
        assert self.window.feature(OpenSaveFeature).document_file.save_at_once(path), f"not saved: {self._said[-1:]}"

    def _rest(self, what: str) -> None:
        await_true(lambda: settled(self.window), what, _PATIENCE)

    def _count_opened(self, _: Opened) -> None:
        self.opened += 1

    def _count_refused(self, _: NotOpened) -> None:
        self._refused += 1


def try_opening(budget: Budget, most: int | None = None, of: Sequence[str] = tuple(SAMPLES)) -> Report:
    """Open damaged sessions of images in turn until the time is over, or so many."""
    tried, read, failures = 0, 0, list[str]()
    folder = budget.folder / "sessions"
    folder.mkdir()
    write_images(folder)
    path = folder / SESSION
    sound: dict[str, bytes] = {}
    end = time.monotonic() + budget.seconds
    with surroundings(budget.folder), discarding(), Watch().kept() as watch:
        visitor = Visitor(folder / IMAGE)
        for image in of:
            path.write_text(json.dumps(SAMPLES[image](folder)))
            failures += [f"the sound session of {image}: {sentence}" for sentence in visitor.look_at(path)]
            visitor.saved(path)
            sound[image] = path.read_bytes()
        while going_on(end) and (most is None or tried < most):
            tried += 1
            path.write_bytes(damaged(sound[of[tried % len(of)]], Random(f"{budget.seed}/{tried}")))
            try:
                broken = visitor.look_at(path)
            except Exception as error:
                broken = [f"{type(error).__name__}: {error}"]
            broken += watch.troubles
            failures += [f"session {tried} of seed {budget.seed}: {sentence}" for sentence in broken]
            watch.troubles.clear()
            if broken or tried % _A_WINDOW == 0:
                read += visitor.opened
                visitor.leave()
                visitor = Visitor(folder / IMAGE)
        read += visitor.opened
        visitor.leave()
    return Report(tried, failures=tuple(failures), told=(f"{read:,} images and sessions were opened",))
