"""Which image of a project is next, and what goes from one image to another."""

from __future__ import annotations

from pathlib import Path

import pytest
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.project import find_next_undone, has_own_work, list_images_of, settings_of
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.formats import Project, ProjectImage, Reading
from cpm_core.image.region import Region
from cpm_core.objects.segmented import Click, ObjectClass, SegmentedObject, SegmentedObjects
from cpm_core.parameters import PRESETS
from cpm_core.shapes import Circle, Everywhere

STATES = st.sampled_from(["untouched", "begun", "done", "doubtful"])
IMAGE = ImageReference(
    "a.png", "/x/a.png", (32, 32), 1.0, "ab", reading=Reading(channel=2, spacing=(2.0, 2.0), unit="nm")
)
SQUARE = ((1.0, 1.0), (1.0, 5.0), (5.0, 5.0), (5.0, 1.0))


def rows_of(states):
    images = [Path(f"{place}.png") for place in range(len(states))]
    known = {path.name: ProjectImage(state) for path, state in zip(images, states, strict=True)}
    return list_images_of(images, Project(known), ())


@given(st.lists(STATES, min_size=1), st.data())
def test_the_next_undone_image_wraps_round_and_is_never_the_open_one(states, data) -> None:
    rows = rows_of(states)
    here = data.draw(st.integers(0, len(rows) - 1))
    undone = [row.path for row in rows if row.state in ("untouched", "begun") and row is not rows[here]]
    visited = find_next_undone(rows, rows[here].path)
    assert (visited is None) == (not undone)
    if undone:
        later = [path for path in undone if int(path.stem) > here]
        assert visited == (later or undone)[0]


@given(st.lists(STATES, min_size=1))
def test_going_on_and_marking_each_as_done_ends_after_every_image_once(states) -> None:
    states, current, visited = list(states), None, []
    while (path := find_next_undone(rows_of(states), current)) is not None:
        visited.append(path)
        states[int(path.stem)], current = "done", path
    assert len(set(visited)) == len(visited)
    assert "untouched" not in states and "begun" not in states


def test_an_image_with_a_session_that_the_project_does_not_know_has_been_begun() -> None:
    begun, untouched = list_images_of([Path("a.png"), Path("b.png")], Project(), {"a.png"})
    assert (begun.state, begun.objects) == ("begun", None)
    assert (untouched.state, untouched.objects) == ("untouched", 0)


def test_only_untouched_images_are_proposed() -> None:
    project = Project({"a.png": ProjectImage("done")}, proposes=True)
    assert [row.is_proposed for row in list_images_of([Path("a.png"), Path("b.png")], project, ())] == [False, True]


def test_settings_go_to_other_images_but_nothing_drawn_and_no_object_does() -> None:
    classes = (ObjectClass("nucleus", "#112233"), *SegmentedObjects().classes[1:])
    objects = SegmentedObjects((SegmentedObject(1, (), Region((SQUARE,))),), classes, 2)
    shapes = (Circle((9.0, 9.0), 3.0), Everywhere("grid"))
    document = Document(IMAGE, shapes, PRESETS["noisy"], mode="automatic", objects=objects)
    file = settings_of(document)
    assert file is not None
    assert (file.shapes, file.parameters, file.mode) == ((Everywhere("grid"),), PRESETS["noisy"], "automatic")
    assert (file.objects.items, file.objects.classes, file.objects.category) == ((), classes, 2)
    assert file.image is not None
    assert (file.image.reading, file.image.sha256) == (IMAGE.reading, "")


@pytest.mark.parametrize(
    "document",
    [Document(IMAGE, (Circle((9.0, 9.0), 3.0),)),
     Document(IMAGE, objects=SegmentedObjects((SegmentedObject(1, (), Region((SQUARE,))),))),
     Document(IMAGE, objects=SegmentedObjects(clicks=(Click(((1.0, 1.0),)),)))],
)  # fmt: skip
def test_what_was_drawn_clicked_or_accepted_is_work(document: Document) -> None:
    assert has_own_work(document)


def test_settings_are_no_work_on_an_image() -> None:
    assert not has_own_work(Document(IMAGE, (Everywhere("grid"),), PRESETS["noisy"], mode="automatic"))
