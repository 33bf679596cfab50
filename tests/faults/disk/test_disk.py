"""On a disk that fails, one sentence says so, nothing is lost or half-written, and the program goes on."""

import random
from functools import partial

import pytest

from cpm_core.formats.common.atomic import check_place, draft_of, write_together
from cpm_core.formats.sessions.session_file import SessionFile, save_session

from ..kills.command_line import draw_images
from ..kills.nursery import outcome
from .core import Disk
from .window import trials


@pytest.mark.parametrize("kind", ["save", "load", "film"])
def test_any_operation_on_files_may_fail(tmp_path, kind):
    disk = Disk(tmp_path, kind)
    for trial in disk.trials():
        disk.trial(*trial)


@pytest.mark.parametrize("kind", ["run", "batch"])
def test_some_operations_of_a_command_may_fail(tmp_path, compiled_loops, kind):
    disk = Disk(tmp_path, kind)
    for trial in random.Random(0).sample(disk.trials(), 4):
        disk.trial(*trial)


def test_no_file_is_half_written_on_a_disk_that_is_nearly_full(tmp_path, compiled_loops):
    Disk(tmp_path, "run").limited(1500)


def test_the_window_keeps_its_work_until_the_disk_is_well_again(tmp_path, compiled_loops):
    draw_images(tmp_path)
    count, failures = outcome(tmp_path, trials, tmp_path, 60.0, 20, 0).value
    assert count > 5
    assert failures == []


def draft(path):
    with draft_of(path) as made:
        made.write_bytes(b"new")


WRITERS = [lambda path: write_together([(path, b"new")]), draft, partial(save_session, SessionFile())]


@pytest.mark.parametrize("write", WRITERS)
def test_links_in_a_circle_are_refused_in_a_sentence(tmp_path, write):
    path = tmp_path / "a.cpm"
    path.symlink_to("b.cpm")
    (tmp_path / "b.cpm").symlink_to("a.cpm")
    for call in (write, check_place):
        with pytest.raises(ValueError, match=r"a\.cpm cannot be written: .*\.$"):
            call(path)
    assert path.is_symlink()


@pytest.mark.parametrize("write", WRITERS)
def test_a_link_to_nothing_leads_to_a_new_file(tmp_path, write):
    (tmp_path / "a.cpm").symlink_to("b.cpm")
    write(tmp_path / "a.cpm")
    assert (tmp_path / "a.cpm").is_symlink()
    assert (tmp_path / "b.cpm").stat().st_size > 0


@pytest.mark.parametrize("write", WRITERS)
def test_a_folder_that_has_gone_is_told_in_a_sentence(tmp_path, write):
    with pytest.raises(ValueError, match=r"gone/a\.cpm cannot be written: .*\.$"):
        write(tmp_path / "gone" / "a.cpm")
