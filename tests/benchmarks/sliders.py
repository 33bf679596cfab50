"""What each slider changes: moved before, in the middle of, and after a run, from a circle and from everywhere.

Run ``python -m tests.benchmarks.sliders [IMAGE ROW COL RADIUS]...``; without images it measures coins, a photograph and
a cell of scikit-image. Each row has the mean motion of the first twenty steps after the change [px], steps to rest,
particles, their mean distance from the nearest one [px], number and length of contours [px], and their F with those of
the unchanged run within 2 px: 1 means that the slider changes no contour.
"""

import sys

import numpy as np
from cpm_app.model.display.effects import MOTION_PARAMETERS
from cpm_app.model.parameters.controls import build_controls, set_control_value
from scipy.spatial import cKDTree
from skimage import data

from cpm_core import PRESETS, Engine, circle, load_image
from cpm_core.contours.contour import sample_contours
from cpm_core.model.starts import uniform_grid

SAMPLES = (("coins", 40.0, 200.0, 10.0), ("camera", 150.0, 200.0, 12.0), ("cell", 350.0, 340.0, 30.0))
SLIDERS = {
    control.name: control
    for control in build_controls()
    if control.name in (*MOTION_PARAMETERS, "reach", "weakest_edge")
}


def agreement(points, others):
    """F of two sets of points along contours within 2 px."""
    if not len(points) or not len(others):
        return 0.0
    near = [(cKDTree(b).query(a)[0] <= 2.0).mean() for a, b in ((points, others), (others, points))]
    return 2.0 * near[0] * near[1] / max(sum(near), 1e-12)


def to_rest(engine, state, parameters):
    """The states of a run to its end."""
    while not state.stop_reason:
        state = engine.step(state, parameters)
        yield state


def measured(engine, first, parameters, usual):
    """A row: what follows from a state with these parameters."""
    states = list(to_rest(engine, first, parameters))
    last = states[-1]
    found = engine.result(last, parameters).contours
    speed = np.mean([2.0**state.scale * state.displacement for state in states[:20]])
    near = cKDTree(last.position).query(last.position, 2)[0][:, 1].mean()
    length = sum(contour.length for contour in found)
    return (speed, len(states), last.count, near, len(found), length, agreement(sample_contours(found), usual))


def main():
    given = list(zip(*[iter(sys.argv[1:])] * 4, strict=True))
    for name, *place in given or SAMPLES:
        row, col, radius = map(float, place)
        image = load_image(name) if given else getattr(data, name)().astype(float)
        for preset in ("shape", "automatic"):
            usual = PRESETS[preset]
            engine = Engine(image, usual)
            shape = engine.image.shape
            start = engine.start(circle((row, col), radius) if preset == "shape" else uniform_grid(shape))
            states = list(to_rest(engine, start, usual))
            points = sample_contours(engine.result(states[-1], usual).contours)
            for slider, control in SLIDERS.items():
                if preset == "automatic" and slider not in MOTION_PARAMETERS:
                    continue
                for value in (control.slider_low, control.slider_high):
                    changed = set_control_value(usual, slider, value)
                    moments = {"start": start, "middle": states[len(states) // 2], "rest": states[-1].resume()}
                    for moment, state in moments.items():
                        figures = measured(engine, state, changed, points)
                        print(f"{name} {preset} {slider} {value:g} {moment}", *(f"{one:.4g}" for one in figures))


if __name__ == "__main__":
    main()
