"""Pictures of the library and the gallery have the colors of the window's canvas."""

import pytest
from cpm_app.views.theme import theme


def luminance(color):
    """Relative luminance after WCAG 2."""
    red, green, blue = (
        value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
        for value in (int(color[at : at + 2], 16) / 255 for at in (1, 3, 5))
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one, other):
    """Contrast ratio of two colors after WCAG 2."""
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_contrast_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


TEXT_ON = (
    *(("text", ground) for ground in ("window", "panel", "base", "button", "chosen")),
    *(("dim", ground) for ground in ("window", "panel", "base", "button")),
    *(("accent", ground) for ground in ("window", "panel")),  # headings that have the focus
    *(("accent_hover", ground) for ground in ("window", "panel", "base")),  # links
    ("accent_text", "accent"),
    ("accent_text", "accent_hover"),
    ("error_text", "error"),
    ("message_text", "message"),
)


@pytest.mark.parametrize("used", [theme.LIGHT_THEME, theme.DARK_THEME], ids=["light", "dark"])
@pytest.mark.parametrize(("text", "ground"), TEXT_ON)
def test_text_can_be_read_on_its_background(used, text, ground):
    assert contrast(used[text], used[ground]) >= 4.5


def test_marks_on_the_canvas_are_seen_on_its_background():
    marks = {
        name: color
        for name, color in vars(theme).items()
        if name.isupper()
        and isinstance(color, str)
        and name not in ("CANVAS_COLOR", "CANVAS_HALO_COLOR")
        and len(color) == 7
    }
    assert {"CONTOUR_COLOR", "PROPOSAL_COLOR", "UNKNOWN_COLOR", "ATTRACTING_COLOR"} <= marks.keys()
    assert {name: color for name, color in marks.items() if contrast(color, theme.CANVAS_COLOR) < 3.0} == {}


def seen(color, kind):
    """A color as it is seen without one of the three receptors (simulation of Viénot, Brettel and Mollon, 1999)."""
    rgb = [(int(color[at : at + 2], 16) / 255) ** 2.2 for at in (1, 3, 5)]
    long = 17.8824 * rgb[0] + 43.5161 * rgb[1] + 4.11935 * rgb[2]
    medium = 3.45565 * rgb[0] + 27.1554 * rgb[1] + 3.86714 * rgb[2]
    short = 0.0299566 * rgb[0] + 0.184309 * rgb[1] + 1.46709 * rgb[2]
    if kind == "protan":
        long = 2.02344 * medium - 2.52581 * short
    else:
        medium = 0.494207 * long + 1.24827 * short
    return (
        max(0.0, 0.0809444479 * long - 0.130504409 * medium + 0.116721066 * short) ** (1 / 2.2),
        max(0.0, -0.0102485335 * long + 0.0540193266 * medium - 0.113614708 * short) ** (1 / 2.2),
        max(0.0, -0.000365296938 * long - 0.00412161469 * medium + 0.693511405 * short) ** (1 / 2.2),
    )


@pytest.mark.parametrize("kind", ["protan", "deutan"])
@pytest.mark.parametrize(
    "pair",
    [("moving", "resting"), ("contour", "proposal"), ("proposal", "moving"), ("region", "barrier")],
)
def test_colors_of_data_can_be_distinguished_by_color_blind_users(kind, pair):
    one, other = (seen(getattr(theme, f"{name.upper()}_COLOR"), kind) for name in pair)
    assert sum((a - b) ** 2 for a, b in zip(one, other, strict=True)) ** 0.5 > 0.2
