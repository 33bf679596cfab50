"""What a project says of the images of a folder is what is read again; nothing of others is lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.formats import (
    PROJECT_FOLDER,
    ImageFile,
    Project,
    ProjectImage,
    Reading,
    SessionFile,
    load_project,
    project_session,
    update_project,
)
from cpm_core.formats.sessions.project_file import PROJECT_FILE
from cpm_core.formats.sessions.session_file import find_session_image, load_session, save_session
from cpm_core.parameters import PRESETS
from cpm_core.shapes import Everywhere

IMAGES = st.builds(ProjectImage, st.sampled_from(["untouched", "begun", "done", "doubtful"]), st.integers(0, 10**6))
SETTINGS = SessionFile(
    ImageFile("a.png", reading=Reading(spacing=(0.5, 0.5), unit="µm")),
    (Everywhere("grid"),),
    PRESETS["noisy"],
    mode="automatic",
)


def project_file(folder: Path) -> Path:
    return folder / PROJECT_FOLDER / PROJECT_FILE


@given(st.dictionaries(st.text(min_size=1), IMAGES), st.sampled_from([None, SETTINGS]), st.booleans())
def test_what_is_written_is_what_is_read(tmp_path_factory, images, settings, proposes) -> None:
    folder = tmp_path_factory.mktemp("images")
    update_project(folder, lambda _: Project(images, settings, proposes))
    found = load_project(folder)
    assert (found.images, found.settings, found.proposes) == (images, settings, proposes)


def test_a_folder_without_a_project_has_an_empty_one_and_reading_creates_nothing(tmp_path: Path) -> None:
    assert load_project(tmp_path) == Project()
    assert not list(tmp_path.iterdir())


def test_what_two_windows_write_about_different_images_is_kept(tmp_path: Path) -> None:
    for name, image in (("a.png", ProjectImage("done", 3)), ("b.png", ProjectImage("doubtful", 1))):
        update_project(tmp_path, lambda project, name=name, image=image: project.with_image(name, image))
    assert load_project(tmp_path).images == {"a.png": ProjectImage("done", 3), "b.png": ProjectImage("doubtful", 1)}


@pytest.mark.parametrize(
    "content",
    [b"{", b"[]", b"\xff", b"{}", b'{"cpm-project": 2}', b'{"cpm-project": 1, "images": {"a": {"state": "lost"}}}',
     b'{"cpm-project": 1, "images": {"a": {"objects": "many"}}}', b'{"cpm-project": 1, "settings": 3}'],
)  # fmt: skip
def test_a_damaged_file_is_reported_in_one_sentence_and_stays_as_it_is(tmp_path: Path, content: bytes) -> None:
    project_file(tmp_path).parent.mkdir()
    project_file(tmp_path).write_bytes(content)
    with pytest.raises(ValueError, match=r"cpm/project\.json .*left as it is") as caught:
        load_project(tmp_path)
    assert "\n" not in str(caught.value)
    with pytest.raises(ValueError, match="left as it is"):
        update_project(tmp_path, lambda project: project)
    assert project_file(tmp_path).read_bytes() == content


def test_where_nothing_can_be_written_one_sentence_says_so(tmp_path: Path) -> None:
    (tmp_path / PROJECT_FOLDER).write_text("a file of this name")
    with pytest.raises(ValueError, match="work on these images is not saved"):
        update_project(tmp_path, lambda project: project.with_image("a.png", ProjectImage("done")))


def test_states_survive_the_end_of_the_program_at_any_moment(tmp_path: Path) -> None:
    endless = (
        "import sys; from pathlib import Path; from cpm_core.formats import ProjectImage, update_project\n"
        "for n in range(10**9):\n"
        "    update_project(Path(sys.argv[1]), lambda p: p.with_image(f'{n}.png', ProjectImage('done', n)))\n"
        "    print(n, flush=True)\n"
    )
    with subprocess.Popen([sys.executable, "-c", endless, str(tmp_path)], stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        written = -1
        while written < 5:
            written = int(writer.stdout.readline())
        writer.send_signal(signal.SIGKILL if os.name == "posix" else signal.SIGTERM)
    known = load_project(tmp_path).images
    assert all(known[f"{n}.png"] == ProjectImage("done", n) for n in range(written + 1))


def test_images_that_differ_in_their_suffix_only_have_sessions_of_their_own(tmp_path: Path) -> None:
    assert project_session(tmp_path / "a.png") != project_session(tmp_path / "a.tif")


def test_sessions_find_their_images_after_the_folder_has_been_moved(tmp_path: Path) -> None:
    before, after = tmp_path / "before", tmp_path / "after"
    (before / PROJECT_FOLDER).mkdir(parents=True)
    image = before / "a.png"
    image.write_bytes(b"-")
    save_session(SessionFile(ImageFile(str(image))), project_session(image))
    before.rename(after)
    session = project_session(after / "a.png")
    file = load_session(session).image
    assert file is not None
    assert find_session_image(file, session.parent)[0] == after / "a.png"
