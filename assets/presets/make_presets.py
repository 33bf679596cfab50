"""Draws the pictures of the program's presets: each preset run on a sample image, with the contours that it finds.

Run ``python assets/presets/make_presets.py`` to write them anew beside this file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import PIL.Image
import PIL.ImageDraw

import cpm_core as cpm
from app.model.document.document import Document
from app.model.document.samples import sample_called
from cpm_core.shapes.everywhere import Everywhere
from cpm_core.shapes.image_starts import SeedCache

HERE = Path(__file__).parent
SIZE, FINER = (288, 168), 3
"""Size of a picture [px], and how much finer it is drawn before it is made smaller."""

CLOSED, OPEN = "#56b4e9", "#ff9d1e"

SHOWN = {
    "shape": ("u_shape.png", 34, 256),
    "automatic": ("nuclei.png", 40, 250),
    "vessels": ("artery.png", 30, 250),
    "noisy": ("noisy.png", 44, 256),
    "fluorescence": ("cells.png", 60, 250),
    "angiogram": ("artery.png", 60, 250),
    "ultrasound": ("noisy.png", 44, 256),
}
"""For each preset the sample, and the first row and the width of what is shown of it."""


def draw(preset: str) -> PIL.Image.Image:
    """The picture of a preset."""
    file, top, width = SHOWN[preset]
    sample = sample_called(file)
    assert sample is not None
    image, parameters = cpm.load_image(sample.path), cpm.PRESETS[preset]
    document = Document(shapes=sample.shapes, parameters=parameters)
    if preset in ("vessels", "angiogram", "ultrasound"):
        document = Document(shapes=(Everywhere("grid"),), parameters=parameters)
    seeds = document.seeds(SeedCache(image).seeds_for(document.image_starts, parameters.smoothing, None))
    result = cpm.segment(image, seeds, parameters)
    height = width * SIZE[1] // SIZE[0]
    left = (image.shape[1] - width) // 2
    part = np.clip(image.values[top : top + height, left : left + width], 0, 255).astype(np.uint8)
    big = (
        PIL.Image.fromarray(part)
        .convert("RGB")
        .resize((SIZE[0] * FINER, SIZE[1] * FINER), PIL.Image.Resampling.BICUBIC)
    )
    pen, scale = PIL.ImageDraw.Draw(big), SIZE[0] * FINER / width
    for contour in result.contours:
        path = (contour.path - (top, left) + 0.5) * scale
        pen.line(
            [(col, row) for row, col in path], fill=CLOSED if contour.closed else OPEN, width=4 * FINER, joint="curve"
        )
    return big.resize(SIZE, PIL.Image.Resampling.LANCZOS)


if __name__ == "__main__":
    for name in SHOWN:
        draw(name).save(HERE / f"{name}.png", optimize=True)
