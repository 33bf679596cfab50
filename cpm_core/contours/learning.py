"""Learning which contours count from those that a person has kept and rejected.

A Gaussian process classifier (Rasmussen and Williams 2006, chapter 3) on the features of contours. Its latent function
has the mean `_PRIOR`, that a contour counts, and the covariance of a linear and of a local part; with few examples it
stays near the mean, and contours that resemble none of the examples stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from cpm_core.contours.contour import Contour
from cpm_core.contours.features import FEATURES, contour_features, usable
from cpm_core.contours.result import Result, remaining
from cpm_core.numerics.types import Array, Mask
from cpm_core.parameters.quotation import shown

_PRIOR = 1.0
"""Mean of the log-odds that a contour counts, before any example."""

_CONSTANT, _LINEAR, _LOCAL = 1.0, 3.0, 3.0
"""Variance of the latent function: of its constant, of its linear part, and of the part that differs locally. The
answers depend little on them: half or twice as much changes F of photographs with ten verdicts by 1 %."""

_LEAST = 0.5
"""Probability under which a contour is left out."""

_MOST_EXAMPLES = 400
"""Examples that count, the newest ones; more of them would no longer answer at once."""

_NEWTON_STEPS, _TOLERANCE = 40, 1e-8


@dataclass(frozen=True, eq=False)
class Examples:
    """Contours that a person has judged.

    Attributes
    ----------
    features : ndarray, shape (M, F)
        Their features, see `contour_features`; the newest last.
    kept : ndarray of bool, shape (M,)
        Whether each was kept; the others were rejected.
    """

    features: Array
    kept: Mask

    @staticmethod
    def of(rows: Sequence[Sequence[float]], kept: Sequence[bool]) -> Examples:
        """Examples from rows of features; those that are not as many as `FEATURES`, or not finite, are left out."""
        good = [index for index, row in enumerate(rows) if len(row) == len(FEATURES) and np.isfinite(row).all()]
        features = np.array([rows[index] for index in good], dtype=float).reshape(len(good), len(FEATURES))
        return Examples(features, np.array([kept[index] for index in good], dtype=np.bool_))

    def __len__(self) -> int:
        return len(self.kept)

    def __add__(self, newer: Examples) -> Examples:
        return Examples(np.concatenate([self.features, newer.features]), np.concatenate([self.kept, newer.kept]))


def probabilities(examples: Examples, features: Array) -> Array:
    """Probability that a person would keep contours.

    Parameters
    ----------
    examples : Examples
        What has been kept and rejected, in this image or in others.
    features : ndarray, shape (N, F)
        Features of the contours.

    Returns
    -------
    ndarray, shape (N,)
        Between 0 and 1: the logistic function of the mode of the posterior, by Laplace's method. It is the prior one
        without examples; NaN for contours that were not found in an image.
    """
    known = usable(features)
    out = np.full(len(features), np.nan)
    latent = np.full(int(known.sum()), _PRIOR)
    if len(examples):
        given, kept = examples.features[-_MOST_EXAMPLES:], examples.kept[-_MOST_EXAMPLES:]
        # verdicts of one kind alone say nothing about how many contours count
        constant = _CONSTANT if kept.any() and not kept.all() else 0.0
        latent += _covariance(features[known], given, constant) @ _pull(_covariance(given, given, constant), kept)
    out[known] = scipy.special.expit(latent)
    return out


def teach(
    result: Result, kept: Sequence[int] = (), rejected: Sequence[int] = (), examples: Examples | None = None
) -> Result:
    """Leave out the contours of a result that resemble rejected ones more than kept ones.

    Parameters
    ----------
    result : Result
        Outcome of a run.
    kept, rejected : sequence of int
        Indices of contours that a person has judged. Kept ones stay and rejected ones are left out, whatever the
        others look like.
    examples : Examples, optional
        Contours judged before, also in other images.

    Returns
    -------
    Result
        The same one when nothing has been judged. Contours that were not found in an image, such as drawn ones, stay.

    Raises
    ------
    ValueError
        When an index is not that of a contour, or is both kept and rejected.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ring"), cpm.uniform_grid((64, 64)))
    >>> cpm.teach(result, kept=[0])
    <Result ring, 2 contours (2 closed), 136 particles, at rest after 111 steps>
    """
    judged = _checked(len(result.contours), kept, rejected)
    earlier = examples if examples is not None else Examples.of((), ())
    if not judged and not len(earlier):
        return result
    features = contour_features(result.contours)
    known = {index: right for index, right in judged.items() if usable(features[index][None])[0]}
    learned = earlier + Examples.of([tuple(features[index]) for index in known], list(known.values()))
    stays = ~left_out(probabilities(learned, features))
    for index, right in judged.items():
        stays[index] = right
    return remaining(result, stays.tolist())


def left_out(probability: Array) -> Mask:
    """Which contours are left out, by the probabilities that they count; never those of which none is known."""
    return np.asarray(probability < _LEAST)


def most_doubtful(contours: Sequence[Contour], probability: Array, judged: Sequence[int]) -> int | None:
    """Index of the contour whose verdict would teach most: long and undecided; None when all are judged.

    The length of the contour times the probability of the less probable verdict.
    """
    doubt = np.minimum(probability, 1.0 - probability) * [contour.length for contour in contours]
    doubt = np.where(np.isfinite(doubt), doubt, -1.0)
    doubt[list(judged)] = -1.0
    return int(doubt.argmax()) if len(doubt) and doubt.max() >= 0.0 else None


def _covariance(one: Array, other: Array, constant: float) -> Array:
    """Covariance of the latent function between rows of features, shapes (N, F) and (M, F), shape (N, M)."""
    size = one.shape[1]
    apart = scipy.spatial.distance.cdist(one, other, "sqeuclidean") / size
    return np.asarray(constant + _LINEAR / size * (one @ other.T) + _LOCAL * np.exp(-0.5 * apart))


def _pull(covariance: Array, kept: Mask) -> Array:
    """Gradient of the log likelihood at the mode of the posterior, shape (M,), by Newton's method (algorithm 3.1)."""
    latent = np.zeros(len(kept))
    for _ in range(_NEWTON_STEPS):
        right = scipy.special.expit(latent + _PRIOR)
        weight = right * (1.0 - right)
        root = np.sqrt(weight)
        target = weight * latent + (kept - right)
        factor = scipy.linalg.cho_factor(np.eye(len(kept)) + root[:, None] * covariance * root)
        moved = covariance @ (target - root * scipy.linalg.cho_solve(factor, root * (covariance @ target)))
        change = float(np.abs(moved - latent).max())
        latent = moved
        if change < _TOLERANCE:
            break
    return np.asarray(kept - scipy.special.expit(latent + _PRIOR))


def _checked(count: int, kept: Sequence[int], rejected: Sequence[int]) -> dict[int, bool]:
    """Index of each judged contour -> whether it was kept."""
    for name, indices in (("kept", kept), ("rejected", rejected)):
        if np.ndim(indices) != 1 or (len(indices) and np.asarray(indices).dtype.kind not in "iu"):
            raise ValueError(f"{name} is {shown(indices)} but must be a list of the indices of contours.")
    judged = {int(index): True for index in kept} | {int(index): False for index in rejected}
    for index in judged:
        if not 0 <= index < count:
            raise ValueError(f"There is no contour {index}: the result has {count} contours, counted from 0.")
    both = sorted(set(map(int, kept)) & set(map(int, rejected)))
    if both:
        raise ValueError(f"Contour {both[0]} is both kept and rejected: name it once.")
    return judged
