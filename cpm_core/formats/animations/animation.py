"""Animations: a sequence of frames as a GIF, APNG or MP4 file."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path
from typing import Protocol

import numpy as np

from cpm_core.formats.animations import apng, gif, mp4
from cpm_core.formats.common.atomic import check_place, draft_of
from cpm_core.numerics.types import Pixels


class Animation(Protocol):
    """An animation that is written frame by frame, so that at most two of them are in memory.

    Parameters
    ----------
    path : Path
        File to write.
    shape : tuple of int
        Rows and columns of the frames.
    frames_per_second : float
        Speed.
    comment : str
        Text in ASCII that the file carries, such as how the frames came about; empty for none.

    Raises
    ------
    ValueError
        When the format cannot show frames of this size or speed, or its encoder does not work.
    """

    def __init__(self, path: Path, shape: tuple[int, int], frames_per_second: float, comment: str) -> None:
        """Begin the file."""

    def add(self, frame: Pixels) -> None:
        """Append a frame, shape (H, W, 3)."""

    def close(self) -> None:
        """End the file."""

    def abandon(self) -> None:
        """Stop writing; the file is incomplete."""


_FORMATS: dict[str, type[Animation]] = {
    **dict.fromkeys(gif.ANIMATES, gif.GifAnimation),
    **dict.fromkeys(apng.ANIMATES, apng.ApngAnimation),
    **dict.fromkeys(mp4.ANIMATES, mp4.Mp4Animation),
}

ANIMATED: dict[str, str] = {**gif.ANIMATES, **apng.ANIMATES, **mp4.ANIMATES}
"""Suffixes of animations that can be written -> what they are."""

SLOWEST, FASTEST = 0.1, 120.0
"""Range of frames a second; a GIF shows 50 at most."""


def write_animation(
    frames: Iterable[Pixels],
    path: str | os.PathLike[str],
    frames_per_second: float = 25.0,
    progress: Callable[[int], object] | None = None,
    cancelled: Callable[[], bool] | None = None,
    comment: str = "",
) -> bool:
    """Write frames as an animation that repeats for ever, or as a video, by suffix.

    Parameters
    ----------
    frames : iterable of ndarray of uint8, shape (H, W, 3)
        Red, green and blue, all of one size; each is requested when the one before has been written.
    path : path-like
        File to write; see `ANIMATED` for the suffixes. It is replaced atomically at the end.
    frames_per_second : float
        Speed.
    progress : callable, optional
        Called with the number of frames written.
    cancelled : callable, optional
        Called before each frame; True stops the writing.
    comment : str
        Text in ASCII that the file carries.

    Returns
    -------
    bool
        False when it was cancelled; then nothing is written.

    Raises
    ------
    ValueError
        When `check_animation` does, or there are no frames, or they are not such arrays.

    Examples
    --------
    >>> frames = [np.full((32, 32, 3), 16 * k, np.uint8) for k in range(8)]
    >>> cpm.write_animation(frames, "run.gif", frames_per_second=4)
    True
    """
    check_animation(path)
    _check_speed(frames_per_second)
    if cancelled is not None and cancelled():
        return False
    file, rest = Path(path), iter(frames)
    if (first := next(rest, None)) is None:
        raise ValueError(f"{file.name} would be an animation without frames: let it run first.")
    shape = _checked(first, None)
    try:
        with draft_of(file) as draft:
            animation = _FORMATS[file.suffix.lower()](draft, shape, frames_per_second, comment)
            _add_all(animation, chain([first], rest), shape, progress, cancelled)
    except _CancelledError:
        return False
    return True


def check_animation(path: str | os.PathLike[str]) -> None:
    """Check in advance whether `write_animation` could write to a path.

    Raises
    ------
    ValueError
        When the suffix is not known, the encoder that it needs is not installed, or no file can be written there.
    """
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in ANIMATED and not file.is_dir():
        known = ", ".join(f"{suffix} ({text})" for suffix, text in ANIMATED.items())
        raise ValueError(f"{file.name} has no suffix of an animation: choose one of {known}.")
    check_place(file)
    if suffix in mp4.ANIMATES:
        mp4.check()


class _CancelledError(Exception):
    """The animation was cancelled."""


def _check_speed(frames_per_second: float) -> None:
    if not (math.isfinite(frames_per_second) and SLOWEST <= frames_per_second <= FASTEST):
        raise ValueError(
            f"frames_per_second is {frames_per_second:g} but must be a number from {SLOWEST:g} to {FASTEST:g}."
        )


def _add_all(
    animation: Animation,
    frames: Iterable[Pixels],
    shape: tuple[int, int],
    progress: Callable[[int], object] | None,
    cancelled: Callable[[], bool] | None,
) -> None:
    """Add frames and end the file; any exception abandons it. `cancelled` is not called before the first frame."""
    try:
        for count, frame in enumerate(frames, start=1):
            if count > 1 and cancelled is not None and cancelled():
                raise _CancelledError
            _checked(frame, shape)
            animation.add(frame)
            if progress is not None:
                progress(count)
    except BaseException:
        animation.abandon()
        raise
    animation.close()


def _checked(frame: Pixels, wanted: tuple[int, int] | None) -> tuple[int, int]:
    """Rows and columns of a frame; ValueError when it is not a frame, or of another size than `wanted`."""
    if frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3 or not frame.size:
        raise ValueError(
            f"A frame holds {frame.dtype} of shape {frame.shape}, but must hold uint8 of shape (rows, columns, 3)."
        )
    shape = frame.shape[0], frame.shape[1]
    if wanted is not None and shape != wanted:
        raise ValueError(
            f"A frame has {shape[0]} x {shape[1]} px, but those before have {wanted[0]} x {wanted[1]} px: "
            "keep the size of the view while it is recorded."
        )
    return shape
