"""Inputs of commands: images, sessions, starts, and ground truths."""

from __future__ import annotations

import argparse
import glob
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from cpm_core.cli.output import STANDARD_STREAM, print_message, print_notes
from cpm_core.contours.ground_truth import Truth, VolumeTruth
from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    CONTOURS_READABLE,
    is_image_name,
    load_centerlines,
    load_surface,
    natural_sort_key,
)
from cpm_core.formats.common.content import find_local_file, is_address
from cpm_core.formats.contour_file import describe_plane, read_contours
from cpm_core.formats.ground_truth_file import load_truth, load_volume_truth
from cpm_core.formats.images.dicom import holds_dicom_series, holds_dicom_series_below
from cpm_core.formats.images.ome_zarr import is_zarr
from cpm_core.formats.sessions.session_file import (
    SESSION_SUFFIX,
    SessionFile,
    adapt_reading,
    find_session_image,
    load_session,
)
from cpm_core.image.colors import LUMINANCE_NOTE
from cpm_core.image.image import Image
from cpm_core.numerics.types import JsonDict, Texts
from cpm_core.pages.follow import limit_scales
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import quote_value
from cpm_core.shapes import Start
from cpm_core.shapes.outlines import start_from_surface, starts_from_centerlines, starts_from_contours


def expand_paths(patterns: Sequence[str]) -> list[str]:
    """Return the images that files, folders, patterns, addresses of fsspec and standard input (``-``) name.

    A folder stands for the images in it, in the order of the numbers in their names; one with the slices of a DICOM
    series stands for itself. ValueError for a folder or a pattern without images; files need not exist.
    """
    found: list[str] = []
    for text in patterns:
        if text == STANDARD_STREAM:
            found.append(str(find_local_file(sys.stdin.buffer)))
        elif is_address(text):
            found.append(text)
        elif Path(text).is_dir():
            found += _list_images_in_folder(Path(text))
        elif glob.has_magic(text) and not os.path.lexists(text):
            names = sorted(filter(os.path.isfile, glob.glob(text, recursive=True)), key=natural_sort_key)  # noqa: PTH207 - names as given
            if not names:
                raise ValueError(f"No file is named like {quote_value(text)}: check the pattern and the folder.")
            found += names
        else:
            found.append(text)
    return found


def find_only_image(pattern: str) -> str:
    """Return the path of the image that a pattern names, as for `expand_paths`; ValueError when it names several."""
    found = expand_paths([pattern])
    if len(found) > 1:
        raise ValueError(
            f"{quote_value(pattern)} names {len(found)} images, but only one can be used here: "
            "name it, or use cpm batch."
        )
    return str(find_local_file(found[0]))


def _list_images_in_folder(folder: Path) -> list[str]:
    if holds_dicom_series(folder) or is_zarr(folder):
        return [str(folder)]
    try:
        inside = [entry for entry in folder.iterdir() if is_image_name(entry.name) and entry.is_file()]
    except OSError as error:
        raise ValueError(f"{folder} cannot be read: {error.strerror or error}.") from error
    if not inside and holds_dicom_series_below(folder):
        return [str(folder)]
    if not inside:
        raise ValueError(f"{folder} is a folder without images: choose another one, or name a file.")
    return sorted(map(str, inside), key=natural_sort_key)


def load_named_session(arguments: argparse.Namespace) -> SessionFile:
    """Load the session that is given, also in place of the image, else return an empty one.

    ValueError when there is no image, or there are two sessions.
    """
    if arguments.image is not None and Path(arguments.image).suffix.lower() == SESSION_SUFFIX:
        if arguments.session:
            raise ValueError(f"{arguments.image} is a session, and --session names one as well: leave one of them out.")
        arguments.session, arguments.image = arguments.image, None
    session = load_session(Path(arguments.session)) if arguments.session else SessionFile()
    if arguments.image is None and session.image is None:
        raise ValueError("No IMAGE is given: name one, or a session that has one.")
    return session


def locate_image(named: str | None, session: SessionFile, source: str | Path | None) -> tuple[Path, JsonDict]:
    """Return the path of the named image, or else of the image of the session, and how to read it."""
    if source is not None:
        print_notes(Path(source).name, session.notes)
    if session.image is None or source is None:
        return Path(named or ""), {}
    if named is not None:
        return Path(named), adapt_reading(Path(named), session.image.reading)
    path, notes = find_session_image(session.image, Path(source).absolute().parent)
    print_notes(path.name, notes)
    return path, session.image.reading.arguments


def fit_parameters(image: Image, parameters: Parameters, *, scales: bool = True) -> Parameters:
    """Print the notes on an image, and return parameters with as many `scales` as it has room for."""
    notes = list_image_notes(image, parameters)
    if scales:
        parameters, more = fit_scales_to_image(parameters, image)
        notes += more
    print_notes(image.source, notes)
    return parameters


def fit_scales_to_image(parameters: Parameters, image: Image) -> tuple[Parameters, Texts]:
    """Return parameters with as many scales as an image has room for, and a note where that changes them."""
    fit = limit_scales(parameters, image.shape) if image.ndim == 2 else parameters
    return fit, () if fit == parameters else (f"The image is small: scales is set to {fit.scales}.",)


def list_image_notes(image: Image, parameters: Parameters) -> Texts:
    """Return notes on the differences between the file of an image and the gray levels that a run takes."""
    wanted = parameters.channel
    if wanted == "luminance" or image.ndim == 3:
        return image.notes
    if image.colors is None:
        return (*image.notes, f"The image is gray: it has no channel {wanted}.")
    taken = f"The channel {wanted} of its colors was taken."
    return tuple(taken if note == LUMINANCE_NOTE else note for note in image.notes)


def read_starts(path: str, image: Image) -> tuple[Start, ...]:
    """Return starts along the contours of a file; in a volume on its surface, or along its center lines."""
    suffix = Path(path).suffix.lower()
    if image.ndim == 2:
        found = read_contours(path, describe_plane(image))
        print_notes(Path(path).name, found.notes)
        return starts_from_contours(found.contours, found.points)
    if suffix in CONTOURS_READABLE:
        raise ValueError(f"--start {path} has contours, which lie in a plane: name a surface or center lines.")
    if suffix in CENTERLINES_WRITABLE:
        return tuple(starts_from_centerlines(load_centerlines(path, image, warn=print_message)))
    return (start_from_surface(load_surface(path, image, warn=print_message)),)


def load_named_truth(path: str | None, image: Image) -> Truth | VolumeTruth | None:
    """Load the given ground truth of this image or volume, if any."""
    if path is None:
        return None
    truth: Truth | VolumeTruth
    if image.ndim == 3:
        truth = load_volume_truth(path, image)
    else:
        truth = load_truth(path, image.shape, spacing=image.spacing, unit=image.unit, name=image.source)
    print_notes(truth.source, truth.notes)
    return truth
