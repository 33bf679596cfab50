"""Two wordings of the parameters: plain words for the effect of a slider, or names and symbols of the formulas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, cast, get_args

from app.model.text.language import tr

Wording = Literal["intuitive", "formula"]

FIRST_WORDING: Wording = "intuitive"


def wording_called(name: str) -> Wording:
    """The wording of this name; the first one if there is none."""
    return cast("Wording", name) if name in get_args(Wording) else FIRST_WORDING


@dataclass(frozen=True, slots=True)
class Words:
    """Label of a control in plain words, and its formula as rich text."""

    plain: str
    formula: str


_FORCES = "<i>F</i> = <i>w</i>₁<i>F</i><sub>c</sub> + <i>w</i>₂<i>F</i><sub>l</sub> − <i>β</i> <i>v</i>"

WORDS: Mapping[str, Words] = MappingProxyType(
    {
        "reach": Words(tr("Reach beyond the object"), tr("over junctions at most {law}, in those of the paper").format(
            law="<i>r</i> · [<i>w</i>₁/(<i>w</i>₂ − <i>w</i>₁)] / (1 − <i>a</i>)")),
        "weakest_edge": Words(tr("As strong as around the start"), tr("reached where {law}").format(
            law="<i>f</i> ≥ <i>f</i><sub>first</sub> · median <i>f</i> around the start")),
        "beta": Words(tr("Calm the particles"), _FORCES),
        "ratio": Words(
            tr("Push into bays"),
            "<i>F</i> = <i>w</i>₂ [(<i>w</i>₁/<i>w</i>₂) <i>F</i><sub>c</sub> + <i>F</i><sub>l</sub>] − <i>β</i> "
            "<i>v</i>",
        ),
        "w2": Words(tr("Pull to edges"), _FORCES),
        "annealing": Words(tr("Keep filling gaps"), tr("every step: {after} = {before}").format(
            after="<i>d</i><sub>max</sub>", before="<i>a</i> · <i>d</i><sub>max</sub>")),
        "time_step": Words(tr("Length of a stride"), "<i>r</i>(<i>t</i> + Δ<i>t</i>) = <i>r</i> + <i>v</i> Δ<i>t</i> + "
                           "<i>F</i> Δ<i>t</i>²/2 + <i>F</i>′ Δ<i>t</i>³/6"),
        "d_min": Words(tr("Space between particles"), tr("one of two goes where {law}").format(
            law="<i>d</i> &lt; <i>d</i><sub>min</sub> / 2")),
        "d_max": Words(tr("Gaps that are filled"), tr("a new one where {law}").format(
            law="<i>d</i><sub>min</sub> &lt; <i>d</i> ≤ <i>d</i><sub>min</sub> + <i>d</i><sub>max</sub>")),
        "smoothing": Words(tr("Blur beforehand"), "<i>f</i> = |∇(<i>G</i><sub>σ</sub> ∗ <i>I</i>)|"),
        "gamma": Words(tr("Weigh dark and bright"), tr("{gray} over the range of the image, before {gradient}").format(
            gray="<i>I</i><sup>γ</sup>", gradient="∇")),
        "scales": Words(tr("Coarse scales first"), "<i>I</i><sub>s+1</sub> = <i>I</i><sub>s</sub> ↓ 2, &nbsp;"
                        "<i>s</i> = <i>S</i> − 1, …, 0"),
        "edge_floor": Words(tr("Ignore faint edges"), tr("charge {charge} only where {law}").format(
            charge="−<i>f</i>", law="<i>f</i> ≥ <i>f</i><sub>min</sub> · max <i>f</i>")),
        "max_border": Words(tr("Ignore a border"), tr("a border no wider than {law}").format(
            law="<i>m</i><sub>max</sub> · min(<i>H</i>, <i>W</i>)")),
        "max_gap": Words(tr("Bridge gaps"), tr("loose ends joined where {law}").format(
            law="|<i>r</i>₁ − <i>r</i>₂| ≤ <i>g</i><sub>max</sub>")),
        "min_strength": Words(tr("Drop weak contours"), tr("kept where {law}").format(
            law="mean <i>f</i> ≥ <i>s</i><sub>min</sub>")),
        "sure_edge": Words(tr("Weak only beside strong"), tr("kept with a part where {law}").format(
            law="<i>f</i> ≥ <i>f</i><sub>sure</sub> · max <i>f</i>")),
        "min_contrast": Words(tr("Drop texture"), tr("kept where {law}").format(
            law="|<i>m</i>₁ − <i>m</i>₂| / (|<i>m</i>₁ − <i>m</i>₂| + <i>s</i>) ≥ <i>c</i><sub>min</sub>")),
        "min_length": Words(tr("Drop short contours"), tr("kept where {law}").format(
            law="<i>l</i> ≥ <i>l</i><sub>min</sub>")),
        "polarity": Words(tr("Dark or light"), tr("kept where {law} on both sides").format(
            law="<i>p</i> · (∇<i>I</i> · <i>n</i>) &lt; 0")),
        "max_width": Words(tr("Leave out what is wider"), tr("kept where {law}").format(
            law="2 <i>r</i> ≤ <i>w</i><sub>max</sub>")),
        "pruning": Words(tr("Cut short branches"), tr("cut back where {law}").format(
            law="<i>d</i> + <i>r</i>₁ − <i>r</i>₂ ≤ <i>ρ</i>")),
    }
)  # fmt: skip
"""By the names of the controls."""


def rich(symbol: str) -> str:
    """A symbol as rich text: what follows its first ``_`` is a subscript."""
    head, _, foot = symbol.partition("_")
    return f"<i>{head}</i><sub>{foot}</sub>" if foot else f"<i>{head}</i>"
