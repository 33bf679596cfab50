"""The object that the charged particles propose for a start, as one of the methods that are compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.surface import Surface
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.objects.methods.charged_particles import MOST_STEPS, evolve_particles
from cpm_core.objects.methods.method import SPACING, ContourMethod, ContourState, Start
from cpm_core.objects.partition import partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.evolve import Evolved


@dataclass(frozen=True, eq=False)
class ProposedObject:
    """A moment of a run of the particles: in place of their contours the objects that these propose for the start."""

    moment: Evolved
    start: Start

    @property
    def step(self) -> int:
        """Number of steps so far."""
        return self.moment.step

    @property
    def stop_reason(self) -> str:
        """Why the run ended, in words; empty while it continues."""
        return self.moment.stop_reason

    @property
    def converged(self) -> bool:
        """Whether the particles came to rest."""
        return self.moment.converged

    @property
    def points(self) -> Array:
        """The particles, shape (N, 2) [px]."""
        return self.moment.points

    @property
    def surface(self) -> Surface | None:
        """No surface."""
        return None

    @cached_property
    def contours(self) -> tuple[Contour, ...]:
        """The closed boundaries of what each outline of the start proposes, joined where these overlap."""
        cut = partition(self.moment.result)
        chosen = [cut.select(outline) for outline in self.start.curves(SPACING)]
        whole = chosen[0] if len(chosen) == 1 else cut.selection_of(np.any([one.mask for one in chosen], axis=0))
        found: tuple[Contour, ...] = whole.contours
        return found


def _evolve(image: Image, start: Start, parameters: Parameters) -> Iterator[ContourState]:
    for moment in evolve_particles(image, start, parameters):
        state = ProposedObject(moment, start)
        if state.stop_reason:
            _ = state.contours  # so that the time of the run includes theirs
        yield state


PROPOSED_OBJECT = ContourMethod(
    "object",
    "Object of the particles",
    "The object that the contours of the charged particles propose for the start: its boundary is closed, along the "
    "contours and across their gaps.",
    "Objects of this program, on the particles of Jalba, Wilkinson and Roerdink (2004)",
    Parameters,
    _evolve,
    MOST_STEPS,
    preset=PRESETS["shape"],
)
