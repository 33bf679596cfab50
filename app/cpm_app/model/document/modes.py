"""Modes: purposes of a run, each with its preset and its starts; settings for kinds of images."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from cpm_app.model.document.document import Document, ImageReference, Mode
from cpm_app.model.parameters.controls import RATIO_CONTROL
from cpm_app.model.text.language import tr
from cpm_core import PRESETS, RUN_METHODS, Parameters
from cpm_core.medial_axis import SkeletonTarget
from cpm_core.numerics.types import frozen
from cpm_core.parameters import PLANE_PARAMETERS, VOLUME_PARAMETERS
from cpm_core.shapes import Everywhere, Limit, Measure, Shape


@frozen
class ModeInfo:
    """Texts and settings of a mode.

    Attributes
    ----------
    title, short : str
        Name in the menu, and on a button.
    about : str
        Its purpose, in a sentence.
    preset : str
        Name among the core's `PRESETS`.
    method : str
        Name among the core's `RUN_METHODS`.
    hint : str
        What to do next when everything is ready for a run, with the names of keys (see `insert_keys`); empty for the
        usual hint.
    """

    title: str
    short: str
    about: str
    preset: str
    method: str
    hint: str = ""


MODES: Mapping[Mode, ModeInfo] = {
    "shape": ModeInfo(
        tr("Shape &recovery"),
        tr("Shape"),
        tr("Finds the whole outline from a start that you draw."),
        "shape",
        "cpm",
    ),
    "automatic": ModeInfo(
        tr("&Automatic segmentation"),
        tr("Automatic"),
        tr("Finds all objects. No drawing needed."),
        "automatic",
        "cpm",
        tr("Press {key:run} to run; particles start everywhere."),
    ),
    "skeleton": ModeInfo(
        tr("S&keleton"),
        tr("Skeleton"),
        tr("Finds the center lines of objects and their thickness. No drawing needed."),
        "noisy",
        "skeleton",
        tr("Press {key:run} to find the skeleton of the objects in the image."),
    ),
    "published": ModeInfo(
        tr("As &published"),
        tr("As published"),
        tr("Runs the model of the publication, without what this program adds to it; it may not come to rest."),
        "published",
        "published",
    ),
}


_SKELETON_WIDTH = "max_width"
"""Parameter of skeletons that center lines in volumes lack."""


def initial_parameters(mode: Mode, image: ImageReference | None = None) -> Parameters:
    """Return the parameters with which work in a mode begins; on a volume those for volumes."""
    return PRESETS["volume" if image is not None and image.is_volume else MODES[mode].preset]


def needs_start(mode: Mode) -> bool:
    """Tell whether a run in a mode needs a start."""
    return RUN_METHODS[MODES[mode].method].seeded


def find_effective_controls(mode: Mode, dimension: int = 2) -> frozenset[str]:
    """Return the names of the controls that have an effect in a mode, on an image with `dimension` axes."""
    lacking = (*PLANE_PARAMETERS, _SKELETON_WIDTH) if dimension == 3 else VOLUME_PARAMETERS
    acting = (name for name in RUN_METHODS[MODES[mode].method].parameters if name not in lacking)
    return frozenset(RATIO_CONTROL if name == "w1" else name for name in acting)


def switch_mode(document: Document, mode: Mode) -> Document:
    """Switch to another mode, with its preset and its starts; channel, regions, barriers, charges and measures stay.

    Shape recovery removes starts all over the image; automatic segmentation removes all others; skeletons, which need
    no start, keep all shapes.
    """
    fresh = replace(initial_parameters(mode, document.image), channel=document.parameters.channel)
    shapes, parameters = adapt_shapes_to_mode(mode, document.shapes), document.fit_scales(fresh)
    return replace(document, mode=mode, shapes=shapes, parameters=parameters, outlined=SkeletonTarget())


def switch_to_skeleton(document: Document, outlined: SkeletonTarget) -> Document:
    """Switch to the mode of skeletons, for given objects and contours, or for the image if there are none."""
    there = document if document.mode == "skeleton" else switch_mode(document, "skeleton")
    return replace(there, outlined=outlined)


def adapt_shapes_to_mode(mode: Mode, shapes: tuple[Shape, ...]) -> tuple[Shape, ...]:
    """Return the shapes of a document after a change to this mode."""
    if mode == "automatic":
        return (*(shape for shape in shapes if isinstance(shape, Limit | Measure)), Everywhere("grid"))
    if mode == "shape":
        return tuple(shape for shape in shapes if not isinstance(shape, Everywhere))
    return shapes


PRESET_OFFERS = {
    "fluorescence": tr("Bright objects on a dark background: find all of them with settings for such images?"),
    "angiogram": tr("This looks like an X-ray image of vessels. Find all vessels with settings for them?"),
    "ultrasound": tr("This looks like an ultrasound image. Find strong outlines with settings for ultrasound?"),
}
"""Sentences that offer the preset for a kind of image; other kinds do best with the usual one."""
