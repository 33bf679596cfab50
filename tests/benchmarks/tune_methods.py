"""Search of the settings of all methods that are compared: the same images, the same search for each.

``python tests/benchmarks/tune_methods.py [NAME ...]`` prints, for each method, the settings with the highest mean F:
each parameter in turn takes each value of its list while the others stay, and the best is kept; then all of them once
more, until nothing becomes better, three times at most. It begins with the defaults. The images are every second trial
of the claims, and a drawn horse and three coins of scikit-image, from inside and from around. The other
trials take no part; the mean F of the defaults and of what was found is printed for them as well, and what was found
becomes the default where it is no worse on them. The charged particles are searched in the same way. It takes an hour
or two of one core, a quarter of an hour of them for Chan-Vese; each better setting is told on the way.
"""

import sys
from dataclasses import replace

import numpy as np
import scipy
import skimage

from cpm_core.contours.agreement import compare_boundaries
from cpm_core.contours.contour import Contour
from cpm_core.image.image import Image
from cpm_core.methods import CONTOUR_METHODS, Start, run_method
from cpm_core.methods.method import trace_boundary
from cpm_core.shapes import Circle
from tests.benchmarks.claims.claims import OURS, OURS_SETTINGS
from tests.benchmarks.claims.trials import Trial, trials

SEARCHED = {
    "cpm": {
        "smoothing": (0.7, 1.0, "auto", 1.5, 2.0),
        "reach": (2.0, 5.0, 20.0, 60.0, 300.0),
        "weakest_edge": (0.0, 0.2, 0.3, 0.5, 0.7),
        "beta": (0.2, 0.4, 0.6, 0.8, 1.2),
        "edge_floor": (0.0, 0.05, 0.1, 0.2, 0.3),
    },
    "snake": {
        "alpha": (0.0, 0.001, 0.005, 0.015, 0.05),
        "beta": (0.01, 0.03, 0.1, 0.3, 1.0),
        "attraction": (0.5, 1.0, 2.0, 3.0, 5.0),
        "smoothing": (1.0, 1.5, 2.0, 3.0, 4.0),
    },
    "gvf": {
        "mu": (0.02, 0.05, 0.1, 0.2, 1.0),
        "alpha": (0.0, 0.01, 0.02, 0.05, 0.2),
        "beta": (0.0, 0.05, 0.1, 0.3, 1.0),
        "attraction": (0.3, 0.6, 1.0, 1.5, 2.0),
        "smoothing": (0.5, 1.0, 1.5, 2.0, 3.0),
    },
    "geodesic": {
        "balloon": (0.1, 0.3, 0.5, 1.0, 2.0),
        "curvature": (0.02, 0.05, 0.1, 0.2, 0.5),
        "pull": (0.0, 1.0, 3.0, 6.0, 10.0),
        "exponent": (1.0, 2.0, 3.0, 4.0, 6.0),
        "contrast": (0.02, 0.05, 0.1, 0.2, 0.4),
        "smoothing": (0.5, 1.0, 1.5, 2.0, 3.0),
    },
    "geometric_gvf": {
        "mu": (0.02, 0.05, 0.1, 0.2, 1.0),
        "curvature": (0.02, 0.05, 0.1, 0.2, 0.5),
        "pressure": (0.0, 0.1, 0.3, 0.5, 0.7),
        "evenness": (0.0, 0.3, 0.5, 0.7, 1.0),
        "smoothing": (0.5, 1.0, 1.5, 2.0, 3.0),
    },
    "chan_vese": {
        "mu": (0.01, 0.05, 0.1, 0.25, 0.5),
        "lambda1": (0.5, 0.7, 1.0, 1.5, 2.0),
        "lambda2": (0.5, 0.7, 1.0, 1.5, 2.0),
    },
    "morph_gac": {
        "balloon": (0.5, 1.0, 2.0),
        "smoothing": (0, 1, 2, 3),
        "threshold": (0.2, 0.3, 0.45, 0.6, 0.75),
        "steepness": (30.0, 100.0, 300.0, 1000.0),
        "sigma": (0.7, 1.0, 1.5, 2.0, 3.0),
    },
    "morph_chan_vese": {
        "smoothing": (0, 1, 2, 3, 4),
        "lambda1": (0.5, 0.7, 1.0, 1.5, 2.0),
        "lambda2": (0.5, 0.7, 1.0, 1.5, 2.0),
    },
    "random_walker": {
        "beta": (30.0, 130.0, 500.0, 1000.0, 2000.0, 5000.0),
        "depth": (0.3, 0.5, 0.65, 0.8, 0.95),
        "margin": (0.0, 10.0, 20.0, 30.0, 50.0),
    },
}
"""What was searched: values of each parameter."""


MOST_ROUNDS = 3
"""Times that the parameters of a method are gone through; fewer when nothing has become better."""

COINS = (((195.0, 102.0), 22.0, False), ((260.0, 46.0), 28.0, True), ((198.0, 154.0), 19.0, False))
"""Center, radius, and whether the start lies around it, of coins that are nearly round."""


def photographs():
    """Images of scikit-image as trials: a horse in noise, and coins with something of what lies beside them."""
    horse = scipy.ndimage.zoom((~skimage.data.horse()).astype(float), 0.3, order=1)
    values = 60.0 + 120.0 * scipy.ndimage.gaussian_filter(horse, 1.0)
    values += np.random.default_rng(1).normal(0.0, 15.0, horse.shape)
    depth = scipy.ndimage.distance_transform_edt(horse > 0.5)
    middle = tuple(map(float, np.unravel_index(depth.argmax(), depth.shape)))
    truth = trace_boundary(horse, 0.5)
    yield Trial("", "horse", Image(values), truth, Start((Circle(middle, 0.7 * float(depth.max())).outline[:-1],)))
    coins = skimage.data.coins().astype(float)
    for (row, col), radius, around in COINS:
        side = int(radius) + 9
        part = coins[int(row) - side : int(row) + side + 1, int(col) - side : int(col) + side + 1]
        truth = (Contour(Circle((side, side), radius).outline[:-1], closed=True),)
        start = Circle((side, side), radius + 5.0 if around else 0.5 * radius)
        yield Trial("", "coin", Image(part), truth, Start((start.outline[:-1],), around))


def mean_f(name, settings, among):
    """Mean F of a method over trials."""
    method = CONTOUR_METHODS[name]
    ends = (run_method(method, trial.image, trial.start, settings) for trial in among)
    scores = [compare_boundaries(end.state.contours, trial.truth).f for end, trial in zip(ends, among, strict=True)]
    return sum(scores) / len(scores)


def search(name, among):
    """The best settings that were found, and the mean F of each that was tried; the first are the defaults."""
    best = OURS_SETTINGS if name == OURS else CONTOUR_METHODS[name].settings()
    tried = {best: mean_f(name, best, among)}
    for _ in range(MOST_ROUNDS):
        before = best
        for parameter, values in SEARCHED[name].items():
            for value in values:
                settings = replace(best, **{parameter: value})
                if settings not in tried:
                    tried[settings] = mean_f(name, settings, among)
                    if tried[settings] > tried[best]:
                        sys.stderr.write(f"{name}: {len(tried)} settings, {tried[settings]:.3f}: {settings}\n")
            best = max(tried, key=tried.__getitem__)
        if best == before:
            break
    return best, tried


def main(names):
    drawn = list(trials())
    among, others = [*drawn[::2], *photographs()], drawn[1::2]
    for name in names:
        best, tried = search(name, among)
        default = next(iter(tried))
        sys.stdout.write(
            f"{name}: {len(tried)} settings, F {tried[default]:.3f} -> {tried[best]:.3f}, on the other trials "
            f"{mean_f(name, default, others):.3f} -> {mean_f(name, best, others):.3f}: {best}\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:] or [name for name in SEARCHED if name in CONTOUR_METHODS])
