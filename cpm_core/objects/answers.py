"""Answers that a partition has given: a further click continues from the answer to those before it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.selection import Selection

_MOST = 64


@dataclass(eq=False)
class Answers:
    """The last answers, the newest at the end."""

    given: list[Selection] = field(default_factory=list)

    def remember(self, selection: Selection) -> None:
        """Add an answer; the oldest one is forgotten."""
        self.given = [*self.given[1 - _MOST :], selection]

    def nearest(self, inside: Array, outside: Array) -> Selection | None:
        """The newest of the answers to most of these places, none of which was given for others."""
        best: Selection | None = None
        for answer in self.given:
            fits = among(answer.inside, inside).all() and among(answer.outside, outside).all()
            count = len(answer.inside) + len(answer.outside)
            if fits and answer.mask.any() and (best is None or count >= len(best.inside) + len(best.outside)):
                best = answer
        return best


def among(places: Array, others: Array) -> Mask:
    """Which places, shape (N, 2), are among others."""
    return np.asarray((places[:, None] == others[None]).all(axis=2).any(axis=1))
