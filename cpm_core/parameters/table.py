"""Every parameter that is a number: symbol, unit, range, meaning, what a change makes out of date."""

from __future__ import annotations

from dataclasses import dataclass

from cpm_core.parameters.choices import CHOICES, Invalidates


@dataclass(frozen=True, slots=True)
class ParameterInfo:
    """Description of one parameter, for the user.

    Attributes
    ----------
    name : str
        Field of `Parameters`.
    symbol : str
        Symbol in the equations.
    unit : str
        Unit, empty for pure numbers.
    low, high : float
        Allowed range, both ends included.
    slider_low, slider_high, step : float
        Useful range and increment of a slider.
    title : str
        Short name for a label.
    meaning : str
        One sentence: what it is.
    more : str
        One sentence: the effect of a larger value.
    equation : str
        Place in the published model; empty for parameters that the model does not have.
    invalidates : {"nothing", "contours", "field", "run"}
        What a change makes out of date: nothing (the next step uses the value), the contours but not the particles, the
        edge map and field, or the whole run.
    advanced : bool
        Whether a window may hide it at first.
    """

    name: str
    symbol: str
    unit: str
    low: float
    high: float
    slider_low: float
    slider_high: float
    step: float
    title: str
    meaning: str
    more: str
    equation: str
    invalidates: Invalidates
    advanced: bool


UNLIMITED_REACH = 300.0
"""`Parameters.reach` at which there is no limit: a front creeps along every edge that is connected to its own [px]."""

_TABLE = (
    ParameterInfo(
        "reach", "r", "px", 0.0, UNLIMITED_REACH, 0.0, UNLIMITED_REACH, 1.0, "Reach",
        "How far particles follow edges beyond a junction, away from the edges around the start; at 300 there is no "
        "limit.",
        "More of it also finds what is connected to the object, and in the end everything.",
        "", "field", False,
    ),
    ParameterInfo(
        "weakest_edge", "f_first", "", 0.0, 0.95, 0.0, 0.95, 0.01, "Weakest edge",
        "Fraction of the strength of the edges around the start under which an edge does not hold particles; above 0 "
        "an edge must also go from dark to light in the same direction as most edges around the start.",
        "More of it leaves out edges that are weaker than those around the start.",
        "", "field", False,
    ),
    ParameterInfo(
        "beta", "β", "", 0.0, 4.0, 0.1, 2.0, 0.05, "Damping",
        "Friction that slows the particles down.",
        "More of it brings the particles to rest sooner, at the first edges they meet; "
        "less lets them move on across weak edges.",
        "eq. (12)", "nothing", False,
    ),
    ParameterInfo(
        "w1", "w₁", "", 0.0, 100.0, 0.05, 3.0, 0.05, "Repulsion",
        "Weight of the repulsion between particles, the Coulomb force.",
        "More of it spreads the particles faster along edges and into bays; it must stay below w₂.",
        "eq. (12)", "nothing", False,
    ),
    ParameterInfo(
        "w2", "w₂", "", 0.001, 100.0, 0.1, 3.0, 0.05, "Attraction",
        "Weight of the attraction by the edges of the image, the Lorentz force.",
        "More of it pulls the particles harder to edges and holds them there; it must stay above w₁.",
        "eq. (12)", "nothing", True,
    ),
    ParameterInfo(
        "annealing", "a", "", 0.0, 1.0, 0.9, 1.0, 0.001, "Annealing",
        "Factor by which the insertion range shrinks at every step.",
        "More of it (nearer to 1) inserts particles for longer, which gives denser rows along the edges.",
        "section 3.6", "nothing", False,
    ),
    ParameterInfo(
        "time_step", "Δt", "", 0.01, 1.0, 0.05, 1.0, 0.05, "Time step",
        "Time between two steps of a run.",
        "More of it moves the particles farther in a step; with too much they miss the edges.",
        "eq. (14)", "nothing", True,
    ),
    ParameterInfo(
        "d_min", "d_min", "px", 0.5, 20.0, 1.0, 6.0, 0.1, "Particle spacing",
        "Distance between neighbors; of two particles nearer than half of it, one is deleted.",
        "More of it gives fewer particles and coarser contours.",
        "section 3.6", "nothing", True,
    ),
    ParameterInfo(
        "d_max", "d_max,0", "px", 0.0, 50.0, 0.0, 10.0, 0.1, "Insertion range",
        "Two neighbors at rest on an edge, farther apart than the particle spacing by at most this, get a particle "
        "between them; it shrinks by the annealing.",
        "More of it inserts particles between neighbors that are farther apart.",
        "section 3.6", "nothing", True,
    ),
    ParameterInfo(
        "smoothing", "σ", "px", 0.0, 20.0, 0.5, 8.0, 0.1, "Smoothing",
        "Width of the Gaussian filter that smooths the image before its edges are found.",
        "More of it removes noise and texture, and rounds corners.",
        "section 3.1", "field", False,
    ),
    ParameterInfo(
        "gamma", "γ", "", 0.1, 4.0, 0.2, 2.0, 0.05, "Gamma",
        "Exponent applied to the gray levels, over their range in the image, before edges are found.",
        "Less of it (below 1) strengthens edges between dark gray levels, more of it those between bright ones.",
        "", "field", True,
    ),
    ParameterInfo(
        "scales", "S", "", 1, 8, 1, 5, 1, "Scales",
        "Number of scales of the image, each half the size of the one before; a run goes from coarse to fine.",
        "More of it finds large objects sooner and ignores finer noise on the way.",
        "section 4.2", "run", True,
    ),
    ParameterInfo(
        "edge_floor", "f_min", "", 0.0, 0.99, 0.0, 0.6, 0.01, "Edge floor",
        "Fraction of the largest edge strength under which no fixed charge is placed; at 0 all are placed, and the "
        "strength of the background decides what is too weak for an edge.",
        "More of it leaves out weak edges and texture.",
        "", "field", False,
    ),
    ParameterInfo(
        "exponent", "n", "", 1.0, 8.0, 1.0, 6.0, 0.1, "Exponent",
        "Power of the distance with which the force of a fixed charge decays; by itself the number of dimensions, 2 in "
        "an image and 3 in a volume.",
        "More of it draws particles to the nearest edges, less of it to where many edges are, however far away.",
        "eq. (8)", "field", True,
    ),
    ParameterInfo(
        "max_border", "m_max", "", 0.0, 0.25, 0.0, 0.2, 0.01, "Maximum border",
        "A dark or bright rim of the image up to this width, as a fraction of its shorter side, counts as its border; "
        "its edge is left out.",
        "More of it finds wider borders; 0 leaves every edge in.",
        "", "field", True,
    ),
    ParameterInfo(
        "max_gap", "g_max", "px", 0.0, 1e4, 0.0, 60.0, 1.0, "Maximum gap",
        "Distance up to which loose ends of contours are joined across a gap, along the edge map.",
        "More of it bridges wider gaps; at 0 real gaps stay open.",
        "", "contours", False,
    ),
    ParameterInfo(
        "min_strength", "s_min", "gray/px", 0.0, 1e9, 0.0, 60.0, 0.5, "Minimum strength",
        "Mean edge strength under which a contour, or a part of one with a loose end, is left out.",
        "More of it keeps only the contours of strong edges.",
        "", "contours", False,
    ),
    ParameterInfo(
        "sure_edge", "f_sure", "", 0.0, 0.99, 0.0, 0.6, 0.01, "Sure edge",
        "Fraction of the largest edge strength under which a contour stays only if it is connected to one above it.",
        "More of it leaves out weak contours that stand alone and keeps those that continue strong ones.",
        "", "contours", True,
    ),
    ParameterInfo(
        "min_contrast", "c_min", "", 0.0, 0.99, 0.0, 0.9, 0.01, "Minimum contrast",
        "Contrast of the regions on both sides, from 0 for equal ones to 1 for uniform ones, under which a contour, or "
        "a part of one with a loose end, is left out.",
        "More of it leaves out texture, which looks the same on both sides of an edge.",
        "", "contours", True,
    ),
    ParameterInfo(
        "min_length", "l_min", "px", 0.0, 1e9, 0.0, 200.0, 1.0, "Minimum length",
        "Length under which a contour is left out.",
        "More of it drops specks and fragments.",
        "", "contours", False,
    ),
    ParameterInfo(
        "polarity", "p", "", -1.0, 1.0, -1.0, 1.0, 1.0, "Dark or light",
        "What has a skeleton: below 0 what is darker than its surroundings, above 0 what is lighter; at 0 the image "
        "decides.",
        "More of it goes from dark to light objects.",
        "", "contours", False,
    ),
    ParameterInfo(
        "max_width", "w_max", "px", 0.0, 1e4, 0.0, 100.0, 0.5, "Maximum width",
        "Width above which a part has no skeleton; at 0 any width counts where the outlines are closed, and otherwise "
        "the widths in the image decide.",
        "More of it includes wider parts.",
        "", "contours", False,
    ),
    ParameterInfo(
        "pruning", "ρ", "px", 0.0, 1e3, 0.0, 10.0, 0.1, "Pruning",
        "How far a part of a shape may extend beyond the rest without a branch of the skeleton of its own.",
        "More of it leaves fewer and shorter branches.",
        "section 5.3", "contours", False,
    ),
)  # fmt: skip

PARAMETERS: dict[str, ParameterInfo] = {info.name: info for info in _TABLE}

OF_SKELETONS: tuple[str, ...] = ("polarity", "max_width", "pruning")
"""Parameters that skeletons alone depend on."""

OF_STARTS: tuple[str, ...] = ("reach", "weakest_edge")
"""Parameters on which nothing without a start depends."""

OF_CHARGES: tuple[str, ...] = ("exponent", "accuracy")
"""Parameters on which nothing without particles depends: they act on the field of the fixed charges alone."""

OF_PLANES: tuple[str, ...] = (
    *("reach", "weakest_edge", "max_border", "max_gap", "min_strength", "sure_edge", "min_contrast", "min_length"),
    "edges",
)
"""Parameters that have a meaning in the plane only, and must have their default value in a volume."""

OF_VOLUMES: tuple[str, ...] = ("accuracy",)
"""Parameters that change nothing in an image."""

AUTOMATIC = ("smoothing", "gamma", "exponent")
"""Parameters whose value may also be ``"auto"``: it is then chosen from the image."""


def invalidating(*kinds: Invalidates) -> tuple[str, ...]:
    """Names of all parameters, numbers and choices, whose change makes one of `kinds` out of date."""
    numbers = [(name, info.invalidates) for name, info in PARAMETERS.items()]
    named = [(name, info.invalidates) for name, info in CHOICES.items()]
    return tuple(name for name, invalid in (*numbers, *named) if invalid in kinds)
