"""What a filter of contours leaves, counted from the measures at hand while its slider moves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
import scipy

from app.model.text.language import tr
from cpm_core import Contour
from cpm_core.contours import Measures
from cpm_core.numerics import Array

FILTERS: Mapping[str, Callable[[Measures], float | None]] = MappingProxyType(
    {
        "min_strength": lambda row: row.strength,
        "min_length": lambda row: row.length,
        "min_contrast": lambda row: row.contrast,
    }
)
"""Parameters under which contours are left out, and the measure that each of them is compared with."""

GAP = "max_gap"
"""The parameter up to which gaps are bridged."""


class Distribution:
    """Values of the contours of one state of a run, with those that a threshold has left out since."""

    def __init__(self) -> None:
        self._moment: object = None
        self._threshold = 0.0
        self.values: Array = np.zeros(0)
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
        self._ends: Array = np.zeros((0, 2))
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
