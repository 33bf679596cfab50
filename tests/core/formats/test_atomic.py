"""Files are replaced as a whole: with their rights, through no fault of others, and never where they must stay."""

import os
import signal
import stat
import time
from pathlib import Path

import pytest

from cpm_core.formats.common.atomic import check_writable, draft_files, write_together

posix = pytest.mark.skipif(os.name != "posix", reason="rights and signals are those of POSIX")


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def write_draft(path, content=b"new"):
    with draft_files(path) as (draft,):
        draft.write_bytes(content)


def write_bytes(path, content=b"new"):
    write_together([(path, content)])


WAYS = pytest.mark.parametrize("write", [write_bytes, write_draft])


@posix
@WAYS
@pytest.mark.parametrize("rights", [0o600, 0o640, 0o664])
def test_a_file_that_is_replaced_keeps_its_rights(tmp_path, write, rights):
    path = tmp_path / "a.svg"
    path.write_bytes(b"old")
    path.chmod(rights)
    write(path)
    assert path.read_bytes() == b"new"
    assert stat.S_IMODE(path.stat().st_mode) == rights


@posix
@WAYS
def test_a_new_file_has_the_rights_that_all_new_files_have(tmp_path, write):
    (tmp_path / "other").touch()
    write(tmp_path / "a.svg")
    assert (tmp_path / "a.svg").stat().st_mode == (tmp_path / "other").stat().st_mode


@posix
@WAYS
def test_a_file_that_is_read_only_is_not_replaced(tmp_path, write):
    path = tmp_path / "a.svg"
    path.write_bytes(b"old")
    path.chmod(0o444)
    for call in (write, check_writable):
        with pytest.raises(ValueError, match=r"a\.svg in .* is read-only and is not replaced"):
            call(path)
    assert path.read_bytes() == b"old"
    assert names_in(tmp_path) == ["a.svg"]


@posix
@WAYS
def test_a_device_or_a_pipe_is_not_replaced(tmp_path, write):
    os.mkfifo(tmp_path / "pipe.svg")
    (tmp_path / "link.svg").symlink_to("/dev/null")
    for name in ("pipe.svg", "link.svg"):
        for call in (write, check_writable):
            with pytest.raises(ValueError, match="is not an ordinary file and is not replaced"):
                call(tmp_path / name)
    assert stat.S_ISFIFO((tmp_path / "pipe.svg").stat().st_mode)
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


@posix
@WAYS
@pytest.mark.parametrize(
    "name", ["x" * 251 + ".svg", "ä" * 125 + ".svg", "a\nb\x1b[31m.svg", os.fsdecode(b"\xff\xfe.svg")]
)
def test_any_name_that_a_file_can_have_can_be_written(tmp_path, write, name):
    write(tmp_path / name)
    assert names_in(tmp_path) == [name]


def left_behind(path):
    """A draft as a writer of `path` leaves it that is killed."""
    with draft_files(path) as (draft,):
        draft.touch()
    path.unlink()
    draft.touch()
    return draft


@WAYS
def test_drafts_of_killed_writers_are_removed_and_those_of_others_stay(tmp_path, write):
    path = tmp_path / "a.svg"
    abandoned, at_work, of_another = (left_behind(other) for other in (path, path, tmp_path / "b.svg"))
    long_ago = time.time() - 3600.0
    for draft in (abandoned, of_another):
        os.utime(draft, (long_ago, long_ago))
    write(path)
    assert set(tmp_path.iterdir()) == {path, at_work, of_another}


def test_a_move_that_fails_after_others_tells_how_many_were_written(tmp_path, monkeypatch):
    replace = Path.replace

    def failing(self, target):
        if target.name == "c.svg":
            raise OSError(5, "Input/output error")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", failing)
    files = [(tmp_path / f"{name}.svg", b"new") for name in "abcd"]
    said = r"c\.svg in .* cannot be written: Input/output error\. 2 of 4 files were written"
    with pytest.raises(ValueError, match=said):
        write_together(files)
    assert names_in(tmp_path) == ["a.svg", "b.svg"]


@WAYS
@pytest.mark.parametrize("content", [b"new", b"n" * 10**6])
def test_all_of_the_content_is_on_the_disk_before_it_replaces_the_old(tmp_path, monkeypatch, write, content):
    brought, fsync, target = [], os.fsync, tmp_path / "a.svg"
    target.write_bytes(b"old")

    def seen(descriptor):
        brought.append((os.fstat(descriptor).st_size, target.read_bytes()))
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", seen)
    write(target, content)
    assert brought == [(len(content), b"old")]
    assert target.read_bytes() == content


def test_the_handler_of_interrupts_stays_as_it_was(tmp_path):
    before = signal.getsignal(signal.SIGINT)
    write_bytes(tmp_path / "a.svg")
    assert signal.getsignal(signal.SIGINT) is before
