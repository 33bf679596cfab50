"""Memory that is free is given back to the system, and only while the worker has nothing to do."""

from __future__ import annotations

import random
import sys

import numpy as np
import pytest

from app.session.worker import worker_thread
from app.session.worker.free_memory import give_back
from tests.faults.window.memory import resident


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
