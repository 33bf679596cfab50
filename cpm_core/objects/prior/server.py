"""Answers of a server of nnInteractive in a volume: the volume and points go there, the voxels of a body come back."""

from __future__ import annotations

import threading
import weakref
from typing import Any

import numpy as np

from cpm_core.field.start_area.drawn_area import MIN_DRAWN_PLACES
from cpm_core.numerics.types import Index, Mask, Numbers, Sides


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

    def answer(self, inside: Index, outside: Index) -> Mask:
        """Answer positive and negative voxels, shape (M, 3) and (K, 3), by those of a body, shape (P, R, C).

        Many of one sign, as of a scribble, are sent as a mask.
        """
        from httpx import HTTPError
        from nnInteractive.inference.remote import remote_session as client

        try:
            with self._lock:
                try:
                    return self._ask(self._session or self._send_volume(), inside, outside)
                except client.SessionExpiredError:
                    return self._ask(self._send_volume(), inside, outside)
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

    def _ask(self, session: Any, inside: Index, outside: Index) -> Mask:
        session.reset_interactions()
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
