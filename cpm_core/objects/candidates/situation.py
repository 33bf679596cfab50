"""What is known when a click comes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.candidates.appearance import Appearance
from cpm_core.objects.candidates.boundary import prices
from cpm_core.objects.candidates.clicks import Clicked
from cpm_core.objects.candidates.grids import Box, box_of

_FIRST_SHARE, _NEXT_SHARE = 0.7, 0.4
"""Largest share of the image that an object has after a first click, and that a further one changes."""

_GROWTH, _ALWAYS = 4, 2000
"""A further click changes at most so many times the area of the object, or so many pixels if that is more."""


@dataclass(frozen=True, eq=False)
class Situation:
    """What is known when a click comes.

    Attributes
    ----------
    look : Appearance
        The image.
    clicked : Clicked
        The pixels and faces of all clicks, this one among them.
    strong : float
        Edge strength that counts as strong.
    pixel : ndarray of int64, shape (2,)
        The pixel of this one.
    adding : bool
        Whether it is inside.
    chosen : ndarray of bool, shape (H, W), or None
        The object chosen so far; None for the first click.
    """

    look: Appearance
    clicked: Clicked
    strong: float
    pixel: Index
    adding: bool
    chosen: Mask | None

    @property
    def inside(self) -> Index:
        """Pixels said to be inside, shape (M, 2)."""
        return self.clicked.within

    @property
    def outside(self) -> Index:
        """Pixels said to be outside, shape (K, 2)."""
        return self.clicked.beyond

    @cached_property
    def area(self) -> int:
        """Pixels of the object chosen so far."""
        return 0 if self.chosen is None else int(np.count_nonzero(self.chosen))

    @cached_property
    def box(self) -> Box:
        """Box of the object chosen so far."""
        assert self.chosen is not None
        return box_of(self.chosen)

    @cached_property
    def allowed(self) -> Mask:
        """Pixels that may change, shape (H, W)."""
        faces = self.clicked.faces.labels
        if self.chosen is None:
            allowed = faces >= 0
        else:
            allowed = (faces >= 0) & ~self.chosen if self.adding else self.chosen.copy()
        kept = self.outside if self.adding else self.inside
        allowed[kept[:, 0], kept[:, 1]] = False
        return allowed

    @property
    def limit(self) -> int:
        """Pixels that change at most."""
        size = self.look.level.size
        if self.chosen is None:
            return int(_FIRST_SHARE * size)
        return min(int(_NEXT_SHARE * size), max(_GROWTH * self.area, _ALWAYS))

    @cached_property
    def price(self) -> Array:
        """Price of the border of each pair of faces, shape (E,)."""
        return prices(self.clicked.faces.graph, self.strong)
