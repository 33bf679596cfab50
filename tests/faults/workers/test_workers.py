"""Work that fails is told in one sentence, and all other work goes on."""

import pytest

from cpm_core.cli import workers
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.parameters import Parameters

from ..kills.command_line import draw_images
from ..kills.nursery import outcome
from .command_line import Memory, Workers
from .window import trials


def test_the_window_says_which_work_has_failed_and_does_it_the_next_time(tmp_path, compiled_loops):
    draw_images(tmp_path)
    count, failures = outcome(tmp_path, trials, tmp_path, 0.0, 6, 0).value
    assert count == 6
    assert failures == []


def test_a_run_without_enough_memory_says_so_and_lives(tmp_path, compiled_loops):
    memory = Memory(tmp_path)
    assert [memory.trial(mebibytes) for mebibytes in (1.0, 15.0, 1000.0)] == [False, False, True]


def test_a_batch_outlives_its_workers(tmp_path, compiled_loops):
    Workers(tmp_path).trial(1, 0)


@pytest.mark.parametrize("error", [RuntimeError("a defect"), MemoryError(), KeyError("a")])
def test_an_error_that_nothing_expects_costs_one_image_of_a_batch(tmp_path, monkeypatch, error):
    draw_images(tmp_path)

    def fail(*_, **__):
        raise error

    monkeypatch.setattr(workers, "segment", fail)
    made = SessionFile(shapes=())
    done = workers.do(workers.Job(0, str(tmp_path / "0.npy"), made, Parameters(scales=1), 1, (".svg",)))
    assert done.error.endswith(".")
    assert "\n" not in done.error
