"""Every numeric parameter: symbol, unit, range, meaning, and what a change invalidates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from cpm_core.parameters.choices import CHOICE_PARAMETERS, Invalidates


@dataclass(frozen=True)
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
    effect_of_larger : str
        One sentence: the effect of a larger value.
    invalidates : {"nothing", "contours", "field", "run"}
        What a change makes out of date: nothing (the next step uses the value), the contours but not the particles, the
        edge map and field, or the whole run.
    equation : str
        Place in the published model; empty for parameters that the model does not have.
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
    effect_of_larger: str
    invalidates: Invalidates
    equation: str = ""
    advanced: bool = False


UNLIMITED_REACH = 300.0
"""`Parameters.reach` at which there is no limit: a front creeps along every connected edge [px]."""

_PARAMETER_TABLE = (
    ParameterInfo(
        "reach", "r", "px", 0.0, UNLIMITED_REACH, 0.0, UNLIMITED_REACH, 1.0, "Reach",
        "How far particles creep along edges that lead out of the area of their start, at the default damping, weights "
        f"and annealing; {UNLIMITED_REACH:g} means no area and no limit.",
        "Larger values include neighboring structures.",
        "nothing",
    ),
    ParameterInfo(
        "weakest_edge", "f_first", "", 0.0, 0.95, 0.0, 0.95, 0.01, "Weakest edge",
        "Edges weaker than this fraction of those around the area of the start hold no particles; it acts only with a "
        "limited reach.",
        "Larger values leave out more of the weak edges.",
        "field",
    ),
    ParameterInfo(
        "beta", "β", "", 0.0, 4.0, 0.1, 2.0, 0.05, "Damping",
        "Friction that slows the particles down.",
        "Smaller values make particles faster, carry them across weak edges and let them creep farther from their "
        "start, so that they find more.",
        "nothing", "eq. (12)",
    ),
    ParameterInfo(
        "w1", "w₁", "", 0.0, 100.0, 0.05, 3.0, 0.05, "Repulsion",
        "Weight of the repulsion between particles, the Coulomb force; it must stay below w₂.",
        "Larger values push particles faster along edges, deeper into bays and farther from their start.",
        "nothing", "eq. (12)",
    ),
    ParameterInfo(
        "w2", "w₂", "", 0.001, 100.0, 0.1, 3.0, 0.05, "Attraction",
        "Weight of the attraction by the edges of the image, the Lorentz force; it must stay above w₁.",
        "Larger values pull particles to edges harder and hold them there.",
        "nothing", "eq. (12)", True,
    ),
    ParameterInfo(
        "annealing", "a", "", 0.0, 1.0, 0.9, 1.0, 0.001, "Annealing",
        "Factor by which the insertion range of a particle shrinks at every step in which nothing new is found near "
        "it.",
        "Larger values insert particles for longer and let them creep farther from their start, at 1 without end.",
        "nothing", "section 3.6",
    ),
    ParameterInfo(
        "time_step", "Δt", "", 0.01, 1.0, 0.05, 1.0, 0.05, "Time step",
        "Time between two steps of a run.",
        "Larger values move particles farther in each step; too large ones make them miss edges.",
        "nothing", "eq. (14)", True,
    ),
    ParameterInfo(
        "d_min", "d_min", "px", 0.5, 20.0, 1.0, 6.0, 0.1, "Particle spacing",
        "Distance between neighbors; of two particles closer than half of it, one is deleted.",
        "Larger values give fewer particles and coarser contours.",
        "nothing", "section 3.6", True,
    ),
    ParameterInfo(
        "d_max", "d_max,0", "px", 0.0, 50.0, 0.0, 10.0, 0.1, "Insertion range",
        "Two neighbors on edges, farther apart than the particle spacing by at most this, get a particle between them; "
        "annealing shrinks it.",
        "Larger values insert particles between neighbors that are farther apart.",
        "nothing", "section 3.6", True,
    ),
    ParameterInfo(
        "smoothing", "σ", "px", 0.0, 20.0, 0.5, 8.0, 0.1, "Smoothing",
        "Width of the Gaussian filter that smooths the image before its edges are found.",
        "Larger values remove noise and texture, and round corners.",
        "field", "section 3.1",
    ),
    ParameterInfo(
        "gamma", "γ", "", 0.1, 4.0, 0.2, 2.0, 0.05, "Gamma",
        "Exponent applied to the gray levels, over their range in the image, before edges are found.",
        "Values below 1 strengthen edges between dark gray levels, values above 1 those between bright ones.",
        "field", advanced=True,
    ),
    ParameterInfo(
        "scales", "S", "", 1, 8, 1, 5, 1, "Scales",
        "Number of scales of the image, each half the size of the one before; a run goes from coarse to fine.",
        "Larger values find large objects sooner and ignore finer noise on the way.",
        "run", "section 4.2", True,
    ),
    ParameterInfo(
        "edge_floor", "f_min", "", 0.0, 0.99, 0.0, 0.6, 0.01, "Edge floor",
        "Fraction of the largest edge strength below which no fixed charge is placed; at 0 all are placed, and the "
        "strength of the background decides which edges are too weak.",
        "Larger values leave out weak edges and texture.",
        "field",
    ),
    ParameterInfo(
        "exponent", "n", "", 1.0, 8.0, 1.0, 6.0, 0.1, "Exponent",
        "Power of the distance with which the force of a fixed charge decays; automatically the number of dimensions, "
        "2 in an image and 3 in a volume.",
        "Larger values attract particles to the nearest edges, smaller ones to where many edges are, however far away.",
        "field", "eq. (8)", True,
    ),
    ParameterInfo(
        "max_border", "m_max", "", 0.0, 0.25, 0.0, 0.2, 0.01, "Maximum border",
        "A dark or bright rim of the image up to this width, as a fraction of its shorter side, counts as its border; "
        "its edge is left out.",
        "Larger values find wider borders; 0 keeps every edge.",
        "field", advanced=True,
    ),
    ParameterInfo(
        "max_gap", "g_max", "px", 0.0, 1e4, 0.0, 60.0, 1.0, "Maximum gap",
        "Distance up to which loose ends of contours are joined across a gap, along the edge map.",
        "Larger values bridge wider gaps; at 0 real gaps stay open.",
        "contours",
    ),
    ParameterInfo(
        "min_strength", "s_min", "gray/px", 0.0, 1e9, 0.0, 60.0, 0.5, "Minimum strength",
        "Mean edge strength below which a contour, or a part of one with a loose end, is left out.",
        "Larger values keep only the contours of strong edges.",
        "contours",
    ),
    ParameterInfo(
        "sure_edge", "f_sure", "", 0.0, 0.99, 0.0, 0.6, 0.01, "Sure edge",
        "Fraction of the largest edge strength below which a contour is kept only if it is connected to one above it.",
        "Larger values leave out isolated weak contours and keep those that continue strong ones.",
        "contours", advanced=True,
    ),
    ParameterInfo(
        "min_contrast", "c_min", "", 0.0, 0.99, 0.0, 0.9, 0.01, "Minimum contrast",
        "Contrast of the regions on both sides, from 0 for equal ones to 1 for uniform ones, below which a contour, or "
        "a part of one with a loose end, is left out.",
        "Larger values leave out texture, which looks the same on both sides of an edge.",
        "contours", advanced=True,
    ),
    ParameterInfo(
        "min_length", "l_min", "px", 0.0, 1e9, 0.0, 200.0, 1.0, "Minimum length",
        "Length below which a contour is left out.",
        "Larger values remove specks and fragments.",
        "contours",
    ),
    ParameterInfo(
        "polarity", "p", "", -1.0, 1.0, -1.0, 1.0, 1.0, "Dark or light",
        "What has a skeleton: below 0 what is darker than its surroundings, above 0 what is lighter; at 0 the image "
        "decides.",
        "Larger values go from dark to light objects.",
        "contours",
    ),
    ParameterInfo(
        "max_width", "w_max", "px", 0.0, 1e4, 0.0, 100.0, 0.5, "Maximum width",
        "Width above which a part has no skeleton; at 0 any width counts where the outlines are closed, and otherwise "
        "the widths in the image decide.",
        "Larger values include wider parts.",
        "contours",
    ),
    ParameterInfo(
        "pruning", "ρ", "px", 0.0, 1e3, 0.0, 10.0, 0.1, "Pruning",
        "How far a part of a shape may extend beyond the rest without a branch of the skeleton of its own.",
        "Larger values leave fewer and shorter branches.",
        "contours", "section 5.3",
    ),
)  # fmt: skip

PARAMETERS = {info.name: info for info in _PARAMETER_TABLE}
"""Description of every numeric parameter, by name."""

SKELETON_PARAMETERS = ("polarity", "max_width", "pruning")
"""Parameters that only skeletons depend on."""

START_PARAMETERS = ("reach", "weakest_edge")
"""Parameters that matter only with a start."""

CHARGE_PARAMETERS = ("exponent", "accuracy")
"""Parameters that matter only with particles: they act on the field of the fixed charges alone."""

PLANE_PARAMETERS = (
    *("reach", "weakest_edge", "max_border", "max_gap", "min_strength", "sure_edge", "min_contrast", "min_length"),
    "edges",
)
"""Parameters that are meaningful only in an image; in a volume they must have their default value."""

VOLUME_PARAMETERS = ("accuracy",)
"""Parameters that have no effect on an image."""

AUTOMATIC_PARAMETERS = ("smoothing", "gamma", "exponent")
"""Parameters whose value may also be ``"auto"``, which derives it from the image."""


@cache
def find_invalidating(*kinds: Invalidates) -> tuple[str, ...]:
    """Return the names of all parameters, numbers and choices, whose change makes one of `kinds` out of date."""
    numbers = [(name, info.invalidates) for name, info in PARAMETERS.items()]
    named = [(name, info.invalidates) for name, info in CHOICE_PARAMETERS.items()]
    return tuple(name for name, invalid in (*numbers, *named) if invalid in kinds)
