"""MP4: a video, where the optional encoder is installed."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np

from cpm_core.numerics.types import Pixels

ANIMATES = {".mp4": "video for slides and players; needs imageio-ffmpeg"}

_COLORS = "bt709"
"""Standard by which players convert the stored values to red, green and blue."""

_OUTPUT = (
    *("-crf", "16", "-movflags", "+faststart"),
    *("-vf", f"scale=out_color_matrix={_COLORS}:out_range=tv"),
    *("-colorspace", _COLORS, "-color_primaries", _COLORS, "-color_trc", _COLORS, "-f", "mp4"),
)


def check() -> None:
    """Raise ValueError, saying what to install, when there is no encoder."""
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        raise ValueError(
            'An .mp4 file needs the encoder imageio-ffmpeg, which is not installed: run "pip install imageio-ffmpeg", '
            "or save as .gif or APNG (.png)."
        )


class Mp4Animation:
    """A video that is written frame by frame by ffmpeg (H.264, which all players know); see `animation.Animation`.

    The format needs even numbers of rows and columns: where they are odd, the last row or column is repeated.
    ValueError when there is no encoder, or it does not work.
    """

    def __init__(self, path: Path, shape: tuple[int, int], frames_per_second: float, comment: str = "") -> None:
        check()
        import imageio_ffmpeg  # optional, and needed only here

        self._padding = [(0, shape[0] % 2), (0, shape[1] % 2), (0, 0)]
        rows, cols = shape[0] + shape[0] % 2, shape[1] + shape[1] % 2
        self._encoder = imageio_ffmpeg.write_frames(
            str(path),
            (cols, rows),
            fps=frames_per_second,
            codec="libx264",
            quality=None,
            macro_block_size=1,
            ffmpeg_log_level="error",
            output_params=[*_OUTPUT, *(("-metadata", f"comment={comment}") if comment else ())],
        )
        self._send(None)

    def add(self, frame: Pixels) -> None:
        """Append a frame."""
        self._send(np.ascontiguousarray(np.pad(frame, self._padding, mode="edge")))

    def close(self) -> None:
        """End the file."""
        self._encoder.close()

    def abandon(self) -> None:
        """Stop writing."""
        self._encoder.close()

    def _send(self, frame: Pixels | None) -> None:
        try:
            self._encoder.send(frame)
        except (OSError, RuntimeError, StopIteration) as error:
            raise ValueError(
                f"The encoder of .mp4 files does not work here ({error}): save as .gif or APNG (.png)."
            ) from error
