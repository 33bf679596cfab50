"""Fingerprints: what changes in a file changes its hash, and no file takes minutes."""

import hashlib
import os
import shutil

import pytest

import cpm_core.formats.common.content as module
from cpm_core.formats.common.content import compute_fingerprint
from cpm_core.formats.sessions.session_file import (
    ImageFile,
    SessionFile,
    find_session_image,
    load_session,
    save_session,
)

LARGEST = 2**30


def sparse(path, size):
    """A file that takes no room on the disk."""
    path.touch()
    os.truncate(path, size)
    return path


def write_at(path, place, content):
    with path.open("r+b") as stream:
        stream.seek(place)
        stream.write(content)


@pytest.mark.parametrize("size", [0, 1, 2**20, 2**20 + 1, 5 * 2**20])
def test_the_hash_of_a_file_is_that_of_all_its_bytes(tmp_path, size):
    content = os.urandom(size)
    (tmp_path / "a").write_bytes(content)
    assert compute_fingerprint(tmp_path / "a") == hashlib.sha256(content).hexdigest()


@pytest.mark.parametrize("place", ["first", "middle", "last"])
def test_a_large_file_is_known_again_and_its_changes_are_seen(tmp_path, monkeypatch, place):
    monkeypatch.setattr(module, "_LARGEST_HASHED_WHOLE", 2**20)
    path = tmp_path / "a"
    path.write_bytes(os.urandom(3 * 2**20 + 5))
    before = compute_fingerprint(path)
    assert before.startswith("sampled:")
    shutil.move(path, tmp_path / "b")
    assert compute_fingerprint(tmp_path / "b") == before
    size = (tmp_path / "b").stat().st_size
    write_at(tmp_path / "b", {"first": 0, "middle": size // 2, "last": size - 9}[place], b"other one")
    assert before != compute_fingerprint(tmp_path / "b")


def test_a_large_file_of_the_same_parts_but_another_length_has_changed(tmp_path):
    one, other = (compute_fingerprint(sparse(tmp_path / "a", size)) for size in (2 * LARGEST, 3 * LARGEST))
    assert one != other


def test_a_session_recognizes_its_large_image_by_its_hash(tmp_path):
    image = sparse(tmp_path / "huge.npy", 2 * LARGEST)
    known = compute_fingerprint(image)
    save_session(SessionFile(ImageFile(str(image), known, (10, 20))), tmp_path / "a.cpm")
    reference = load_session(tmp_path / "a.cpm").image
    assert reference.sha256 == known
    assert find_session_image(reference, tmp_path) == (image, ())
    write_at(image, 0, b"changed")
    _, (note,) = find_session_image(load_session(tmp_path / "a.cpm").image, tmp_path)
    assert "has changed since" in note
