"""A session with all that a session can hold, on a small image; to be damaged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core import Parameters
from cpm_core.contours.hand_edits import HandEdit
from cpm_core.contours.review import Mark, Outline
from cpm_core.formats.sessions.beside_document import TruthFile
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, encode
from cpm_core.medial_axis.outlines import Outlined
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObject, SegmentedObjects
from cpm_core.shapes import (
    Barrier,
    Charge,
    Circle,
    Ellipse,
    Everywhere,
    Grid,
    Points,
    Polygon,
    Region,
    Stroke,
    Threshold,
)

SIDE = 40
IMAGE, TRUTH, SESSION = "disc.npy", "truth.npy", "damaged.cpm"
_CORNERS = ((4.0, 4.0), (4.0, 34.5), (34.0, 34.0), (33.0, 5.0))
_BOX = ((10.0, 10.0), (10.0, 20.0), (20.0, 20.0))


def write_images(folder: Path) -> None:
    """The image of the session, a bright disc, and its ground truth."""
    row, col = np.indices((SIDE, SIDE))
    disc = np.hypot(row - 0.5 * SIDE, col - 0.5 * SIDE) < 0.28 * SIDE
    np.save(folder / IMAGE, np.where(disc, 200.0, 20.0))
    np.save(folder / TRUTH, disc)


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
            Region(((1.0, 1.0), (1.0, 38.0), (38.0, 38.0), (38.0, 1.0))),
            Barrier(_CORNERS[:3]),
            Charge((12.0, 12.0), -1.5),
        ),
        parameters=Parameters(scales=2, smoothing="auto", max_gap=4.0),
        marks=(
            Mark((20.0, 9.0), "kept", "cell", "#e69f00", outline=Outline(_BOX, True, 3.0, 1)),
            Mark((9.0, 20.0), "rejected", features=(0.5,) * 8),
        ),
        hand_edits=(HandEdit(removed=((9.0, 20.0),)), HandEdit(added=_BOX, closed=True), HandEdit(added=_BOX[:2])),
        mode="contours",
        objects=SegmentedObjects(
            (
                SegmentedObject(
                    1, (Click(((20.0, 20.0),)),), (_BOX,), (_BOX[:2],), 0.5, 2.0, "a", "#0072b2", frozen=True
                ),
            ),
        ),
        outlined=Outlined((1,), (_BOX,)),
        view={"layers": {"particles": {"visible": True}}, "zoom": 2.0},
        extra={"later": [1, 2, {"a": None}]},
        truth=TruthFile(str(folder / TRUTH), tolerance=2.0),
    )
    plain: dict[str, Any] = json.loads(encode(session, folder))
    return plain
