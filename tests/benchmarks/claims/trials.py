"""Trials: drawn images, each with a start and a truth, on which the claims of the publication are tested."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.image.image import Image
from cpm_core.methods import Start
from cpm_core.numerics.types import Array
from cpm_core.shapes import Circle
from docs.gallery import silhouettes
from docs.gallery.outlines import polygon, round_ring
from docs.gallery.scenes import Scene, binary, blurred, closed, grain, paint
from docs.gallery.studies import gaussian, salt_and_pepper

Place = tuple[float, float]

STARTS, CONCAVITIES, TOPOLOGY = "insensitive to the start", "reaches into concavities", "changes topology"
LEAKS, NOISE = "does not leak", "stands noise"

_SMALL = (96, 96)


@dataclass(frozen=True, eq=False)
class Trial:
    """One image with a start.

    Attributes
    ----------
    claim : str
        The claim that it tests.
    name : str
        What is difficult about it.
    image : Image
        The image.
    truth : tuple of Contour
        The true boundaries; a method is to find these and no others.
    start : Start
        Where all methods begin.
    """

    claim: str
    name: str
    image: Image
    truth: tuple[Contour, ...]
    start: Start


def trials() -> Iterator[Trial]:
    """All trials in the order of the claims."""
    yield from _starts()
    yield from _concavities()
    yield from _topology()
    yield from _leaks()
    yield from _noise()


def _trial(claim: str, name: str, scene: Scene, center: Place, radius: float, around: bool = False) -> Trial:
    outline = Circle(center, radius).outline[:-1]
    return Trial(claim, name, Image(scene.values, source=name), scene.truth, Start((outline,), around))


def _starts() -> Iterator[Trial]:
    """One shape with bays; the start inside, across its boundary, beside it, and around it."""
    scene = silhouettes.for_sensitivity()
    yield _trial(STARTS, "start inside", scene, (72.0, 72.0), 14.0)
    yield _trial(STARTS, "start across", scene, (60.0, 40.0), 14.0)
    yield _trial(STARTS, "start outside", scene, (30.0, 30.0), 14.0)
    yield _trial(STARTS, "start around", scene, (72.0, 72.0), 66.0, around=True)


def _concavities() -> Iterator[Trial]:
    yield _trial(CONCAVITIES, "long thin bay", _bay(), (48.0, 48.0), 46.5, around=True)
    yield _trial(CONCAVITIES, "comb", silhouettes.comb(), (26.0, 72.0), 20.0)
    yield _trial(CONCAVITIES, "spiral", silhouettes.spiral(), (112.0, 30.0), 12.0)


def _bay() -> Scene:
    """A square with a bay 50 px deep and 6 px wide."""
    corners = [(16.2, 16.2), (16.2, 45.0), (66.0, 45.0), (66.0, 51.0), (16.2, 51.0), (16.2, 79.8), (79.8, 79.8)]
    return binary(_SMALL, polygon([*corners, (79.8, 16.2)]), np.empty((0, 2)))


def _topology() -> Iterator[Trial]:
    two = [polygon([(25.2, left), (25.2, left + 28.0), (70.8, left + 28.0), (70.8, left)]) for left in (12.2, 55.2)]
    pair = Scene(paint(_SMALL, 20.0, *((one, 200.0) for one in two)), closed(*two), np.empty((0, 2)))
    yield _trial(TOPOLOGY, "around two objects", pair, (48.0, 48.0), 46.5, around=True)
    one = Scene(pair.values, closed(two[0]), np.empty((0, 2)))
    yield _trial(TOPOLOGY, "in one of two objects", one, (48.0, 26.0), 9.0)
    embedded = silhouettes.embedded()
    yield _trial(TOPOLOGY, "rings in rings", embedded["rings in rings"], (72.0, 122.0), 13.0)
    yield _trial(TOPOLOGY, "objects in objects", embedded["objects in objects"], (72.0, 26.0), 14.0)
    yield _trial(TOPOLOGY, "junctions", embedded["three parts of a disk"], (72.0, 118.0), 12.0)


def _leaks() -> Iterator[Trial]:
    yield _trial(LEAKS, "gap in the boundary", _drawing(), (48.0, 40.0), 12.0)
    yield _trial(LEAKS, "fading boundary, noise", _fading(), (48.0, 36.0), 10.0)
    disk = round_ring((48.0, 40.0), 24.0)
    bar = polygon([(8.2, 72.2), (8.2, 84.2), (87.8, 84.2), (87.8, 72.2)])
    beside = Scene(paint(_SMALL, 20.0, (disk, 40.0), (bar, 220.0)), closed(disk), np.empty((0, 2)))
    yield _trial(LEAKS, "weak beside strong edges", beside, (48.0, 40.0), 10.0)


def _drawing() -> Scene:
    """A square drawn as a line 3 px wide, with a gap of 16 px in its upper side."""
    row, col = np.indices(_SMALL)
    away = np.abs(np.maximum(np.abs(row - 48.0), np.abs(col - 48.0)) - 28.0)
    away[(row < 48) & (np.abs(col - 48.0) < 8.0)] = 99.0
    corners = np.array([(20, 40), (20, 20), (76, 20), (76, 76), (20, 76), (20, 56)], dtype=float)
    return Scene(20.0 + 200.0 * np.clip(2.0 - away, 0.0, 1.0), (Contour(corners, closed=False),), np.empty((0, 2)))


def _fading() -> Scene:
    """A disk in noise, on a background that comes near its own gray level on one side."""
    ring = round_ring((48.0, 48.0), 30.0)
    inside = paint(_SMALL, 0.0, (ring, 1.0))
    background: Array = 40.0 + 120.0 * np.clip((np.indices(_SMALL)[1] - 30.0) / 40.0, 0.0, 1.0)
    values = blurred(background + (200.0 - background) * inside, 1.0) + grain(_SMALL, 12.0, 3)
    return Scene(values, closed(ring), np.empty((0, 2)))


def _noise() -> Iterator[Trial]:
    scene = silhouettes.for_noise()
    for spread in (20, 60, 100):
        noisy = Scene(gaussian(scene.values, spread, spread), scene.truth, scene.seeds)
        yield _trial(NOISE, f"Gaussian noise, {spread}", noisy, (70.0, 70.0), 14.0)
    salted = Scene(salt_and_pepper(scene.values, 40, 40), scene.truth, scene.seeds)
    yield _trial(NOISE, "salt and pepper, 40 %", salted, (70.0, 70.0), 14.0)
