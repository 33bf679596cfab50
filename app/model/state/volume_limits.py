"""What work on a volume lacks, in words: each action that acts on images only, with the sentence that says so."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from app.model.state.situation import Situation
from app.model.text.language import tr

_TOOL = tr("This tool draws on images; in a volume, start from spheres and points.")
_START = tr("Starts that need no drawing are for images; in a volume, start from spheres and points.")
_MODE = tr("This mode is for images; a volume is segmented from spheres and points.")
_CONTOUR = tr("Contours are found in images; a run in a volume finds a surface.")
_OBJECT = tr("Objects are selected in images; a run in a volume finds a surface.")
_TRUTH = tr("A ground truth can be compared with the contours of an image, not with a surface.")
_LAYER = tr("This layer shows images only.")
_COMPARE = tr("Results can be compared in images only.")
_FILM = tr("Pictures of many steps can be made of images only.")

NOT_IN_VOLUMES: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(
            ("eraser", "ellipse", "polygon", "stroke", "spray", "grid_area", "threshold", "region", "barrier",
             "attract", "repel"), _TOOL),
        **dict.fromkeys(("start_grid", "start_gradient", "start_centers"), _START),
        **dict.fromkeys(("mode_automatic", "mode_skeleton"), _MODE),
        **dict.fromkeys(
            ("contours", "edit_contours", "outline", "close_contours", "join_contours", "cut_contour", "image_skeleton",
             "contour_skeleton", "next_contour", "all_contours", "other_contours", "learn", "doubtful_contour",
             "show_rejected"), _CONTOUR),
        **dict.fromkeys(("objects", "object_skeleton", "all_objects", "fit_objects", "objects_alike"), _OBJECT),
        **dict.fromkeys(("load_truth", "worst_place", "next_place"), _TRUTH),
        **dict.fromkeys(
            tuple(f"layer_{name}" for name in ("trails", "forces", "objects", "ghost", "truth", "skeleton", "edge_map",
                                               "potential", "field")), _LAYER),
        **dict.fromkeys(("wipe", "keep_result", "mosaic", "compare_methods"), _COMPARE),
        **dict.fromkeys(("export_animation", "export_strip"), _FILM),
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
        "points": (tr("&Point tool"), tr("Click to place a point in the slice.")),
    }
)
"""Names of actions that do something else in a volume -> their text and tip there."""


def has_volume(situation: Situation) -> bool:
    """A volume is open."""
    image = situation.document.image
    return image is not None and len(image.shape) == 3
