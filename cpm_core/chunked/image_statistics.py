"""Statistics of the whole image, measured once and given to each chunk: without them, seams would show."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.chunked.grid import Chunk, ChunkedSource, ChunkGrid
from cpm_core.field.edge_map import automatic_smoothing, smoothed_gradient, vector_magnitudes
from cpm_core.field.scale_field import LARGE_IMAGE_PIXELS, ScaleField, charge_edges, weakest_edge
from cpm_core.image.border import find_pixels_inside_border
from cpm_core.image.gray_levels import (
    SPECK_REACH,
    GrayEnds,
    apply_power,
    automatic_gamma,
    find_gray_ends,
    find_inside_rim,
    limit_specks,
    limit_to_usable,
    merge_gray_ends,
)
from cpm_core.image.pyramid import build_pyramid
from cpm_core.numerics.grids import Window, bounding_window, expand_window, relative_window, whole_window
from cpm_core.numerics.types import Array, Arrays, Extent, Integers, JsonDict, frozen
from cpm_core.objects.partition import ParentImage
from cpm_core.objects.prior.crops import find_sample_step, measure_gray_range
from cpm_core.parameters import Parameters
from cpm_core.segmentation.large_images import strongest_edge_window

_STATISTICS_SAMPLES = 2**22
"""Number of pixels of the whole image whose edge strengths are sampled."""

_MAX_COARSE_SIDE = 2048
"""Longest side of the coarse image in which the border and the strongest edge are looked for [px]."""


class ChunkGrayLevels(NamedTuple):
    """Gray levels of the core of a chunk: their ends, a sample, and means of blocks."""

    ends: GrayEnds
    sample: Array
    blocks: Array


class ChunkEdges(NamedTuple):
    """Edges in the core of a chunk: the largest strength at each scale, and some strengths at each."""

    strongest: tuple[float, ...]
    samples: Arrays


@frozen
class GrayScaling:
    """The limits, the scaling and the smoothing of the gray levels of an image.

    Attributes
    ----------
    low, high, exponent : float
        Range of the gray levels that count, and exponent of the power scale within it.
    smoothing : float
        Sigma of the Gaussian before the gradient [px].
    inside : tuple of int
        First row and column within the image border, and those after the last [px].
    """

    low: float
    high: float
    exponent: float
    smoothing: float
    inside: Integers

    def scale_grays(self, values: Array) -> Array:
        """Limit and scale gray levels, of any shape, as those of the whole image are."""
        values = limit_to_usable(values, (self.low, self.high))
        if self.exponent == 1.0 or self.high <= self.low:
            return values
        return apply_power(values, self.low, self.high, self.exponent)

    def adjust_parameters(self, parameters: Parameters) -> Parameters:
        """Adjust the parameters of a run to gray levels that have been scaled."""
        return replace(parameters, gamma=1.0, smoothing=self.smoothing, max_border=0.0)


@frozen
class ImageStatistics:
    """What the fields of a chunk depend on in the whole image.

    Attributes
    ----------
    scaling : GrayScaling
        Scaling of its gray levels.
    strongest, floor : tuple of float
        Largest edge strength, and least edge strength for edge contact, at each scale [gray levels / px].
    parent : ParentImage or None
        The whole image, for the evaluation of objects; None where no objects are sought.
    """

    scaling: GrayScaling
    strongest: tuple[float, ...]
    floor: tuple[float, ...]
    parent: ParentImage | None = None

    @property
    def arrays(self) -> JsonDict:
        """The statistics as arrays to be stored."""
        judged = () if self.parent is None else (*self.parent.gray_range, self.parent.smoothing)
        return {**asdict(self.scaling), "strongest": self.strongest, "floor": self.floor, "judged": judged}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Array], shape: Extent) -> ImageStatistics:
        """Build from stored arrays and the shape of the image."""
        plain: JsonDict = {
            name: tuple(values.tolist()) if values.ndim else float(values) for name, values in arrays.items()
        }
        scaling = GrayScaling(*(plain[field.name] for field in fields(GrayScaling)))
        *gray_range, smoothing = plain["judged"] or (None,)
        parent = None if smoothing is None else ParentImage(shape, (0, 0), tuple(gray_range), smoothing)
        return cls(scaling, plain["strongest"], plain["floor"], parent)

    def impose_on_field(self, field: ScaleField, scale: int, corner: Extent, edge_floor: float) -> ScaleField:
        """Impose what depends on the whole image on the field of a chunk whose first pixel is `corner` of the image."""
        top, left, bottom, right = self.scaling.inside
        rows, cols = (
            (start <= at) & (at < end)
            for n, first, start, end in zip(field.shape, corner, (top, left), (bottom, right), strict=True)
            for at in [first + (np.arange(n) + 0.5) * 2**scale - 0.5]
        )
        found = replace(field, strongest=self.strongest[scale], floor=self.floor[scale])
        return charge_edges(found, rows[:, None] & cols, edge_floor)


def find_block_side(shape: Extent) -> int:
    """Find the side of the blocks whose means make the coarse image: a power of two [px]."""
    return 2 ** max(math.ceil(math.log2(max(shape) / _MAX_COARSE_SIDE)), 0)


def find_sample_spacing(shape: Extent) -> int:
    """Find the distance of the pixels whose edge strengths are sampled [px]."""
    return max(math.ceil((math.prod(shape) / _STATISTICS_SAMPLES) ** (1.0 / len(shape))), 1)


def measure_gray_ends(source: ChunkedSource, chunk: Chunk) -> GrayEnds:
    """Measure the ends of the gray levels of the core of a chunk of an image or a volume; ValueError for NaN."""
    seen = expand_window(chunk.core, SPECK_REACH, source.shape)
    inside = relative_window(find_inside_rim(source.shape), seen)
    ends = find_gray_ends(source.read_values(seen), relative_window(chunk.core, seen), inside)
    if math.isnan(ends.darkest):  # each chunk would fill them in its own way
        raise ValueError(f"{source.path.name} has pixels without data (NaN): replace them by numbers first.")
    return ends


def measure_gray_levels(source: ChunkedSource, chunk: Chunk) -> ChunkGrayLevels:
    """Measure the gray levels of a chunk."""
    shape = source.shape
    values, step, side = source.read_grays(chunk.core), find_sample_step(shape), find_block_side(shape)
    first, left = (-side.start % step for side in chunk.core)
    rows, cols = (-(-n // side) for n in values.shape)
    even = np.pad(values, ((0, rows * side - values.shape[0]), (0, cols * side - values.shape[1])), mode="edge")
    blocks = even.reshape(rows, side, cols, side).mean(axis=(1, 3))
    return ChunkGrayLevels(measure_gray_ends(source, chunk), values[first::step, left::step].ravel(), blocks)


def find_scaling(
    source: ChunkedSource, grid: ChunkGrid, seen: Sequence[ChunkGrayLevels], parameters: Parameters
) -> GrayScaling:
    """Find the scaling of the gray levels of the whole image, from those of the chunks in the order of the grid."""
    low, high = merge_gray_ends(one.ends for one in seen).usable
    sample = limit_to_usable(np.concatenate([one.sample for one in seen]), (low, high))
    exponent = automatic_gamma(sample) if parameters.gamma == "auto" else float(parameters.gamma)
    tone, smoothing = GrayScaling(low, high, exponent, 0.0, ()), parameters.smoothing
    side, coarse = find_block_side(grid.shape), _assemble_coarse_image(grid, seen)
    if smoothing == "auto":
        smoothing = _find_smoothing(source, coarse, tone)
    sigma = max(float(smoothing) / side, 1.0 if side > 1 else 0.0)
    slopes = smoothed_gradient(tone.scale_grays(coarse), sigma)
    inside = find_pixels_inside_border(
        lambda part: slopes[(slice(None), *part)], vector_magnitudes(slopes), sigma, parameters.max_border
    )
    free = bounding_window(inside) if inside.any() else (slice(0, 0), slice(0, 0))
    begin = (part.start * side for part in free)
    end = (
        n if part.stop == blocks else part.stop * side
        for part, blocks, n in zip(free, inside.shape, grid.shape, strict=True)
    )
    return replace(tone, smoothing=float(smoothing), inside=(*begin, *end))


def build_parent_image(source: ChunkedSource, grid: ChunkGrid, seen: Sequence[ChunkGrayLevels]) -> ParentImage:
    """Describe the image that objects are judged in, from the gray levels of the chunks in the order of the grid."""
    grays = measure_gray_range(np.concatenate([one.sample for one in seen]))
    plain = GrayScaling(-math.inf, math.inf, 1.0, 0.0, ())
    return ParentImage(grid.shape, (0, 0), grays, _find_smoothing(source, _assemble_coarse_image(grid, seen), plain))


def _assemble_coarse_image(grid: ChunkGrid, seen: Sequence[ChunkGrayLevels]) -> Array:
    """Assemble the means of the blocks of the whole image, shape (rows, columns of blocks), without specks."""
    columns = grid.counts[1]
    blocks = np.block([[one.blocks for one in seen[at : at + columns]] for at in range(0, len(seen), columns)])
    return limit_specks(blocks)


def _find_smoothing(source: ChunkedSource, coarse: Array, tone: GrayScaling) -> float:
    """Find the smoothing that suits an image; a large one is measured around its strongest edge only."""
    shape = source.shape
    large = math.prod(shape) > LARGE_IMAGE_PIXELS
    part = strongest_edge_window(coarse, find_block_side(shape), shape) if large else whole_window(shape)
    return automatic_smoothing(tone.scale_grays(source.read_grays(part)))


def measure_edges(source: ChunkedSource, chunk: Chunk, tone: GrayScaling, scales: int) -> ChunkEdges:
    """Measure the edges of a chunk at each scale."""
    top, left, bottom, right = tone.inside
    inside = tuple(
        slice(min(max(side.start, low), high), max(min(side.stop, high), low))
        for side, low, high in zip(chunk.core, (top, left), (bottom, right), strict=True)
    )
    return measure_strengths(
        build_pyramid(tone.scale_grays(source.read_grays(chunk.padded)), scales),
        chunk.padded,
        inside,
        find_sample_spacing(source.shape),
        lambda values: vector_magnitudes(smoothed_gradient(values, tone.smoothing)),
    )


def measure_strengths(
    pyramid: Arrays, seen: Window, inside: Window, step: int, find_strength: Callable[[Array], NDArray[Any]]
) -> ChunkEdges:
    """Measure the edge strength inside one of two windows, of which all is seen at each scale of a pyramid.

    One pixel in `step` is sampled along each axis.
    """
    strongest, samples = [], []
    for scale, values in enumerate(pyramid):
        size = 2**scale
        part = tuple(slice(-(-s.start // size), -(-s.stop // size)) for s in relative_window(inside, seen))
        strength = find_strength(values)[part]
        strongest.append(float(strength.max(initial=0.0)))
        some = strength[tuple(slice(-(side.start // size) % step, None, step) for side in inside)]
        samples.append(some.ravel().astype(float))
    return ChunkEdges(tuple(strongest), tuple(samples))


def combine_statistics(
    tone: GrayScaling, seen: Sequence[ChunkEdges], parameters: Parameters, frame: ParentImage | None = None
) -> ImageStatistics:
    """Combine the edges of the chunks to the statistics of the whole image."""
    strongest = tuple(max(scale) for scale in zip(*(one.strongest for one in seen), strict=True))
    if not strongest[0]:
        raise ValueError("The image is the same everywhere and has no edges: open an image with objects.")
    samples = (np.concatenate(scale) for scale in zip(*(one.samples for one in seen), strict=True))
    floor = (weakest_edge(sample, most, parameters.edge_floor) for sample, most in zip(samples, strongest, strict=True))
    return ImageStatistics(tone, strongest, tuple(floor), frame)
