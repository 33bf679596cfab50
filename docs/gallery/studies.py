"""Dependence of the result on parameters and on noise: the experiments of Fig. 17 and 18."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cpm_core.numerics.types import Array, Mask
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.engine import Engine
from docs.gallery import silhouettes
from docs.gallery.pages import Map, Page, Panel, Picture
from docs.gallery.recovery import outcome, start
from docs.gallery.runs import Run, run
from docs.gallery.scenes import Scene, grain

RATIOS = (0.05, 0.3, 0.6, 0.9, 0.99)
ANNEALINGS = (0.0, 0.9, 0.97, 0.99, 1.0)
DAMPINGS = (0.2, 0.4, 0.8, 1.4, 2.0)

SPREADS = (20, 60, 80, 100)
PERCENTAGES = (20, 60, 80, 90)
_NOISE_TOLERANCE, _GOOD = 3.0, 0.95


def sensitivity() -> Page:
    """Fig. 17: weight ratio and annealing on one shape; weight ratio and damping with a second, distant shape."""
    one, two = silhouettes.for_sensitivity(), silhouettes.out_of_reach()
    shape, pair = (_Varied(scene) for scene in (one, two))
    ratios = [shape.picture(f"w₁/w₂ = {ratio:g}", _weighted(one.parameters, ratio)) for ratio in RATIOS]
    annealings = [shape.picture(f"a = {a:g}", replace(one.parameters, annealing=a)) for a in ANNEALINGS]
    over_annealing = shape.map("annealing a", ANNEALINGS, [replace(one.parameters, annealing=a) for a in ANNEALINGS])
    over_damping = pair.map("damping β", DAMPINGS, [replace(two.parameters, beta=beta) for beta in DAMPINGS])
    found, most = over_annealing.values > _GOOD, int((over_damping.values > _GOOD).sum())
    always = ", ".join(f"{ratio:g}" for ratio, whole in zip(RATIOS, found.all(axis=0), strict=True) if whole)
    maps: list[Panel] = [
        replace(over_annealing, title="F over w₁/w₂ and annealing, this shape", span=2),
        start(two, "with a shape out of reach"),
        replace(over_damping, title="F over w₁/w₂ and damping, both shapes", span=2),
    ]
    return Page(
        [ratios, annealings, maps],
        note=f"F above {_GOOD:g} at {int(found.sum())} of {found.size} settings of w₁/w₂ and annealing, at every "
        f"annealing for w₁/w₂ = {always}; the shape out of reach is found at {most} of {over_damping.values.size} "
        "settings of w₁/w₂ and damping",
    )


class _Varied:
    """A scene that is run with many parameters."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._engine = scene, Engine(scene.values, scene.parameters)

    def picture(self, title: str, parameters: Parameters) -> Picture:
        """Show the result with these parameters."""
        panel = outcome(title, run(self._scene.under(parameters), engine=self._engine))
        varied = {"w_ratio": round(parameters.w1 / parameters.w2, 4), "a": parameters.annealing}
        return replace(panel, facts={**varied, **(panel.facts or {})})

    def map(self, label: str, values: Sequence[float], settings: Sequence[Parameters]) -> Map:
        """F of recall and precision over weight ratios and the values of another parameter."""
        agreement = np.array([[self._f(_weighted(setting, ratio)) for ratio in RATIOS] for setting in settings])
        facts = {"w_ratio": list(RATIOS), label: list(values), "f": np.round(agreement, 4).tolist()}
        return Map(label, agreement, RATIOS, values, "w₁/w₂", label, facts)

    def _f(self, parameters: Parameters) -> float:
        return run(self._scene.under(parameters), engine=self._engine).end.agreement.f


def _weighted(parameters: Parameters, ratio: float) -> Parameters:
    return replace(parameters, w1=ratio * parameters.w2)


def noise() -> Page:
    """Fig. 18: three kinds of noise in four strengths each, with smoothing chosen from the image."""
    scene = silhouettes.for_noise()
    kinds = (
        ("Gaussian, σ = {}", gaussian, SPREADS),
        ("uniform, {} %", uniform, PERCENTAGES),
        ("salt and pepper, {} %", salt_and_pepper, PERCENTAGES),
    )
    runs = [
        [(title.format(amount), _under_noise(scene, spoil(scene.values, amount, amount))) for amount in amounts]
        for title, spoil, amounts in kinds
    ]
    good = sum(done.end.agreement.f >= _GOOD for row in runs for _, done in row)
    first = (start(scene, "common start"), None, None)
    rows = [[one, *(outcome(title, done) for title, done in row)] for one, row in zip(first, runs, strict=True)]
    return Page(rows, note=f"F of {_GOOD:g} or more in {good} of {sum(map(len, runs))} cases")


def _under_noise(scene: Scene, values: Array) -> Run:
    return run(replace(scene, values=values, parameters=PRESETS["noisy"]), tolerance=_NOISE_TOLERANCE)


def gaussian(values: Array, spread: float, seed: int) -> Array:
    """Add normal noise, and clip the sum to gray levels from 0 to 255."""
    shape = (values.shape[0], values.shape[1])
    return np.clip(values + grain(shape, spread, seed), 0.0, 255.0)


def uniform(values: Array, percentage: float, seed: int) -> Array:
    """Pixels of a percentage replaced by any gray level from 0 to 255."""
    random = np.random.default_rng(seed)
    return np.where(_chosen(values, percentage, random), random.integers(0, 256, values.shape), values)


def salt_and_pepper(values: Array, percentage: float, seed: int) -> Array:
    """Pixels of a percentage replaced by black or white."""
    random = np.random.default_rng(seed)
    return np.where(_chosen(values, percentage, random), 255.0 * random.integers(0, 2, values.shape), values)


def _chosen(values: Array, percentage: float, random: np.random.Generator) -> Mask:
    """Exactly that percentage of the pixels, at random."""
    order = random.permutation(values.size).reshape(values.shape)
    return np.asarray(order < round(0.01 * percentage * values.size))
