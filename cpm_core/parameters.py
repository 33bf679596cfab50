"""The parameters of the charged-particle model, each defined once.

`Parameters` holds the values; `PARAMETERS` describes every field: its symbol, unit, range and meaning, and what a
change of it makes out of date. The window's sliders, the command line's flags and the error messages are all made from
it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, cast

Invalidates = Literal["nothing", "contours", "field", "run"]


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

    @property
    def default(self) -> float | str:
        """Default value of the parameter."""
        return DEFAULTS[self.name]


UNLIMITED_REACH = 300.0
"""`Parameters.reach` at which there is no limit: a front creeps along every edge that is connected to its own [px]."""

_TABLE = (
    ParameterInfo(
        "reach", "r", "px", 0.0, UNLIMITED_REACH, 0.0, UNLIMITED_REACH, 1.0, "Reach",
        "How far particles creep beyond a junction, away from the edges around the start that they reach on their own "
        "flight; at 300 there is no limit.",
        "More of it finds what is connected to the object, and at last everything.",
        "", "field", False,
    ),
    ParameterInfo(
        "weakest_edge", "f_first", "", 0.0, 0.95, 0.0, 0.95, 0.01, "Weakest edge",
        "Fraction of the strength of the edges around the start under which an edge does not hold particles; above 0 "
        "an edge around the start must also rise in the same sense as most of them.",
        "More of it leaves out what is weaker than the edges first met.",
        "", "field", False,
    ),
    ParameterInfo(
        "beta", "β", "", 0.0, 4.0, 0.1, 2.0, 0.05, "Damping",
        "Friction that takes speed out of the particles.",
        "More of it calms the particles sooner and keeps them near the first edges they meet; "
        "less lets them coast across weak edges.",
        "eq. (12)", "nothing", False,
    ),
    ParameterInfo(
        "w1", "w₁", "", 0.0, 100.0, 0.05, 3.0, 0.05, "Coulomb weight",
        "Weight of the repulsion between particles.",
        "More of it spreads the particles faster along edges and into bays; it must stay below w₂.",
        "eq. (12)", "nothing", False,
    ),
    ParameterInfo(
        "w2", "w₂", "", 0.001, 100.0, 0.1, 3.0, 0.05, "Lorentz weight",
        "Weight of the attraction by the edges of the image.",
        "More of it pulls the particles harder to edges and holds them there; it must stay above w₁.",
        "eq. (12)", "nothing", True,
    ),
    ParameterInfo(
        "annealing", "a", "", 0.0, 1.0, 0.9, 1.0, 0.001, "Annealing factor",
        "Factor by which the largest gap that a new particle fills shrinks at every step.",
        "More of it (nearer to 1) keeps particles being inserted longer, for denser rows along the edges.",
        "section 3.6", "nothing", False,
    ),
    ParameterInfo(
        "time_step", "Δt", "", 0.01, 1.0, 0.05, 1.0, 0.05, "Time step",
        "Time that one step advances the particles by.",
        "More of it moves the particles faster, until they overshoot the edges.",
        "eq. (14)", "nothing", True,
    ),
    ParameterInfo(
        "d_min", "d_min", "px", 0.5, 20.0, 1.0, 6.0, 0.1, "Smallest distance",
        "Spacing of the particles: two nearer than half of it become one.",
        "More of it gives fewer particles and coarser contours.",
        "section 3.6", "nothing", True,
    ),
    ParameterInfo(
        "d_max", "d_max,0", "px", 0.0, 50.0, 0.0, 10.0, 0.1, "Insertion range",
        "Two neighbors at rest on an edge, farther apart than d_min by at most this, get a particle between them; "
        "it shrinks by the annealing factor.",
        "More of it fills wider gaps.",
        "section 3.6", "nothing", True,
    ),
    ParameterInfo(
        "smoothing", "σ", "px", 0.0, 20.0, 0.5, 8.0, 0.1, "Smoothing",
        "Width of the Gaussian that smooths the image before its edges are taken.",
        "More of it quiets noise and texture, and rounds corners.",
        "section 3.1", "field", True,
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
        "background decides what is too weak for an edge.",
        "More of it leaves out weak edges and texture.",
        "", "field", True,
    ),
    ParameterInfo(
        "max_border", "m_max", "", 0.0, 0.25, 0.0, 0.2, 0.01, "Widest border",
        "A dark or bright rim of the image up to this wide, as a fraction of its shorter side, counts as its border, "
        "whose edge is left out.",
        "More of it finds wider borders; 0 leaves every edge in.",
        "", "field", True,
    ),
    ParameterInfo(
        "max_gap", "g_max", "px", 0.0, 1e4, 0.0, 60.0, 1.0, "Widest gap",
        "Distance up to which loose ends of contours are joined across a gap, along the edge map.",
        "More of it bridges wider gaps; at 0 real gaps stay open.",
        "", "contours", True,
    ),
    ParameterInfo(
        "min_strength", "s_min", "gray/px", 0.0, 1e9, 0.0, 60.0, 0.5, "Least strength",
        "Mean edge strength under which a contour, or a part of one with a loose end, is left out.",
        "More of it keeps only the contours of strong edges.",
        "", "contours", True,
    ),
    ParameterInfo(
        "sure_edge", "f_sure", "", 0.0, 0.99, 0.0, 0.6, 0.01, "Sure edge",
        "Fraction of the largest edge strength under which a contour stays only if it is connected to one above it.",
        "More of it leaves out weak contours by themselves and keeps those that continue strong ones.",
        "", "contours", True,
    ),
    ParameterInfo(
        "min_contrast", "c_min", "", 0.0, 0.99, 0.0, 0.9, 0.01, "Least contrast",
        "Contrast of the regions on both sides, from 0 for equal ones to 1 for uniform ones, under which a contour, or "
        "a part of one with a loose end, is left out.",
        "More of it leaves out texture, whose edges have the same on both sides.",
        "", "contours", True,
    ),
    ParameterInfo(
        "min_length", "l_min", "px", 0.0, 1e9, 0.0, 200.0, 1.0, "Least length",
        "Length under which a contour is left out.",
        "More of it drops specks and fragments.",
        "", "contours", True,
    ),
)  # fmt: skip

PARAMETERS: dict[str, ParameterInfo] = {info.name: info for info in _TABLE}

FORMER_NAMES: dict[str, str] = {"max_frame": "max_border"}
"""Names of parameters in older files and on older command lines -> their present names."""


@dataclass(frozen=True, slots=True)
class Parameters:
    """Parameters of a run; the defaults are the paper's (section 4.1). `PARAMETERS` has the range of each.

    Parameters
    ----------
    reach : float
        Distance that particles creep beyond a junction, away from the edges that bound the start, at the paper's
        weights and annealing [px]; at `UNLIMITED_REACH` every connected edge is reached.
    weakest_edge : float
        Edges weaker than this fraction of those that bound the start are not reached.
    beta : float
        Damping coefficient β of eq. (12).
    w1 : float
        Weight of the Coulomb force, eq. (12).
    w2 : float
        Weight of the Lorentz force, eq. (12); larger than `w1`, since the repulsion on a curved contour has unit size
        outward and only a stronger attraction holds the particles on the edge.
    annealing : float
        Annealing factor a: ``d_max`` is multiplied by it at every step.
    time_step : float
        Δt of eq. (14).
    d_min : float
        Spacing of particles [px]; of two nearer than half of it, one is deleted.
    d_max : float
        Range beyond `d_min` in which a gap is filled, at the start of each scale [px].
    smoothing : float or "auto"
        Standard deviation σ of the Gaussian before the gradient [px], or ``"auto"`` to choose it from the image's
        noise.
    scales : int
        Number of scales.
    edge_floor : float
        Fraction of the largest edge strength below which no fixed charge is placed.
    max_border : float
        Largest width of the image border, as a fraction of the shorter side; 0 for no border.
    max_gap : float
        Loose ends of contours up to this far apart are joined along the edge map [px]; at 0 gaps stay open.
    min_strength : float
        Contours of a lower mean edge strength are left out, and such parts of contours with a loose end [gray levels /
        px].
    sure_edge : float
        Contours whose edge strength is below this fraction of the largest stay only if they are connected to a stronger
        one.
    min_contrast : float
        Contours between regions of a lower contrast are left out, and such parts of contours with a loose end.
    min_length : float
        Shorter contours are left out [px].

    Raises
    ------
    ValueError
        When a value lies outside its range; the message names the field, the value and the range.
    """

    reach: float = UNLIMITED_REACH
    weakest_edge: float = 0.0
    beta: float = 0.8
    w1: float = 1.6
    w2: float = 1.75
    annealing: float = 0.99
    time_step: float = 0.5
    d_min: float = 2.0
    d_max: float = 3.0
    smoothing: float | Literal["auto"] = 1.0
    scales: int = 3
    edge_floor: float = 0.0
    max_border: float = 0.0
    max_gap: float = 0.0
    min_strength: float = 0.0
    sure_edge: float = 0.0
    min_contrast: float = 0.0
    min_length: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            _check(PARAMETERS[field.name], getattr(self, field.name))
        if not self.w2 > self.w1:
            raise ValueError(
                f"w2 is {self.w2:g} but must be above w1, which is {self.w1:g}: "
                "otherwise repulsion tears the particles off the edges."
            )

    @property
    def steering(self) -> tuple[object, ...]:
        """Values that the motion of the particles depends on: all but those for the start and the contours."""
        acting = (name for name, info in PARAMETERS.items() if info.invalidates in ("nothing", "field"))
        return tuple(getattr(self, name) for name in acting)


def _check(info: ParameterInfo, value: object) -> None:
    """Raise a `ValueError` that names field, value and range unless `value` fits."""
    if info.name == "smoothing" and value == "auto":
        return
    whole = info.name == "scales"
    fits = isinstance(value, (int, float)) and not isinstance(value, bool) and info.low <= value <= info.high
    if not fits or (whole and value != int(cast("float", value))):
        kind = "a whole number" if whole else "a number"
        words = f"{kind} from {info.low:g} to {info.high:g}" + (' or "auto"' if info.name == "smoothing" else "")
        shown = f"{value:g}" if isinstance(value, float) else repr(value)
        raise ValueError(f"{info.name} is {shown} but must be {words}.")


DEFAULTS: dict[str, float | str] = {name: getattr(Parameters(), name) for name in PARAMETERS}
"""The default value of every parameter: the paper's."""

PRESETS: dict[str, Parameters] = {
    "shape": Parameters(reach=2.0, weakest_edge=0.5),
    "automatic": Parameters(w1=0.6, w2=0.7, beta=0.4, smoothing=2.5, edge_floor=0.2, max_border=0.08, sure_edge=0.3),
    "noisy": Parameters(smoothing="auto"),
}
"""Named settings: shape recovery (section 4.1), automatic segmentation (section 5.2), and noisy images."""
