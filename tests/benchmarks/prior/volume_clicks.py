"""How many clicks until a body is right: a robot for a user, in volumes; prints a table.

    python -m tests.benchmarks.prior.volume_clicks [--data FOLDER] [--only NAME ...] [--seeds 2] [--peers]

The robot sees the truth. It clicks into the slice with the largest error, at the middle of the largest wrong place
there: what is missing is clicked as inside, what is too much as outside. It stops at a Dice coefficient of 0.90, or
after 20 clicks. Bodies are those of `bodies.py`; and of a folder with `volumes`, brain and skull of a head whose gray
levels are made up, since none come with the masks, and the part of a tree of vessels around its widest place, blurred
and with noise. Peers, with the same robot and clicks of their own: the random walker of scikit-image in space, and
GrabCut slice by slice, in which the answer of a slice is the probable one of the next.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import scipy
import skimage

import cpm_core as cpm
from cpm_core.numerics.grids import label_parts, measure_depth
from cpm_core.numerics.types import Array, Mask
from tests.benchmarks.prior.bodies import KINDS, body

MOST, GOAL, SIDE = 20, 0.9, 64
"""Clicks at most, Dice coefficient at which the robot stops, and side of drawn volumes."""

Answer = Callable[[Array, Array], Mask]
"""The body of places inside and outside, each of shape (N, 3)."""


class Trial(NamedTuple):
    """Dice coefficients after each click, and seconds of the clock and of the processor for each answer."""

    dice: list[float]
    wall: list[float]
    cpu: list[float]

    @property
    def clicks(self) -> int:
        """Clicks until the body was right; the most where it never was."""
        return len(self.dice) if self.dice[-1] >= GOAL else MOST

    def after(self, clicks: int) -> float:
        """Dice coefficient after so many clicks."""
        return self.dice[min(clicks, len(self.dice)) - 1]


def dice(one: Mask, other: Mask) -> float:
    """Dice coefficient of two masks."""
    return 2.0 * np.count_nonzero(one & other) / max(np.count_nonzero(one) + np.count_nonzero(other), 1)


def next_click(found: Mask, truth: Mask, clicked: set[tuple[int, ...]]) -> tuple[tuple[int, ...], bool]:
    """Where the robot clicks, and whether it means inside."""
    wrong = found != truth
    for plane in np.argsort(-wrong.sum(axis=(1, 2))).tolist():
        best = (0.0, (0, 0, 0), True)
        for part, inside in ((truth & ~found)[plane], True), ((found & ~truth)[plane], False):
            depth = measure_depth(part)
            for place in clicked:
                if place[0] == plane:
                    depth[place[1:]] = 0.0
            row, col = np.unravel_index(int(depth.argmax()), depth.shape)
            best = max(best, (float(depth[row, col]), (plane, int(row), int(col)), inside))
        if best[0] > 0.0:
            return best[1], best[2]
    raise ValueError("nothing is wrong")


def trial(answer: Answer, truth: Mask) -> Trial:
    """What the robot reaches with a method."""
    found, inside, outside, made = np.zeros_like(truth), [], [], Trial([], [], [])
    while len(made.dice) < MOST and (not made.dice or made.dice[-1] < GOAL):
        place, within = next_click(found, truth, {*inside, *outside})
        (inside if within else outside).append(place)
        wall, cpu = time.perf_counter(), time.process_time()
        found = answer(np.array(inside, float).reshape(-1, 3), np.array(outside, float).reshape(-1, 3))
        made.wall.append(time.perf_counter() - wall)
        made.cpu.append(time.process_time() - cpu)
        made.dice.append(dice(found, truth))
    return made


def ours(values: Array, spacing: tuple[float, ...]) -> Answer:
    """The program: each answer corrects the one before."""
    cut, before = cpm.partition(cpm.Image(values, spacing=spacing)), None

    def answer(inside: Array, outside: Array) -> Mask:
        nonlocal before
        before = cut.select(inside, outside, previous=before)
        return before.mask

    return answer


def _seeds(shape: tuple[int, ...], inside: Array, outside: Array) -> Array:
    """1 around places inside, 2 around those outside and at the border."""
    seeds = np.zeros(shape, np.int32)
    if not len(outside):
        for axis in range(3):
            np.moveaxis(seeds, axis, 0)[[0, -1]] = 2
    for places, number in ((inside, 1), (outside, 2)):
        for place in places.astype(int).tolist():
            seeds[tuple(slice(max(at - 1, 0), at + 2) for at in place)] = number
    return seeds


def walker(values: Array, _: tuple[float, ...]) -> Answer:
    """The random walker in space."""
    scaled = (values - values.min()) / np.ptp(values)

    def answer(inside: Array, outside: Array) -> Mask:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            seeds = _seeds(values.shape, inside, outside)
            labels = skimage.segmentation.random_walker(scaled, seeds, beta=130, mode="cg_j", tol=1e-2)
        return np.asarray(labels == 1)

    return answer


def grab_cut(values: Array, _: tuple[float, ...]) -> Answer:
    """GrabCut in the slices across the first axis, from those that have been clicked on."""
    scaled = np.clip((values - values.min()) / np.ptp(values) * 255.0, 0, 255).astype(np.uint8)

    def cut(plane: int, former: Mask | None, seeds: Array) -> Mask:
        picture = np.repeat(scaled[plane][..., None], 3, axis=2)
        known = np.full(picture.shape[:2], cv2.GC_PR_BGD, np.uint8)
        if former is not None:
            known[former] = cv2.GC_PR_FGD
        elif (seeds == 1).any():
            known[scipy.ndimage.distance_transform_edt(seeds != 1) < 0.1 * min(known.shape)] = cv2.GC_PR_FGD
        known[seeds == 1], known[seeds == 2] = cv2.GC_FGD, cv2.GC_BGD
        known[[0, -1]] = cv2.GC_BGD
        if not np.isin(known, (1, 3)).any():
            return np.zeros(known.shape, np.bool_)
        cv2.grabCut(picture, known, None, np.zeros((1, 65)), np.zeros((1, 65)), 3, cv2.GC_INIT_WITH_MASK)
        return np.isin(known, (1, 3))

    def answer(inside: Array, outside: Array) -> Mask:
        seeds, found = _seeds(values.shape, inside, outside), np.zeros(values.shape, np.bool_)
        clicked = sorted({int(place[0]) for place in inside})
        for plane in clicked:
            found[plane] = cut(plane, None, seeds[plane])
        away = np.abs(np.subtract.outer(np.arange(len(values)), clicked))
        for plane in np.argsort(away.min(axis=1)).tolist():
            if away[plane].min():
                toward = plane + int(np.sign(clicked[int(away[plane].argmin())] - plane))
                found[plane] = cut(plane, found[toward], seeds[plane])
        return found

    return answer


def things(data: Path | None, seeds: int) -> Iterator[tuple[str, Array, Mask, tuple[float, ...]]]:
    """Name, gray levels, body and spacing of each volume."""
    for kind in KINDS:
        for seed in range(1, seeds + 1):
            yield kind, *body(kind, SIDE, np.random.default_rng(seed)), (1.0, 1.0, 1.0)
    if data is not None:
        with np.load(data / "volumes" / "seg3d_MR_aligned_masks.npz") as masks:
            brain, skull = masks["brain"], masks["skull"] & ~masks["brain"]
        values = head(brain, skull)
        yield "brain", values, brain, (1.0, 1.0, 1.0)
        yield "skull", values, skull, (1.0, 1.0, 1.0)
        yield "vessels", *vessels(data / "volumes" / "ds003949_sub-000_vessel_label.nii.gz")


def head(brain: Mask, skull: Mask) -> Array:
    """Gray levels of a head as in a T1 image: fat bright, bone dark, two tissues in the brain, shading and noise."""
    rng = np.random.default_rng(0)
    whole = scipy.ndimage.binary_fill_holes(scipy.ndimage.binary_dilation(brain | skull, iterations=6))
    folds = scipy.ndimage.gaussian_filter(rng.normal(size=brain.shape), 2.5)
    values = np.where(whole, 150.0, 8.0)
    values[skull], values[brain] = 25.0, 95.0
    values[brain & (folds > 0.4 * folds.std())] = 125.0
    shade = scipy.ndimage.gaussian_filter(rng.normal(size=brain.shape), 40.0)
    values = scipy.ndimage.gaussian_filter(values, 0.8) * (1.0 + 0.1 * shade / shade.std())
    return np.asarray(values + rng.normal(0.0, 8.0, values.shape))


def vessels(path: Path) -> tuple[Array, Mask, tuple[float, ...]]:
    """A tree of vessels around its widest place, blurred and with noise, and the voxel size."""
    image = cpm.load_volume(path)
    label = image.values > 0
    depth = scipy.ndimage.distance_transform_edt(label)
    widest = np.unravel_index(int(depth.argmax()), depth.shape)
    box = tuple(slice(max(at - 48, 0), at + 48) for at in widest)
    parts, _ = label_parts(label[box])
    tree = parts == np.bincount(parts[parts > 0]).argmax()
    values = scipy.ndimage.gaussian_filter(200.0 * label[box], 0.7)
    return values + np.random.default_rng(0).normal(0.0, 20.0, values.shape), tree, image.spacing


def main() -> None:
    """Print a line for each body and method, and means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="folder with volumes")
    parser.add_argument("--only", nargs="*", default=(), help="names of bodies")
    parser.add_argument("--seeds", type=int, default=2, help="drawn bodies of each kind")
    parser.add_argument("--peers", action="store_true", help="next to other methods")
    given = parser.parse_args()
    methods = {"cpm": ours} | ({"walker": walker, "grabcut": grab_cut} if given.peers else {})
    print(f"{'body':10}{'voxels':>9}  {'method':8}{'clicks':>7}  Dice@1  @3  @5  @10  first s (cpu)  next s (cpu)")
    means: dict[str, list[int]] = {name: [] for name in methods}
    for name, values, truth, spacing in things(given.data, given.seeds):
        if given.only and name not in given.only:
            continue
        for method, make in methods.items():
            made = trial(make(values, spacing), truth)
            means[method].append(made.clicks)
            later = (np.median(each[1:]) if len(each) > 1 else 0.0 for each in (made.wall, made.cpu))
            reached = "".join(f"{made.after(clicks):6.3f}" for clicks in (1, 3, 5, 10))
            print(
                f"{name:10}{np.count_nonzero(truth):9,}  {method:8}{made.clicks:7d}  {reached}"
                f"{made.wall[0]:8.2f} ({made.cpu[0]:.2f}){next(later):8.2f} ({next(later):.2f})",
                flush=True,
            )
    for method, clicks in means.items():
        print(f"{method:8} mean clicks {np.mean(clicks):.2f}, right after one click {np.mean(np.equal(clicks, 1)):.2f}")


if __name__ == "__main__":
    main()
