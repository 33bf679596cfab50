"""``cpm run STACK --pages``: all pages from the command line."""

import json

import numpy as np
import pytest
import tifffile

import cpm_core as cpm
from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.pages import follow as following
from cpm_core.shapes import Circle

from .drawn import MOVING, SHAPE


@pytest.fixture(scope="module")
def stack(tmp_path_factory):
    """Five pages, the third of which is constant."""
    path = tmp_path_factory.mktemp("stack") / "cells.tif"
    pages = np.array([*MOVING[:2], np.full(SHAPE, 7.0), *MOVING[2:4]]).astype(np.uint8)
    tifffile.imwrite(path, pages, imagej=True, metadata={"axes": "TYX", "unit": "um"}, resolution=(2.0, 2.0))
    return path


FOLLOWED = ("--pages", "all", "--follow", "--circle", "32,22,5")


def test_all_pages_are_followed_and_a_bad_one_is_told(stack, command, tmp_path):
    status, out, err = command("run", stack, *FOLLOWED, "--export", tmp_path / "a.tif", tmp_path / "a.json")
    assert status == 1
    assert err.splitlines() == ["cpm: page 3: cells.tif is constant (7 everywhere) and has no edges: "
                                "open an image with objects."]  # fmt: skip
    assert "cells.tif: 5 pages, 1 track" in out
    assert "1 failed" in out
    labels = tifffile.imread(tmp_path / "a.tif")
    assert [page.max() for page in labels] == [1, 1, 0, 1, 1]


def test_the_command_finds_what_the_library_finds_to_the_bit(stack, command, tmp_path):
    command("run", stack, *FOLLOWED, "--export", tmp_path / "a.json")
    pages = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["pages"]
    found = list(cpm.follow(cpm.load_pages(stack), cpm.circle((32, 22), 5.0)))
    told = [[one["points"] for one in page.get("contours", [])] for page in pages]
    assert told == [[one.points.tolist() for one in page.contours] for page in found]
    assert found[0].result.unit == "µm"


def test_a_file_that_cannot_hold_what_is_found_does_not_lose_the_others(stack, command, tmp_path):
    edge = ("--pages", "1", "--circle", "32,22,5", "--min-length", "10000", "--export")
    status, out, err = command("run", stack, *edge, tmp_path / "a.tif", tmp_path / "a.csv")
    assert status == 1
    assert err.startswith(f"cpm: {tmp_path / 'a.csv'} was written, but {tmp_path / 'a.tif'} was not written: ")
    assert out.splitlines()[-1] == f"Wrote {tmp_path / 'a.csv'}"
    assert command("run", stack, *edge, tmp_path / "b.tif")[0] == 2
    assert not (tmp_path / "b.tif").exists()


def test_json_is_one_object(stack, command):
    status, out, _ = command("run", stack, "--pages", "2,5-4", "--circle", "32,40,9", "--json")
    facts = json.loads(out)
    assert status == 0
    assert [page["page"] for page in facts["pages"]] == [2, 5, 4]
    assert (facts["done"], facts["failed"]) == (3, 0)
    assert facts["pages"][0]["contours"] == 1


def test_an_interrupt_keeps_what_is_done_and_resume_does_the_others_to_the_bit(stack, command, tmp_path, monkeypatch):
    files = [tmp_path / "a.json", tmp_path / "a.measures.csv"]
    command("run", stack, *FOLLOWED, "--export", *files)
    whole = [file.read_bytes() for file in files]
    runs, real = [], following.segment

    def interrupted(*arguments, **named):
        runs.append(arguments)
        if len(runs) == 4:
            raise KeyboardInterrupt
        return real(*arguments, **named)

    with monkeypatch.context() as patch:
        patch.setattr(following, "segment", interrupted)
        status, _, err = command("run", stack, *FOLLOWED, "--export", *files)
    assert status == 130
    assert "interrupted; 3 of 5 pages were done, and the files hold them; the same command with --resume" in err
    assert len(json.loads(files[0].read_text(encoding="utf-8"))["pages"]) == 3
    with monkeypatch.context() as patch:
        patch.setattr(following, "segment", lambda *args, **named: runs.append(args) or real(*args, **named))
        status, _, err = command("run", stack, *FOLLOWED, "--resume", "--export", *files)
    assert "3 pages done before" in err
    assert len(runs) == 4 + 2
    assert [file.read_bytes() for file in files] == whole


def test_resume_refuses_what_was_made_otherwise(stack, command, tmp_path):
    command("run", stack, "--pages", "1", "--circle", "32,22,5", "--export", tmp_path / "a.json")
    before = (tmp_path / "a.json").read_bytes()
    status, _, err = command("run", stack, *FOLLOWED, "--beta", "0.7", "--resume", "--export", tmp_path / "a.json")
    assert status == 2
    assert "was made of another stack, or with other parameters: leave --resume out" in err
    assert (tmp_path / "a.json").read_bytes() == before


def test_resume_without_a_file_begins(stack, command, tmp_path):
    status, _, err = command("run", stack, "--pages", "1", "--circle", "32,22,5", "--resume", "--export",
                             tmp_path / "a.json")  # fmt: skip
    assert status == 0
    assert "does not exist yet: all pages are run" in err


def test_a_session_gives_start_and_parameters(stack, command, tmp_path):
    save_session(SessionFile(shapes=(Circle((32.0, 22.0), 5.0),)), tmp_path / "a.cpm")
    given = ("run", stack, "--pages", "all", "--follow", "--session", tmp_path / "a.cpm")
    command(*given, "--export", tmp_path / "a.csv")
    command("run", stack, *FOLLOWED, "--export", tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--pages", "0"), "--pages names page 0, but cells.tif has 5 pages"),
        (("--pages", "2-9"), "--pages names page 9"),
        (("--pages", "1,2,1"), "names a page twice"),
        (("--pages", "first"), "but must be all, or numbers and ranges such as 1,3,5-9"),
        (("--pages", "all", "--page", "2"), "--page is for one image, but --pages runs several"),
        (("--pages", "all", "--close"), "--close is for one image"),
        (("--pages", "all", "--export", "a.svg"), "a.svg names no format for all pages of a stack"),
        (("--pages", "all", "--resume"), "--resume needs the .json file"),
        (("--follow",), "--follow is for the pages of a stack: add --pages all"),
        (("--pages", "3"), "No page of cells.tif could be used. Page 3: cells.tif is constant"),
    ],
)
def test_what_does_not_fit_is_one_sentence_and_nothing_is_written(
    stack, command, arguments, sentence, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    status, out, err = command("run", stack, "--circle", "32,22,5", *arguments)
    assert status == 2
    assert sentence in err
    assert out == ""
    assert list(tmp_path.iterdir()) == []


def test_the_stack_itself_is_not_overwritten(stack, command):
    before = stack.read_bytes()
    status, _, err = command("run", stack, *FOLLOWED, "--export", stack)
    assert status == 2
    assert "would overwrite the stack itself" in err
    assert stack.read_bytes() == before
