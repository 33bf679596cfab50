"""What work on a volume lacks, in words: each action that acts on images only, with the sentence that says so."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from app.model.state.situation import Situation
from app.model.text.language import tr

_CONTOUR = tr("Contours are found in images; a run in a volume finds a surface.")
_BRUSH = tr("Objects are painted in images; in a volume they are bodies that a surface encloses.")
_ALIKE = tr("Objects that are alike are found in images by their gray values and size, not in volumes.")
_METHODS = tr("In a volume methods are compared by cpm compare VOLUME --sphere PLANE,ROW,COL,RADIUS.")
_MOSAIC = tr("A mosaic shows runs with different parameters side by side; in a volume each of them takes too long.")
_BATCH = tr("Many images are run at once; volumes are run one by one.")

NOT_IN_VOLUMES: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(
            ("contours", "edit_contours", "outline", "close_contours", "join_contours", "cut_contour",
             "contour_skeleton", "next_contour", "all_contours", "other_contours",
             "show_rejected"), _CONTOUR),
        "brush": _BRUSH,
        "objects_alike": _ALIKE,
        "mosaic": _MOSAIC,
        "compare_methods": _METHODS,
        "apply_to_folder": _BATCH,
    }
)  # fmt: skip
"""Names of actions and of tools -> why they are not offered while a volume is open."""


OTHERWISE_IN_VOLUMES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "circle": (tr("Sphe&re tool"), tr("Drag from the center to draw a sphere.")),
        "add_circle": (
            tr("Add sphere in the &middle"),
            tr("Add a sphere in the middle of the visible part of the slice."),
        ),
        "ellipse": (
            tr("Bo&x tool"),
            tr("Drag from corner to corner to draw a box, as deep as its shorter side; Shift makes it a square."),
        ),
        "grid_area": (
            tr("&Grid tool"),
            tr("Drag a box, as deep as its shorter side, to fill with an even grid; < and > change its spacing."),
        ),
        "threshold": (
            tr("T&hreshold tool"),
            tr(
                "Drag a box, as deep as its shorter side, in which to start on strong edges; < and > change how strong."
            ),
        ),
        "points": (tr("&Point tool"), tr("Click to place a point in the slice.")),
        "import_contours": (
            tr("&Import surface…"),
            tr("Read a surface, labels or center lines, as a start, as objects or as ground truth."),
        ),
        "region": (
            tr("Region of &interest tool"),
            tr("Drag a box, or click corner by corner around what particles are to stay in, through all slices."),
        ),
        "barrier": (
            tr("&Barrier tool"),
            tr("Drag, or click corner by corner, where no particle is to cross, through all slices."),
        ),
    }
)
"""Names of actions that do something else in a volume -> their text and tip there."""

ICONS_IN_VOLUMES: Mapping[str, str] = MappingProxyType({"ellipse": "box"})
"""Names of actions with another icon in a volume -> its name."""


def has_volume(situation: Situation) -> bool:
    """A volume is open."""
    return situation.document.is_about_volume
