"""Animations and pictures: frames as a GIF, APNG or MP4 file, and one frame as a PNG file."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path

import numpy as np
import PIL.Image
from PIL.PngImagePlugin import PngInfo

from cpm_core.formats.common.atomic import check_target, draft_files, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.numerics.memory import available_memory
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import Extent, Pixels

ANIMATIONS_WRITABLE: dict[str, str] = {
    ".gif": "animated GIF, which all viewers show",
    ".png": "animated PNG in full color, which browsers show",
    ".apng": "animated PNG in full color, which browsers show",
    ".mp4": "video for slides and players; needs imageio-ffmpeg",
}
"""Suffixes of animations that can be written -> what they are."""

MIN_FRAME_RATE = 0.1
"""Lowest frame rate [1 / s]."""

MAX_FRAME_RATE = 120.0
"""Highest frame rate [1 / s]."""

MAX_GIF_FRAME_RATE = 50.0
"""Highest frame rate of a GIF [1 / s]; viewers slow down faster ones."""

_COLOR_STANDARD = "bt709"
"""Standard by which players convert the stored values to red, green and blue."""

_VIDEO_OPTIONS = (
    *("-crf", "16", "-movflags", "+faststart"),
    *("-vf", f"scale=out_color_matrix={_COLOR_STANDARD}:out_range=tv"),
    *("-colorspace", _COLOR_STANDARD, "-color_primaries", _COLOR_STANDARD, "-color_trc", _COLOR_STANDARD, "-f", "mp4"),
)


def write_animation(
    frames: Iterable[Pixels],
    path: AnyPath,
    frames_per_second: float = 25.0,
    *,
    comment: str = "",
    progress: Callable[[int], object] | None = None,
) -> None:
    """Write frames as an animation that repeats for ever, or as a video, by suffix.

    Parameters
    ----------
    frames : iterable of ndarray of uint8, shape (H, W, 3)
        RGB frames, all of one size; each is requested only after the previous one has been encoded.
    path : path-like
        File to write; see `ANIMATIONS_WRITABLE` for the suffixes. It is replaced atomically at the end.
    frames_per_second : float
        Speed.
    comment : str
        Text in ASCII that the file carries.
    progress : callable, optional
        Called with the number of frames taken; when it raises, nothing is written.

    Raises
    ------
    ValueError
        When `check_animation` raises, there are no frames, or a frame is not such an array.

    Examples
    --------
    >>> frames = [np.full((32, 32, 3), 16 * k, np.uint8) for k in range(8)]
    >>> cpm.write_animation(frames, "run.gif", frames_per_second=4)
    """
    check_animation(path)
    file = Path(path)
    fastest = MAX_GIF_FRAME_RATE if file.suffix.lower() == ".gif" else MAX_FRAME_RATE
    if not (math.isfinite(frames_per_second) and MIN_FRAME_RATE <= frames_per_second <= fastest):
        raise ValueError(
            f"frames_per_second is {frames_per_second:g} but must be a number from {MIN_FRAME_RATE:g} to {fastest:g}."
        )

    def check_frames() -> Iterator[Pixels]:
        shape: Extent = ()
        for count, frame in enumerate(frames, start=1):
            shape = shape or (*frame.shape[:2], 3)
            if frame.dtype != np.uint8 or frame.shape != shape:
                raise ValueError(
                    f"A frame holds {frame.dtype} of shape {frame.shape}, but all must hold uint8 of one shape "
                    "(rows, columns, 3): keep the size of the view while it is recorded."
                )
            yield frame
            if progress is not None:
                progress(count)

    checked = check_frames()
    if (first := next(checked, None)) is None:
        raise ValueError(f"{file.name} would be an animation without frames: run first.")
    write = _write_video if file.suffix.lower() == ".mp4" else _write_animated_picture
    with draft_files(file) as (draft,):
        write(first, checked, draft, file.suffix.lower(), frames_per_second, comment)


def check_animation(path: AnyPath) -> None:
    """Check in advance whether `write_animation` could write to a path.

    Raises
    ------
    ValueError
        When the suffix is not known, the encoder that it needs is not installed, or no file can be written there.
    """
    file = Path(path)
    check_target(file, ANIMATIONS_WRITABLE, "of an animation")
    if file.suffix.lower() == ".mp4":
        require_package("imageio_ffmpeg", "An .mp4 file, unlike .gif and APNG (.png),")


def write_picture(pixels: Pixels, path: Path, comment: str = "") -> None:
    """Write a picture, uint8 of shape (H, W, 3), as PNG with a comment; ValueError when it cannot be written."""
    if path.suffix.lower() != ".png":
        raise ValueError(f"{path.name} must end in .png, because pictures are written as PNG.")
    stream, texts = io.BytesIO(), PngInfo()
    texts.add_text("Description", comment)
    PIL.Image.fromarray(np.ascontiguousarray(pixels)).save(stream, format="PNG", pnginfo=texts)
    write_together([(path, stream.getvalue())])


def _write_animated_picture(
    first: Pixels, rest: Iterable[Pixels], path: Path, suffix: str, frames_per_second: float, comment: str
) -> None:
    """Write an animated GIF or PNG; Pillow compares the frames, so all stay in memory until the end."""
    tick = 10 if suffix == ".gif" else 1
    """Unit of the times in the file [ms]."""

    pictures, kept = [], 0
    for number, frame in enumerate(chain([first], rest)):
        picture = PIL.Image.fromarray(np.ascontiguousarray(frame))
        if suffix == ".gif":  # unlike the other methods, this one keeps the rare, vivid colors of overlays
            picture = picture.quantize(256, PIL.Image.Quantize.MAXCOVERAGE, dither=PIL.Image.Dither.NONE)
        begin, end = (round(1000.0 / tick * n / frames_per_second) for n in (number, number + 1))
        picture.info["duration"] = tick * (end - begin)  # so that rounding does not add up
        pictures.append(picture)
        kept += frame.nbytes
        if kept > available_memory():
            raise ValueError(f"{number + 1} frames do not fit into memory twice: write fewer or smaller ones, or .mp4.")
    texts = PngInfo()
    texts.add_text("Description", comment)
    kind = {"format": "GIF", "comment": comment.encode()} if suffix == ".gif" else {"format": "PNG", "pnginfo": texts}
    pictures[0].save(path, save_all=True, append_images=pictures[1:], loop=0, **kind)


def _write_video(
    first: Pixels, rest: Iterable[Pixels], path: Path, _suffix: str, frames_per_second: float, comment: str
) -> None:
    """Write an H.264 video; it needs even sides, so the last row or column of odd frames is repeated."""
    import imageio_ffmpeg  # optional, and needed only here

    rows, columns = first.shape[0], first.shape[1]
    padding = [(0, rows % 2), (0, columns % 2), (0, 0)]
    encoder = imageio_ffmpeg.write_frames(
        str(path),
        (columns + columns % 2, rows + rows % 2),
        fps=frames_per_second,
        codec="libx264",
        quality=None,
        macro_block_size=1,
        ffmpeg_log_level="error",
        output_params=[*_VIDEO_OPTIONS, *(("-metadata", f"comment={comment}") if comment else ())],
    )

    def send_frame(frame: Pixels | None) -> None:
        try:
            encoder.send(frame)
        except (OSError, RuntimeError, StopIteration) as error:
            raise ValueError(
                f"The encoder of .mp4 files does not work here ({error}): save as .gif or APNG (.png)."
            ) from error

    try:
        send_frame(None)
        for frame in chain([first], rest):
            send_frame(np.ascontiguousarray(np.pad(frame, padding, mode="edge")))
    finally:
        encoder.close()
