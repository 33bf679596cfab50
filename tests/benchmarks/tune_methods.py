"""Search of the settings of the classical methods, on the trials of ``cpm bench --claims``.

``python tests/benchmarks/tune_methods.py [NAME ...]`` prints, for each method, the settings with the highest mean F
over every second trial, after `MOST_STEPS` at most: each parameter in turn takes each value of its list while the
others stay, and the best is kept. It begins with the defaults; those of the classical methods are what it has found,
except for Chan-Vese, whose runs take too long.
The charged particles are searched in the same way.
"""

import sys
from dataclasses import replace

from cpm_core.cli.compare.trials import trials
from cpm_core.contours.agreement import agreement
from cpm_core.segmentation.methods import CONTOUR_METHODS, run_method

SEARCHED = {
    "cpm": {
        "smoothing": (1.0, "auto", 2.0),
        "reach": (2.0, 20.0, 300.0),
        "weakest_edge": (0.0, 0.3, 0.5),
        "beta": (0.4, 0.8, 1.2),
        "edge_floor": (0.0, 0.1, 0.2),
    },
    "snake": {
        "alpha": (0.0, 0.001, 0.005, 0.015, 0.05),
        "beta": (0.01, 0.1, 1.0),
        "attraction": (0.5, 1.0, 3.0),
        "smoothing": (1.0, 2.0, 4.0),
    },
    "gvf": {
        "mu": (0.02, 0.1, 0.2, 1.0),
        "alpha": (0.0, 0.02, 0.05, 0.2),
        "beta": (0.0, 0.1),
        "attraction": (0.3, 0.6, 1.0),
        "smoothing": (0.5, 1.0, 2.0, 3.0),
    },
    "gac": {
        "balloon": (0.3, 1.0, 2.0),
        "curvature": (0.05, 0.2, 0.5),
        "pull": (0.0, 1.0, 3.0, 10.0),
        "area": (0.0, 0.2),
        "exponent": (1.0, 2.0, 3.0, 4.0, 6.0),
        "contrast": (0.02, 0.05, 0.1, 0.2),
        "smoothing": (0.5, 1.0, 2.0, 3.0),
    },
    "geometric_gvf": {
        "mu": (0.02, 0.1, 0.2, 1.0),
        "curvature": (0.02, 0.05, 0.2, 0.5),
        "pressure": (0.0, 0.1, 0.3, 0.5, 0.7),
        "evenness": (0.0, 0.5, 1.0),
        "smoothing": (0.5, 1.0, 2.0, 3.0),
    },
    "chan_vese": {"mu": (0.01, 0.05, 0.1, 0.25, 0.5), "lambda1": (0.7, 1.0, 1.5), "time_step": (0.5, 1.0, 2.0)},
    "morph_gac": {
        "balloon": (1.0, 2.0),
        "smoothing": (0, 1, 2),
        "threshold": (0.2, 0.3, 0.45, 0.6, 0.75),
        "steepness": (100.0, 300.0, 1000.0),
        "sigma": (0.7, 1.0, 2.0, 3.0),
    },
    "morph_chan_vese": {"smoothing": (0, 1, 2, 3), "lambda1": (0.7, 1.0, 1.5), "lambda2": (0.7, 1.0, 1.5)},
    "random_walker": {
        "beta": (30.0, 130.0, 500.0, 2000.0),
        "depth": (0.5, 0.8, 0.95),
        "margin": (0.0, 30.0, 50.0),
    },
}
"""What was searched: values of each parameter."""


MOST_STEPS = 800
"""Steps after which a run of the search is ended; all runs that find an object are over by then."""


def mean_f(name, settings, among):
    """Mean F of a method over trials."""
    method = CONTOUR_METHODS[name]
    ends = (run_method(method, trial.image, trial.start, settings, MOST_STEPS) for trial in among)
    scores = [agreement(end.state.contours, trial.truth).f for end, trial in zip(ends, among, strict=True)]
    return sum(scores) / len(scores)


def search(name):
    """The best settings that were found, their mean F, and the number of settings tried."""
    among = list(trials())[::2]
    best = CONTOUR_METHODS[name].settings()
    score, tried = mean_f(name, best, among), {best}
    for parameter, values in SEARCHED[name].items():
        for value in values:
            settings = replace(best, **{parameter: value})
            if settings in tried:
                continue
            tried.add(settings)
            found = mean_f(name, settings, among)
            if found > score:
                best, score = settings, found
    return best, score, len(tried)


def main(names):
    for name in names:
        best, score, tried = search(name)
        sys.stdout.write(f"{name}: F {score:.3f} of {tried} settings, {best}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:] or list(SEARCHED))
