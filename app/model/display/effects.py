"""What values of parameters change, as numbers next to their sliders: from the state of a run and its contours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from app.model.display.lengths import measured
from app.model.document.document import ImageReference
from app.model.parameters.controls import RATIO
from app.model.text.language import tr, written
from cpm_core import Contour, Parameters, State
from cpm_core.contours import Measures
from cpm_core.segmentation import MethodState

FILTERS = {
    "min_strength": lambda row: row.strength,
    "min_length": lambda row: row.length,
    "min_contrast": lambda row: row.contrast,
}
"""Parameters under which contours are left out, and the measure that each of them is compared with."""

GAP = "max_gap"
"""The parameter up to which gaps are bridged."""


MOTION = ("beta", RATIO, "annealing")
"""Parameters of the motion of particles."""


def figures(state: State, parameters: Parameters, length: float) -> Mapping[str, float]:
    """What each parameter of `MOTION` acts on [px of the image]; `length` is that of all contours.

    Damping slows particles down: their mean motion in the last step. Repulsion spreads them: the length of the contours
    that they have found. Annealing ends insertion: the distance up to which two neighbors get a particle between them.
    """
    size = 2.0**state.scale
    widest = size * (parameters.d_min + state.annealed * parameters.d_max)
    return {"beta": size * state.displacement, RATIO: length, "annealing": widest}


def effects(
    state: MethodState | None, parameters: Parameters, length: float, image: ImageReference | None
) -> Mapping[str, str]:
    """`figures` in words, by the names of the parameters; empty ones where nothing is known."""
    words = dict.fromkeys(MOTION, "")
    if not isinstance(state, State) or not state.step or image is None:
        return words
    found = figures(state, parameters, length)
    speed = tr("{speed} px per step").format(speed=written(f"{found['beta']:.2f}"))
    words["beta"] = tr("at rest") if state.converged else speed
    if length:
        words[RATIO] = tr("{length} of contours").format(length=measured(length, image.spacing, image.unit, 0))
    words["annealing"] = tr("fills gaps up to {length} px").format(length=written(f"{found['annealing']:.1f}"))
    return words


class Distribution:
    """Values of the contours of one state of a run, with those that a threshold has left out since."""

    def __init__(self) -> None:
        self._moment: object = None
        self._threshold = 0.0
        self.values = np.zeros(0)
        """In ascending order."""

    def update(self, moment: object, threshold: float, values: Sequence[float]) -> None:
        """Take the values of the present contours.

        `moment` identifies the state that the contours were reconstructed from. While it stays the same, values that
        the threshold has excluded are remembered.
        """
        now = np.asarray(values, dtype=float)
        if moment is not None and moment == self._moment and self._threshold < threshold:
            # Values below the newest threshold may still be present: the contours follow a moment later.
            left_out = (self.values < threshold) & ~np.isin(self.values, now)
            now = np.concatenate([now, self.values[left_out]])
        else:
            self._moment, self._threshold = moment, threshold
        self.values = np.sort(now)

    def above(self, threshold: float) -> int:
        """Number of values that a threshold leaves."""
        return len(self.values) - int(np.searchsorted(self.values, threshold, side="left"))


class FilterCounts:
    """Numbers of contours that each filter leaves, and of gaps that can be bridged."""

    def __init__(self) -> None:
        self._filters = {name: Distribution() for name in FILTERS}
        self._ends = np.zeros((0, 2))
        self.present = 0
        """Number of contours that there are now."""

    def update(
        self, moment: object, thresholds: Mapping[str, float], contours: Sequence[Contour], rows: Sequence[Measures]
    ) -> None:
        """Take the present contours with their measures."""
        self.present = len(contours)
        for name, distribution in self._filters.items():
            values = [value for value in map(FILTERS[name], rows) if value is not None]
            distribution.update(moment, thresholds.get(name, 0.0), values)
        ends = [one.points[end] for one in contours for end in (0, -1) if not (one.closed or one.junctions[end])]
        self._ends = np.array(ends, dtype=float).reshape(-1, 2)

    def words(self, name: str, value: float, before: int | None) -> str:
        """What a value of a parameter leaves or bridges; `before` is the number before its slider was moved."""
        if not self.present and before is None:
            return ""
        if name == GAP:
            return tr("up to {count} gaps").format(count=self._gaps(value)) if value > 0.0 else ""
        distribution = self._filters.get(name)
        if distribution is None or not len(distribution.values):
            return ""
        left = distribution.above(value)
        if before is None:
            return tr("1 contour") if left == 1 else tr("{count} contours").format(count=left)
        return tr("{before} → {after} contours").format(before=before, after=left)

    def _gaps(self, widest: float) -> int:
        """Number of loose ends, in pairs, that have another one within a distance [px]."""
        if len(self._ends) < 2:
            return 0
        pairs = scipy.spatial.cKDTree(self._ends).query_pairs(widest, output_type="ndarray")
        return (len(np.unique(pairs)) + 1) // 2
