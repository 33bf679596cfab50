"""Memory of a window that is used for hours.

What is free is given back to the system, and only while the worker has nothing to do; runs that follow each other take
no more than the first few.
"""

from __future__ import annotations

import gc
import random
import sys
import weakref

import numpy as np
import pytest

from app.model.document.document import Document
from app.session.worker import worker_thread
from app.session.worker.recorded_run import Begun, RecordedRun, RunRecord
from app.session.worker.worker_thread import give_back
from app.views.theme.icons import icon
from cpm_core import Engine, Parameters
from cpm_core.image.regions import Regions
from cpm_core.model.starts import circle
from tests.faults.window.memory import allocated, resident


@pytest.mark.skipif(sys.platform != "linux", reason="other C libraries give memory back by themselves")
def test_gaps_between_arrays_that_stay_are_given_back() -> None:
    choice = random.Random(4)
    arrays = [np.ones(choice.randint(10, 6000)) for _ in range(4000)]
    made = sum(array.nbytes for array in arrays) / 2**20
    stay = arrays[::20]
    arrays.clear()
    before = resident()
    give_back()
    assert before - resident() > 0.5 * made
    assert len(stay) == 200


def test_the_worker_gives_back_once_while_it_rests_and_goes_on(session, image_file, qtbot, monkeypatch) -> None:
    given: list[bool] = []
    monkeypatch.setattr(worker_thread, "QUIET", 0.01)
    monkeypatch.setattr(worker_thread, "give_back", lambda: given.append(session._worker_thread._run.stepping))
    session.open(image_file)
    qtbot.waitUntil(lambda: session.document.image is not None and len(given) > 0)
    session.set_pace(None)
    qtbot.waitUntil(lambda: len(given) > 1)
    assert not any(given)


def test_runs_in_many_regions_hold_the_fields_of_a_few() -> None:
    """A method has the fields of the image in its regions; the timeline makes those of a former run again."""
    row, col = np.indices((48, 48))
    plain = Engine(np.where(np.hypot(row - 24, col - 24) < 12, 200.0, 20.0), Parameters(scales=1))
    recorded, made = RecordedRun(lambda _: plain), []
    for run in range(9):
        corner = 40.0 + 0.5 * run
        engine = plain.with_regions(Regions(interest=[[(2, 2), (2, corner), (corner, corner), (corner, 2)]]))
        begun = Begun(Document(parameters=Parameters(scales=1, beta=0.5 + 0.01 * run)))
        recorded.begin(engine, engine.start(circle((24.0, 24.0), 8.0)), RunRecord(), begun)
        made.append(weakref.ref(engine))
        del engine
        gc.collect()
    assert len(recorded.timeline.runs) == 1  # runs without a step are not kept
    assert sum(engine() is not None for engine in made) <= 3


def test_a_short_branch_takes_little_memory_for_its_figures() -> None:
    record = RunRecord()
    for step in range(1, 5001):
        record.record(step, {"epsilon": float(step)})
    assert record.until(3).rows.base.nbytes < 10_000
    assert list(record.until(4000).metrics().step) == list(range(1, 4001))


@pytest.mark.skipif(sys.platform != "linux", reason="measured by the C library of GNU")
def test_icons_take_no_more_than_their_pixels(qapp) -> None:
    icon("run", "#010203", faded="#040506")
    before = allocated()
    made = [icon("run", f"#0102{index:02x}", faded="#040506") for index in range(10, 30)]
    pixels = sum(4 * size.width() * size.height() for each in made for size in 2 * each.availableSizes())
    assert allocated() - before < 1.5 * pixels
