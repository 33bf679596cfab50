"""Sessions with all that a session can hold, on a small image, a volume and a stack of pages; to be damaged."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import tifffile

from cpm_core import Parameters, Surface
from cpm_core.formats.common.json_values import shape_to_json
from cpm_core.formats.contours.contour_json import page_to_json
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, TruthFile, encode_session
from cpm_core.image.region import Region
from cpm_core.medial_axis.outlines import SkeletonTarget
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObject, SegmentedObjects
from cpm_core.pages.page import Page
from cpm_core.shapes import (
    Barrier,
    Box,
    BoxGrid,
    BoxRegion,
    BoxThreshold,
    Charge,
    Circle,
    Ellipse,
    EnclosedRegion,
    EnclosingWall,
    Everywhere,
    Grid,
    Points,
    Polygon,
    PolygonRegion,
    PrismRegion,
    Sphere,
    Stroke,
    Threshold,
    Wall,
)
from tests.core.formats.drawn import RESULT

SIDE = 40
IMAGE, TRUTH, SESSION, VOLUME, STACK = "disc.npy", "truth.npy", "damaged.cpm", "ball.npy", "stack.tif"
SHAPES: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {IMAGE: (SIDE, SIDE), VOLUME: (18, 19, 20), STACK: (SIDE, SIDE)}
)
"""Sizes of the images; that of the stack is the size of a page."""

PAGES = 3
_CORNERS = ((4.0, 4.0), (4.0, 34.5), (34.0, 34.0), (33.0, 5.0))
_BOX = ((10.0, 10.0), (10.0, 20.0), (20.0, 20.0))


_PLACES = np.array([(x, y, z) for z in (6, 12) for y in (6, 12) for x in (6, 12)], np.float32)
_SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
_FACES = np.array([(a, *pair) for a, b, c, d in _SIDES for pair in ((b, c), (c, d))])
_CUBE = Region.from_surface(Surface(_PLACES, _FACES))


def write_images(folder: Path) -> None:
    """The images of the sessions, a bright disc, a ball and discs on pages, and a ground truth."""
    row, col = np.indices((SIDE, SIDE))
    disc = np.hypot(row - 0.5 * SIDE, col - 0.5 * SIDE) < 0.28 * SIDE
    np.save(folder / IMAGE, np.where(disc, 200.0, 20.0))
    np.save(folder / TRUTH, disc)
    away = np.linalg.norm(np.indices(SHAPES[VOLUME]).T - 9.0, axis=-1).T
    np.save(folder / VOLUME, np.where(away < 6.0, 200.0, 20.0))
    pages = [np.where(np.roll(disc, page, axis=0), 200, 20) for page in range(PAGES)]
    tifffile.imwrite(folder / STACK, np.array(pages, np.uint8), photometric="minisblack")


def sample(folder: Path) -> dict[str, Any]:
    """The session as plain JSON."""
    session = SessionFile(
        image=ImageFile(str(folder / IMAGE), shape=(SIDE, SIDE)),
        shapes=(
            Circle((20.0, 20.0), 6.0),
            Ellipse((20.0, 18.0), (9.0, 5.0), 0.3),
            Polygon(_CORNERS),
            Stroke(_CORNERS[:2]),
            Points(_CORNERS),
            Grid(_CORNERS, 6.0),
            Threshold(_CORNERS, 0.4),
            Everywhere("grid"),
            PolygonRegion(((1.0, 1.0), (1.0, 38.0), (38.0, 38.0), (38.0, 1.0))),
            Barrier(_CORNERS[:3]),
            Charge((12.0, 12.0), -1.5),
        ),
        parameters=Parameters(scales=2, smoothing="auto", max_gap=4.0),
        mode="contours",
        objects=SegmentedObjects(
            (
                SegmentedObject(
                    1, (Click(((20.0, 20.0),)),), Region((_BOX,)), (_BOX[:2],), 0.5, 2.0, "a", "#0072b2", frozen=True
                ),
                SegmentedObject(2, (), name="cell", color="#e69f00", line=_BOX),
            ),
        ),
        outlined=SkeletonTarget((1,), (_BOX,)),
        view={"layers": {"particles": {"visible": True}}, "zoom": 2.0},
        extra={"later": [1, 2, {"a": None}]},
        truth=TruthFile(str(folder / TRUTH), tolerance=2.0),
    )
    return _plain(session, folder)


def sample_in_space(folder: Path) -> dict[str, Any]:
    """A session of a volume with all shapes that volumes have."""
    corners = ((9.0, 4.0, 4.0), (9.0, 4.0, 14.5), (9.0, 14.0, 14.0))
    session = SessionFile(
        image=ImageFile(str(folder / VOLUME), shape=SHAPES[VOLUME]),
        shapes=(
            Sphere((9.0, 9.0, 9.0), 4.0, (2.0, 1.0, 1.0)),
            Box((5.0, 5.0, 5.0), (12.0, 13.0, 12.5)),
            Stroke(corners),
            Polygon(corners),
            Points(corners),
            Everywhere("grid"),
            BoxRegion((1.0, 1.0, 1.0), (16.0, 17.0, 18.0)),
            PrismRegion(((1.0, 1.0), (1.0, 17.0), (17.0, 17.0)), 0, 1.0, 16.0),
            Wall(((4.0, 4.0), (4.0, 12.0)), 2, 3.0, 9.0),
            BoxGrid((5.0, 5.0, 5.0), (12.0, 13.0, 12.5), 3.0),
            BoxThreshold((5.0, 5.0, 5.0), (12.0, 13.0, 12.5), 0.4),
            EnclosedRegion(_CUBE),
            EnclosingWall(_CUBE),
            Charge((9.0, 9.0, 3.0), -1.5),
        ),
        objects=SegmentedObjects(
            (SegmentedObject(1, (Click(((9.0, 9.0, 9.0),)),), confidence=0.5, region=_CUBE, frozen=True),)
        ),
        parameters=Parameters(scales=1),
        view={"volume": {"at": [9, 9, 9], "axis": 1}},
    )
    return _plain(session, folder)


def sample_of_pages(folder: Path) -> dict[str, Any]:
    """A session of a stack: what is drawn on each of its pages, and what was found on one."""
    drawn = (Circle((20.0, 20.0), 6.0), Charge((12.0, 12.0), 1.0))
    page = SessionFile(shapes=drawn, parameters=Parameters(scales=2))
    found = page_to_json(Page(2, RESULT))
    pages = {
        "following": True,
        "drawn": [shape_to_json(shape) for shape in drawn],
        "given": True,
        "sessions": [{"page": 2, "given": True, "session": _plain(page, folder)}],
        "found": [found, {**found, "page": 3}],
    }
    image = ImageFile(str(folder / STACK), shape=SHAPES[STACK], reading=Reading(page=1))
    return _plain(replace(page, image=image, pages=pages), folder)


def _plain(session: SessionFile, folder: Path) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(encode_session(session, folder))
    return plain


SAMPLES: Mapping[str, Callable[[Path], dict[str, Any]]] = MappingProxyType(
    {IMAGE: sample, VOLUME: sample_in_space, STACK: sample_of_pages}
)
"""The sessions by the images that they belong to."""
