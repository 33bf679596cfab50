"""Formulas and symbols of the parameters, whose names are in the table of the core."""

from __future__ import annotations

from cpm_app.model.text.language import tr

_FORCE_FORMULA = "<i>F</i> = <i>w</i>₁<i>F</i><sub>c</sub> + <i>w</i>₂<i>F</i><sub>l</sub> − <i>β</i> <i>v</i>"

PARAMETER_FORMULAS = {
    "reach": tr(
        "distance outside the area: {law}",
        law="∝ <i>r</i> <i>w</i>₁ / [(<i>w</i>₂ − <i>w</i>₁) (1 − <i>a</i>) <i>β</i>²]",
    ),
    "weakest_edge": tr(
        "holds particles where {law} around the area", law="<i>f</i> ≥ <i>f</i><sub>first</sub> · median <i>f</i>"
    ),
    "beta": _FORCE_FORMULA,
    "ratio": "<i>F</i> = <i>w</i>₂ [(<i>w</i>₁/<i>w</i>₂) <i>F</i><sub>c</sub> + <i>F</i><sub>l</sub>] − <i>β</i> "
    "<i>v</i>",
    "w2": _FORCE_FORMULA,
    "annealing": tr(
        "every step without a find nearby: {after} = {before}",
        after="<i>d</i><sub>max</sub>",
        before="<i>a</i> · <i>d</i><sub>max</sub>",
    ),
    "time_step": "<i>r</i>(<i>t</i> + Δ<i>t</i>) = <i>r</i> + <i>v</i> Δ<i>t</i> + "
    "<i>F</i> Δ<i>t</i>²/2 + <i>F</i>′ Δ<i>t</i>³/6",
    "d_min": tr("one of two is deleted where {law}", law="<i>d</i> &lt; <i>d</i><sub>min</sub> / 2"),
    "d_max": tr(
        "a particle is inserted where {law}",
        law="<i>d</i><sub>min</sub> &lt; <i>d</i> ≤ <i>d</i><sub>min</sub> + <i>d</i><sub>max</sub>",
    ),
    "smoothing": "<i>f</i> = |∇(<i>G</i><sub>σ</sub> ∗ <i>I</i>)|",
    "gamma": tr("{gray} over the range of the image, before {gradient}", gray="<i>I</i><sup>γ</sup>", gradient="∇"),
    "scales": "<i>I</i><sub>s+1</sub> = <i>I</i><sub>s</sub> ↓ 2, &nbsp;<i>s</i> = <i>S</i> − 1, …, 0",
    "edge_floor": tr(
        "charge {charge} only where {law}", charge="−<i>f</i>", law="<i>f</i> ≥ <i>f</i><sub>min</sub> · max <i>f</i>"
    ),
    "exponent": tr("force of a charge: {law}", law="<i>f</i> / <i>r</i><sup>n</sup>"),
    "max_border": tr("a border no wider than {law}", law="<i>m</i><sub>max</sub> · min(<i>H</i>, <i>W</i>)"),
    "max_gap": tr("loose ends joined where {law}", law="|<i>r</i>₁ − <i>r</i>₂| ≤ <i>g</i><sub>max</sub>"),
    "min_strength": tr("kept where {law}", law="mean <i>f</i> ≥ <i>s</i><sub>min</sub>"),
    "sure_edge": tr("kept with a part where {law}", law="<i>f</i> ≥ <i>f</i><sub>sure</sub> · max <i>f</i>"),
    "min_contrast": tr(
        "kept where {law}",
        law="|<i>m</i>₁ − <i>m</i>₂| / (|<i>m</i>₁ − <i>m</i>₂| + <i>s</i>) ≥ <i>c</i><sub>min</sub>",
    ),
    "min_length": tr("kept where {law}", law="<i>l</i> ≥ <i>l</i><sub>min</sub>"),
    "polarity": tr("kept where {law} on both sides", law="<i>p</i> · (∇<i>I</i> · <i>n</i>) &lt; 0"),
    "max_width": tr("kept where {law}", law="2 <i>r</i> ≤ <i>w</i><sub>max</sub>"),
    "pruning": tr("cut back where {law}", law="<i>d</i> + <i>r</i>₁ − <i>r</i>₂ ≤ <i>ρ</i>"),
}
"""Formulas as rich text, by the names of the controls."""


def format_symbol(symbol: str) -> str:
    """Format a symbol as rich text, with what follows its first ``_`` as a subscript."""
    head, _, foot = symbol.partition("_")
    return f"<i>{head}</i><sub>{foot}</sub>" if foot else f"<i>{head}</i>"
