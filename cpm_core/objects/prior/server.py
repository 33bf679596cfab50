"""Answers of a server of nnInteractive in a volume: the volume and prompts go there, the voxels of a body come back."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import scipy

from cpm_core.field.start_area.drawn_area import MIN_DRAWN_PLACES, drawn_area, is_line
from cpm_core.numerics.types import Extent, Index, Mask, Numbers, Sides

_MAX_LINE_DEPTH = 2.0
"""Distance from the border of the area that a closed line encloses up to which a point belongs to the line [voxels]."""


class ServedVolume:
    """A volume that a server has received; it is released with this object.

    Parameters
    ----------
    address : str
        Address of the server.
    values : ndarray, shape (P, R, C)
        Gray levels.
    spacing : tuple of float
        Sides of a voxel.

    Raises
    ------
    ValueError
        When the server does not answer.
    """

    def __init__(self, address: str, values: Numbers, spacing: Sides) -> None:
        self._address, self._values, self._spacing = address, values, spacing
        self._lock = threading.Lock()
        self._session: Any = None

    def answer(self, inside: Index, outside: Index, lassos: Sequence[tuple[Mask, bool]], box: Index) -> Mask:
        """Answer positive and negative voxels, shape (M, 3) and (K, 3), by those of a body, shape (P, R, C).

        Many of one sign, as of a scribble, are sent as a mask, and so is the area that each lasso encloses, which the
        body is in or not. A `box` around the body, shape (2, 3) or empty, is sent as its middle slices, since the
        models know boxes in slices.
        """
        from httpx import HTTPError
        from nnInteractive.inference.remote import remote_session as client

        try:
            with self._lock:
                try:
                    return self._ask(self._session or self._send_volume(), inside, outside, lassos, box)
                except client.SessionExpiredError:
                    return self._ask(self._send_volume(), inside, outside, lassos, box)
        except (HTTPError, client.SessionExpiredError, client.ServerAtCapacityError) as error:
            raise ValueError(f"The server {self._address} does not answer: {error}") from None

    def _send_volume(self) -> Any:
        """Open a session with the server, and send the volume."""
        from nnInteractive.inference.remote import nnInteractiveRemoteInferenceSession

        self._session = session = nnInteractiveRemoteInferenceSession(self._address)
        weakref.finalize(self, session.close)
        session.set_image(self._values[None].astype(np.float32), {"spacing": list(self._spacing)})
        session.set_target_buffer(np.zeros(self._values.shape, np.uint8))
        return session

    def _ask(
        self, session: Any, inside: Index, outside: Index, lassos: Sequence[tuple[Mask, bool]], box: Index
    ) -> Mask:
        session.reset_interactions()
        for sides in _slice_box(box, self._values.shape):
            session.add_bbox_interaction(sides, True, run_prediction=False)
        for area, adds in lassos:
            session.add_lasso_interaction(area.astype(np.uint8), adds, run_prediction=False)
        for voxels, adds in ((inside, True), (outside, False)):
            if len(voxels) >= MIN_DRAWN_PLACES:
                drawn = np.zeros(self._values.shape, np.uint8)
                drawn[tuple(voxels.T)] = 1
                session.add_scribble_interaction(drawn, adds, run_prediction=False)
            else:
                for voxel in voxels.tolist():
                    session.add_point_interaction(voxel, adds, run_prediction=False)
        session._predict()
        return np.asarray(session.target_buffer > 0)


def _slice_box(box: Index, shape: Extent) -> Iterator[list[list[int]]]:
    """Slice a box through its middle across each axis; of one in a slice there is this slice alone."""
    if not len(box):
        return
    ends = np.clip([box.min(axis=0), box.max(axis=0)], 0, np.array(shape) - 1)
    flat = np.flatnonzero(ends[0] == ends[1])
    for axis in flat[:1] if len(flat) else range(3):
        sides = np.array([ends[0], ends[1] + 1]).T
        middle = int(ends[:, axis].sum()) // 2
        sides[axis] = middle, middle + 1
        yield sides.tolist()


def split_lassos(voxels: Index, shape: Extent) -> tuple[Index, list[Mask]]:
    """Split closed lines in slices off voxels, shape (N, 3): return the others, and the area in each line."""
    left, areas = np.ones(len(voxels), bool), []
    for axis in range(3):
        places, counts = np.unique(voxels[:, axis], return_counts=True)
        for place in places[counts >= MIN_DRAWN_PLACES].tolist():
            drawn = left & (voxels[:, axis] == place)
            line = np.delete(voxels[drawn], axis, axis=1)
            if len(line) < MIN_DRAWN_PLACES or (np.ptp(line, axis=0) == 0).any():
                continue
            across = drawn_area(line.astype(float), shape[:axis] + shape[axis + 1 :])
            if not is_line(across):
                enclosed = across.copy()
                enclosed[tuple(line.T)] = False
                parts, _ = scipy.ndimage.label(scipy.ndimage.distance_transform_edt(~across) <= _MAX_LINE_DEPTH)
                across &= np.isin(parts, parts[enclosed])  # clicks beside a closed line enclose nothing
                area = np.zeros(shape, bool)
                np.moveaxis(area, axis, 0)[place] = across
                areas.append(area)
                depth = scipy.ndimage.distance_transform_edt(across)[tuple(line.T)]
                left[np.flatnonzero(drawn)[(depth > 0.0) & (depth <= _MAX_LINE_DEPTH)]] = False
    return voxels[left], areas
