"""Which contours count, learned from ten verdicts: agreement with boundaries that people have drawn; prints a table.

Run by itself: ``python tests/benchmarks/taught.py --data FOLDER``. Each folder in FOLDER is a set of images: `NAME.*`
with `NAME_gt.npz` (`boundaries`, shape (annotators, H, W)), `NAME_labels.png`, `NAME_mask.png` or `NAME_mask1.png`.

Contours of the preset for starts everywhere are judged by the truth, as a person would, one by one: a contour is kept
if most of its length lies within the tolerance of the drawn boundary, 0.75 % of the diagonal, else rejected. The first
three are the longest; each further one is that which is most doubtful. The others are sorted by what these teach. F is
that of the boundary, the best over the annotators, each of whom judges; Canny is that of scikit-image with the best of
four sigmas for the set. "judged only" drops what was rejected and sorts nothing; "mean gain" is over all
annotators the mean F after over the mean F before.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree
from skimage.color import rgb2gray
from skimage.feature import canny
from skimage.io import imread
from skimage.segmentation import find_boundaries

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_core import PRESETS, segment, uniform_grid
from cpm_core.contours.contour import SAMPLING
from cpm_core.contours.features import contour_features
from cpm_core.contours.learning import Examples, left_out, most_doubtful, probabilities
from cpm_core.numerics import polyline

SIGMAS = (1, 2, 3, 4)
TRUTHS = ("_gt.npz", "_labels.png", "_mask.png", "_mask1.png")


def main() -> None:
    """Print a line for each image and each set."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--verdicts", type=int, default=10)
    parser.add_argument("--limit", type=int, default=1000, help="images of a set")
    arguments = parser.parse_args()
    for folder in sorted(path for path in arguments.data.iterdir() if path.is_dir()):
        rows = []
        for path, truth in list(images(folder))[: arguments.limit]:
            rows.append(measured(gray(path), boundaries(truth), arguments.verdicts))
            line(f"{folder.name} {path.stem}", np.array(rows[-1:]))
        if rows:
            line(f"{folder.name}, {len(rows)} images", np.array(rows))


def images(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Images of a folder with their truth."""
    for ending in TRUTHS:
        for truth in sorted(folder.glob(f"*{ending}")):
            stem = truth.name.removesuffix(ending)
            found = [path for path in folder.glob(f"{stem}.*") if path.suffix in (".png", ".jpg", ".tif", ".bmp")]
            if found:
                yield found[0], truth


def gray(path: Path) -> np.ndarray:
    """Gray levels of an image."""
    image = imread(path)
    return (rgb2gray(image[..., :3]) * 255 if image.ndim == 3 else image).astype(float)


def boundaries(path: Path) -> list[np.ndarray]:
    """Pixels of the drawn boundary of each annotator."""
    if path.suffix == ".npz":
        return [np.argwhere(drawn).astype(float) for drawn in np.load(path)["boundaries"]]
    labels = imread(path)
    labels = labels[..., 0] if labels.ndim == 3 else labels
    labels = labels > 127 if "_mask" in path.stem else labels
    return [np.argwhere(find_boundaries(labels, mode="inner")).astype(float)]


def measured(values: np.ndarray, truths: list[np.ndarray], verdicts: int) -> list[float]:
    """F of an image: as found, judged only, taught, mean gain over the annotators, and Canny at each sigma."""
    tolerance = 0.0075 * float(np.hypot(*values.shape))
    result = segment(values, uniform_grid(values.shape, spacing=8.0), PRESETS["automatic"])
    lines = [polyline.sampled(contour.path, SAMPLING) for contour in result.contours]
    features = contour_features(result.contours)
    scores = []
    for truth in truths:
        right = [(KDTree(truth).query(line)[0] <= tolerance).mean() >= 0.5 for line in lines]
        judged, stays = taught(result.contours, features, right, verdicts)
        only = [index not in judged or judged[index] for index in range(len(lines))]
        scores.append([f_of(lines, mask, truth, tolerance) for mask in ([True] * len(lines), only, stays)])
    table = np.array(scores)
    gain = float(table[:, 2].mean() / max(table[:, 0].mean(), 1e-12))
    peers = [np.argwhere(canny(values / 255, sigma)).astype(float) for sigma in SIGMAS]
    rivals = [max(f_of([peer], [True], truth, tolerance) for truth in truths) for peer in peers]
    return [*table.max(axis=0), gain, *rivals]


def taught(contours, features, right, verdicts):
    """Verdicts by index, and which contours stay after them."""
    judged: dict[int, bool] = {}
    longest = sorted(range(len(contours)), key=lambda index: -contours[index].length)
    chances = probabilities(Examples.of((), ()), features)
    while len(judged) < min(verdicts, len(contours)):
        index = longest[len(judged)] if len(judged) < 3 else most_doubtful(contours, chances, list(judged))
        judged[index] = bool(right[index])
        rows = [tuple(features[index]) for index in judged]
        chances = probabilities(Examples.of(rows, list(judged.values())), features)
    stays = ~left_out(chances)
    for index, verdict in judged.items():
        stays[index] = verdict
    return judged, stays.tolist()


def f_of(lines, stays, truth, tolerance) -> float:
    """F of the boundary of the lines that stay."""
    seen = [line for line, stay in zip(lines, stays, strict=True) if stay and len(line)]
    if not seen or not len(truth):
        return 0.0
    found = np.concatenate(seen)
    recall = (KDTree(found).query(truth)[0] <= tolerance).mean()
    precision = (KDTree(truth).query(found)[0] <= tolerance).mean()
    return float(2.0 * recall * precision / max(recall + precision, 1e-12))


def line(name: str, rows: np.ndarray) -> None:
    """Print means and their ratio to Canny's."""
    found, only, after, gain, *peers = rows.mean(axis=0)
    rival = max(*peers, 1e-12)
    sys.stdout.write(
        f"{name}: F {found:.3f}, judged only {only:.3f}, taught {after:.3f}; Canny {rival:.3f}; to Canny "
        f"{found / rival:.2f}, {only / rival:.2f}, {after / rival:.2f}; mean gain {gain:.3f}\n"
    )
    sys.stdout.flush()


if __name__ == "__main__":
    main()
