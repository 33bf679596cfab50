"""Files: every reader gives a value within the size that a file says, or refuses it in one sentence."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from cpm_core import (
    Centerlines,
    Contour,
    Image,
    Surface,
    Truth,
    load_centerlines,
    load_contours,
    load_image,
    load_points,
    load_surface,
    load_truth,
    load_volume,
    load_volume_truth,
)
from cpm_core.contours.ground_truth import VolumeTruth
from cpm_core.formats.images.decoded import MAXIMUM_PIXELS

from ..report import Budget, Report
from .inputs.mutations import mutated
from .inputs.samples import GRAY, SHAPE, samples
from .inputs.volume_samples import VOLUME
from .limits import check_sentence, in_time
from .trials import at_length

_AT_ONCE = 20
"""Files that one trial tries."""

_AS_THEY_ARE = 0.1
"""Share of the files of a collection that are read without a change."""


def _truth(path: Path) -> Truth:
    return load_truth(path, SHAPE)


def _placed(path: Path) -> tuple[Contour, ...]:
    return load_contours(path, _IMAGE)


def _points_in_space(path: Path) -> np.ndarray:
    return load_points(path, 3)


def _surface_placed(path: Path) -> Surface:
    return load_surface(path, _VOLUME)


def _lines_placed(path: Path) -> Centerlines:
    return load_centerlines(path, _VOLUME, space="RAS")


def _truth_in_space(path: Path) -> VolumeTruth:
    return load_volume_truth(path, _VOLUME)


READERS: dict[str, tuple[Callable[[Path], Any], ...]] = {
    ".csv": (load_contours, _placed, load_points, _points_in_space, _truth),
    **dict.fromkeys((".ply", ".stl", ".obj", ".vtk"), (load_surface, _surface_placed)),
    ".swc": (load_centerlines, _lines_placed),
    **dict.fromkeys((".json", ".geojson", ".zip", ".roi", ".svg", ".dxf"), (load_contours, _placed, _truth)),
}
"""What reads files with such a name; all others are images."""

_OF_IMAGES = (load_image, load_volume, _truth, load_contours, load_surface, _truth_in_space)
_VOLUME = Image(VOLUME, spacing=(2.0, 0.5, 0.5), unit="mm", source="volume")
_IMAGE = Image(GRAY, spacing=(0.5, 0.5), unit="mm", source="gray")


def read(path: Path) -> None:
    """Give a file to all readers of its kind; fails unless each gives a value or refuses it in one sentence."""
    for reader in READERS.get(path.suffix, _OF_IMAGES):
        with in_time():
            try:
                found = reader(path)
            except ValueError as error:
                check_sentence(error)
                assert "does not fit into memory" not in str(error), str(error)
                continue
        check(found)


def check(found: Any) -> None:
    """Fail unless what was read is of finite numbers and of bounded size."""
    if isinstance(found, np.ndarray):
        assert found.ndim == 2, f"points of shape {found.shape}"
        assert found.shape[1] in (2, 3), f"points of shape {found.shape}"
        assert np.isfinite(found).all(), "points that are not finite"
    elif isinstance(found, Truth):
        assert found.labels.shape == SHAPE, f"labels of shape {found.labels.shape}"
    elif isinstance(found, VolumeTruth):
        assert found.labels.shape == VOLUME.shape, f"labels of shape {found.labels.shape}"
    elif isinstance(found, Surface):
        assert np.isfinite(found.vertices).all(), "vertices that are not finite"
        assert not len(found.faces) or found.faces.max() < len(found.vertices), "a triangle of no vertices"
    elif isinstance(found, Centerlines):
        assert all(np.isfinite(branch.points).all() for branch in found.branches), "center lines that are not finite"
        assert all(np.isfinite(branch.radii).all() for branch in found.branches), "radii that are not finite"
    elif isinstance(found, tuple):
        assert all(np.isfinite(contour.points).all() for contour in found), "vertices that are not finite"
        assert all(np.isfinite(contour.strength) for contour in found), "a strength that is not finite"
    else:
        assert found.values.size <= MAXIMUM_PIXELS, f"{found.values.shape} pixels"
        assert np.isfinite(found.values).all(), "gray levels that are not finite"
        assert np.isfinite(np.ptp(found.values)), "gray levels whose span is not finite"
        assert all(np.isfinite(found.spacing)), f"spacing {found.spacing}"
        assert len(found.spacing) == found.values.ndim, f"spacing {found.spacing} of {found.values.ndim} axes"


@functools.cache
def _samples(collection: Path | None) -> list[tuple[str, bytes]]:
    """Suffixes and contents of the own samples, and of the files of a collection, which need not be sound."""
    own: list[tuple[str, bytes]] = [tuple(sample) for sample in samples()]
    if collection is None:
        return own
    files = sorted(path for path in collection.rglob("*") if path.is_file())
    return own + [(".nii.gz" if path.name.endswith(".nii.gz") else path.suffix, path.read_bytes()) for path in files]


def trial(random: Random, folder: Path, collection: Path | None = None) -> int:
    """Damage some samples and read them; what fails is kept beside them."""
    known = _samples(collection)
    others = [content for _, content in known]
    for number in range(_AT_ONCE):
        suffix, content = random.choice(known)
        path = folder / f"damaged{suffix}"
        as_it_is = collection is not None and random.random() < _AS_THEY_ARE
        path.write_bytes(content if as_it_is else mutated(content, random, others))
        try:
            read(path)
        except BaseException as error:
            error.args = (f"file {number} of the trial: {error}",)
            raise
    return _AT_ONCE


def part(budget: Budget) -> Report:
    """Damage and read files until the time is up."""
    return at_length(functools.partial(trial, collection=budget.collection), budget)
