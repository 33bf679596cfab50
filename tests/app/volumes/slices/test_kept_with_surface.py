"""What is worked out of a surface is kept while it lasts, and goes with it: those of former volumes take memory."""

from __future__ import annotations

import gc
import weakref

import pytest

import cpm_core as cpm
from app.model.display import differences as surfaces
from app.model.volume import object_sections, shape_sections
from app.model.volume.slices import Slice
from app.model.volume.surface_section import kept_with_surface
from app.views.volume import seen_in_space
from cpm_core.contours.surface import Surface


def ball() -> Surface:
    volume = cpm.example("ball")
    return cpm.VolumeTruth(volume.values > volume.values.mean()).surface


@pytest.mark.parametrize(
    ("make", "choice"),
    [
        (object_sections._closed, Slice(0, 15)),
        (shape_sections._cut, Slice(1, 15)),
        (surfaces._lines, Slice(2, 15)),
        (seen_in_space._mesh_of, (2.0, 1.0, 1.0)),
        (seen_in_space._mesh_of, (1.0, 1.0, 1.0)),
    ],
)
def test_a_surface_goes_when_nothing_else_needs_it(make, choice) -> None:
    surface = ball()
    made = make(surface, choice)
    assert made
    assert make(surface, choice) is made
    seen = weakref.ref(surface)
    del surface
    gc.collect()
    assert seen() is None
    assert made


def test_only_the_latest_choices_are_kept() -> None:
    asked: list[int] = []

    @kept_with_surface
    def twice(surface: Surface, number: int) -> int:
        asked.append(number)
        return 2 * number

    surface = ball()
    numbers = [0, *range(8), 0, 8, 0, 1]
    assert [twice(surface, number) for number in numbers] == [2 * number for number in numbers]
    assert asked == [0, 1, 2, 3, 4, 5, 6, 7, 8, 1]
