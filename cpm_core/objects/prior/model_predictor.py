"""Predictions of a larger model for prompts on an image, in the form of those of the network."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
import PIL.Image
import scipy

from cpm_core.numerics.grids import bounding_window, compute_iou, first_pixel, measure_depth
from cpm_core.numerics.types import Array, Extent, Index, Numbers, Pixels, Single, record
from cpm_core.objects.prior.crops import measure_image_grays, sample_bilinear
from cpm_core.objects.prior.larger_models import decode_prompt, encode_image
from cpm_core.objects.prior.object_predictor import (
    AREA_PENALTY,
    MAX_PREDICTIONS,
    SAME_OBJECT_IOU,
    Prediction,
    Prompt,
    put_surroundings_last,
)

_SEEN_SIDE = 1024
"""Longer side of the image that a model sees [px]."""

_ANSWER_SIDE = 256
"""Side of the maps that it answers with [px]."""

_STABLE_LOGIT = 1.0
"""Logits between which a boundary may lie, above and below 0."""

_MAX_STROKE_POINTS = 32
"""Largest number of points by which a scribble is given."""

_MAX_AREA_POINTS = 5
"""Largest number of points by which an area is given."""


@record
class ModelPredictor:
    """Predictions of a larger model for prompts on an image, which it sees as a whole.

    Attributes
    ----------
    values : ndarray, shape (H, W) or (H, W, 3)
        Gray levels, or colors.
    model : str
        Name of the model; see `larger_models`.
    gray_range : tuple of float, optional
        Gray levels that become 0 and 255, if those of a larger image are used.
    """

    values: Numbers
    model: str
    gray_range: tuple[float, ...] = ()

    def predict_objects(self, prompt: Prompt, known_area: float | None = None) -> Iterator[Prediction]:
        """Predict the objects that a prompt may mean, as `Predictor.predict_objects`."""
        places, labels = _list_points(prompt)
        if not len(places):
            return
        embedding = encode_image(self.model, self._pixels)
        logits, ious = decode_prompt(self.model, embedding, np.maximum(self._shrink(places), 0.0), labels)
        found = [self._build_prediction(logits, ious, number) for number in range(len(ious))]
        found.sort(key=lambda one: -_rate_prediction(one, prompt, known_area))
        distinct: list[Prediction] = []
        for one in found:
            if one.mask.any() and all(compute_iou(one.mask, other.mask) <= SAME_OBJECT_IOU for other in distinct):
                distinct.append(one)
        yield from put_surroundings_last(distinct[:MAX_PREDICTIONS], prompt)

    def _build_prediction(self, logits: Single, ious: Single, number: int) -> Prediction:
        """Build the prediction of one of several answers."""
        answer, mask = logits[number], np.zeros(self.values.shape[:2], np.bool_)
        likely = answer > 0.0
        if likely.any():
            ends = ((side.start - 0.5, side.stop + 0.5) for side in bounding_window(likely))
            sides: Extent = mask.shape
            rows, cols = (
                np.arange(max(int(low * self._scale), 0), min(int(high * self._scale) + 1, side))
                for (low, high), side in zip(ends, sides, strict=True)
            )
            seen = sample_bilinear(answer[..., None], self._shrink(rows), self._shrink(cols))
            mask[np.ix_(rows, cols)] = seen[..., 0] > 0.0
        probability = scipy.special.expit(answer)
        certainty = probability[likely].sum() / max(float(likely.sum() + probability[~likely].sum()), 1.0)
        steadiness = compute_iou(answer > _STABLE_LOGIT, answer > -_STABLE_LOGIT)
        others = [compute_iou(likely, other > 0.0) for at, other in enumerate(logits) if at != number]
        iou = float(np.clip(ious[number], 0.0, 1.0))
        coarseness = max(max(mask.shape) / _ANSWER_SIDE, 1.0)
        return Prediction(mask, coarseness, iou, float(certainty), steadiness, max(others, default=1.0))

    def _shrink(self, positions: Array | Index) -> Array:
        """Convert positions in the image to those in the image that the model sees [px]."""
        return np.asarray((positions + 0.5) / self._scale - 0.5)

    @property
    def _scale(self) -> float:
        return max(max(self.values.shape[:2]) / _SEEN_SIDE, 1.0)

    @cached_property
    def _pixels(self) -> Pixels:
        """The image that the model sees, shape (H, W, 3)."""
        low, high = self.gray_range or measure_image_grays(self.values)
        levels = np.clip((self.values - low) * (255.0 / max(high - low, 1e-300)), 0.0, 255.0).astype(np.uint8)
        picture = PIL.Image.fromarray(levels).convert("RGB")
        height, width = (max(round(side / self._scale), 1) for side in levels.shape[:2])
        return np.asarray(picture.resize((width, height), PIL.Image.Resampling.BILINEAR))


def _list_points(prompt: Prompt) -> tuple[Array, Index]:
    """List a prompt as points, shape (N, 2), and what they mean, shape (N,), as `decode_prompt` takes them."""
    inside = _pick_evenly(prompt.positive, _MAX_STROKE_POINTS)
    area = prompt.previous_mask if prompt.drawn_area is None else prompt.drawn_area
    if area is not None and area.any() and not len(inside):
        box = bounding_window(area)
        depth = measure_depth(area[box])
        deep = np.argwhere(depth >= 0.5 * depth.max()) + first_pixel(box)
        inside = _pick_evenly(deep, _MAX_AREA_POINTS)
    places = [inside, prompt.negative]
    labels = [1] * len(inside) + [0] * len(prompt.negative)
    if prompt.box is not None:
        places.append(np.array(prompt.box).reshape(2, 2).T)
        labels += [2, 3]
    return np.concatenate(places).astype(float), np.array(labels, np.int64)


def _pick_evenly(pixels: Index, count: int) -> Index:
    """Pick at most some number of pixels, shape (N, 2), evenly."""
    return pixels[np.unique(np.linspace(0, len(pixels) - 1, count).round().astype(int))] if len(pixels) else pixels


def _rate_prediction(found: Prediction, prompt: Prompt, known_area: float | None) -> float:
    """Rate a prediction among others: what contradicts no point is first, then what is likely."""
    wrong = np.count_nonzero(~found.mask[tuple(prompt.positive.T)])
    wrong += np.count_nonzero(found.mask[tuple(prompt.negative.T)])
    rating = found.predicted_iou - wrong
    if known_area is not None:
        rating -= AREA_PENALTY * abs(float(np.log(max(known_area, 1.0) / max(int(np.count_nonzero(found.mask)), 1))))
    return rating + (0.0 if prompt.previous_mask is None else compute_iou(found.mask, prompt.previous_mask))
