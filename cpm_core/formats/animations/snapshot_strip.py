"""Snapshot strip: snapshots of a run side by side, as in a figure of a publication."""

from __future__ import annotations

import io
import os
import string
import unicodedata
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import PIL.Image
import PIL.ImageDraw
import PIL.ImageFont
import PIL.PngImagePlugin

from cpm_core.formats.common.atomic import check_place, write_together
from cpm_core.numerics.real_numbers import checked_number
from cpm_core.numerics.types import Pixels
from cpm_core.parameters.quotation import shown

Font = PIL.ImageFont.FreeTypeFont | PIL.ImageFont.ImageFont

_MOST_COLUMNS = 4
_TEXT_SHARE, _LEAST_TEXT = 0.05, 11.0
"""Height of the letters of a caption: fraction of a frame's height, and smallest value [px]."""

_LARGEST_TEXT, _WIDEST_GAP = 1000.0, 1000
"""Largest height of letters and gap between frames [px]."""

_GAPS = f"a whole number of px from 0 to {_WIDEST_GAP}"

_COMMON = ("DejaVuSans.ttf", "segoeui.ttf", "Arial Unicode.ttf", "arial.ttf", "LiberationSans-Regular.ttf")
"""Fonts of Linux, Windows and macOS with Greek and accented letters."""

_UNKNOWN = "\uffff"
"""A character that is in no font."""

_PLAIN = {"µ": "u", "×": "x", "−": "-", "⁻": "-", "≤": "<=", "≥": ">=", "≈": "~", "·": ".", "…": "..."}
_PLAIN |= {"ß": "ss", "æ": "ae", "Æ": "Ae", "œ": "oe", "Œ": "Oe", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L"}
"""Replacements of characters that a font lacks."""

_PAPER, _INK = (255, 255, 255), (0, 0, 0)


def strip(
    frames: Sequence[Pixels],
    captions: Sequence[str] = (),
    columns: int | None = None,
    gap: int = 8,
    text_size: float | None = None,
) -> Pixels:
    """Compose frames into one picture, row by row, each with its caption below.

    Parameters
    ----------
    frames : sequence of ndarray of uint8, shape (H, W, 3)
        Red, green and blue, all of one size.
    captions : sequence of str
        One for each frame, or none at all. Letters that Pillow's own font lacks are drawn in a common one of the system
        where there is one, else spelled out: β becomes beta, µm um. A caption wider than its frame is truncated.
    columns : int, optional
        Frames in a row; up to four unless given.
    gap : int
        White space between frames and around all of them [px].
    text_size : float, optional
        Height of the letters [px]; a twentieth of the height of a frame unless given.

    Returns
    -------
    ndarray of uint8, shape (rows, columns, 3)
        The picture, on white.

    Raises
    ------
    ValueError
        When there is no frame, frames differ in size or are not such arrays, or the number of captions differs.

    Examples
    --------
    >>> frames = [np.full((32, 32, 3), 60 * k, np.uint8) for k in range(4)]
    >>> cpm.strip(frames, ["start", "step 5", "step 10", "at rest"], columns=2).ndim
    3
    """
    most, gap = _checked(frames, captions, columns, gap, text_size)
    height, width = frames[0].shape[:2]
    across = min(most, len(frames))
    down = -(-len(frames) // across)
    font = _font("".join(captions), text_size or max(_TEXT_SHARE * height, _LEAST_TEXT))
    above, below = font.getmetrics() if isinstance(font, PIL.ImageFont.FreeTypeFont) else (11, 3)
    line = above + below + max(2, below // 2) if captions else 0
    sheet = PIL.Image.new("RGB", (across * (width + gap) + gap, down * (height + line + gap) + gap), _PAPER)
    pen = PIL.ImageDraw.Draw(sheet)
    for number, frame in enumerate(frames):
        left, top = gap + number % across * (width + gap), gap + number // across * (height + line + gap)
        sheet.paste(PIL.Image.fromarray(np.ascontiguousarray(frame)), (left, top))
        if captions:
            text = _shortened(_spelt(captions[number], font), font, width)
            start = left + 0.5 * (width - font.getlength(text))
            pen.text((start, top + height + line - above - below), text, fill=_INK, font=font)
    return np.array(sheet)


def write_picture(pixels: Pixels, path: str | os.PathLike[str], comment: str = "") -> None:
    """Write a strip, or any other picture, as PNG.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        Red, green and blue.
    path : path-like
        File to write, with the suffix ``.png``.
    comment : str
        Text in ASCII that the file carries, such as how the picture came about.

    Raises
    ------
    ValueError
        When the suffix is another one or the file cannot be written.
    """
    file = Path(path)
    if file.suffix.lower() != ".png":
        raise ValueError(f"{file.name} must end in .png, for a picture is written as PNG.")
    check_place(file)
    stream, texts = io.BytesIO(), PIL.PngImagePlugin.PngInfo()
    if comment:
        texts.add_text("Description", comment)
    PIL.Image.fromarray(np.ascontiguousarray(pixels)).save(stream, format="PNG", pnginfo=texts)
    write_together([(file, stream.getvalue())])


def _checked(
    frames: Sequence[Pixels], captions: Sequence[str], columns: int | None, gap: int, size: float | None
) -> tuple[int, int]:
    """Most frames in a row, and the gap; ValueError unless these arguments make a strip."""
    if not isinstance(frames, Sequence) or not frames:
        raise ValueError("A strip needs at least one frame: take a snapshot first.")
    for frame in map(np.asarray, frames):
        if frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3 or frame.shape != np.shape(frames[0]):
            raise ValueError(
                f"A frame holds {frame.dtype} of shape {frame.shape}, but all must hold uint8 of one shape "
                f"(rows, columns, 3); the first has {np.shape(frames[0])}."
            )
    if not isinstance(captions, Sequence) or not all(isinstance(caption, str) for caption in captions):
        raise ValueError(f"captions is {shown(captions)} but must be a list of texts.")
    if len(captions) not in (0, len(frames)):
        raise ValueError(f"There are {len(captions)} captions for {len(frames)} frames: give one for each, or none.")
    if columns is not None:
        checked_number(
            "columns", columns, lambda number: number >= 1 and number == int(number), "a whole number from 1"
        )
    checked_number("gap", gap, lambda number: 0 <= number <= _WIDEST_GAP and number == int(number), _GAPS)
    if size is not None:
        checked_number(
            "text_size", size, lambda number: 1.0 <= number <= _LARGEST_TEXT, f"from 1 to {_LARGEST_TEXT:g} px"
        )
    return int(columns or _MOST_COLUMNS), int(gap)


def _font(text: str, size: float) -> Font:
    """Pillow's own font if it has all letters of a text, else the first common one that has them."""
    own = PIL.ImageFont.load_default(size)
    if not _lacking(text, own):
        return own
    for name in _COMMON:
        try:
            font = PIL.ImageFont.truetype(name, size)
        except OSError:
            continue
        if not _lacking(text, font):
            return font
    return own


def _lacking(text: str, font: Font) -> set[str]:
    """Letters of a text that a font does not have."""
    nothing = _drawn(_UNKNOWN, font)
    return {letter for letter in set(text) - set(string.whitespace) if _drawn(letter, font) == nothing}


def _spelt(text: str, font: Font) -> str:
    """A caption in letters that the font has."""
    lacking = _lacking(text, font)
    return "".join(_plain(letter) if letter in lacking else letter for letter in text)


def _drawn(letter: str, font: Font) -> bytes:
    """Bitmap of a letter; the same for all letters that the font lacks."""
    try:
        return bytes(font.getmask(letter))
    except UnicodeError:  # without FreeType the font of Pillow has Western letters only
        return b""


def _plain(letter: str) -> str:
    """ASCII replacement of a letter: the name of a Greek letter, the digit of an index; else a question mark."""
    if letter in _PLAIN:
        return _PLAIN[letter]
    kind, _, name = unicodedata.name(letter, "").rpartition(" LETTER ")
    if kind.startswith("GREEK"):
        return name.split()[0].lower() if "SMALL" in kind else name.split()[0].capitalize()
    if unicodedata.category(letter) == "Pd":
        return "-"
    parts = unicodedata.normalize("NFKD", letter)
    base = "".join(part for part in parts if not unicodedata.combining(part))
    return base if base.isascii() else "?"


def _shortened(text: str, font: Font, width: int) -> str:
    """A caption in one line, truncated where it is wider than its frame."""
    line = " ".join(text.split())
    if font.getlength(line) <= width:
        return line
    while line and font.getlength(f"{line.rstrip()}…") > width:
        line = line[:-1]
    return f"{line.rstrip()}…" if line else ""
