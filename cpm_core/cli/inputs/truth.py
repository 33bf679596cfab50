"""The ground truth that a command line names."""

from __future__ import annotations

import argparse

from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.surface.ground_truth import VolumeTruth
from cpm_core.formats.ground_truth_file import load_truth, load_volume_truth
from cpm_core.image.image import Image


def truth_for(arguments: argparse.Namespace, image: Image) -> Truth | None:
    """The ground truth that is named, of this image."""
    if arguments.truth is None:
        return None
    return load_truth(arguments.truth, image.shape, spacing=image.spacing, unit=image.unit)


def volume_truth_for(arguments: argparse.Namespace, volume: Image) -> VolumeTruth | None:
    """The ground truth that is named, of this volume."""
    return None if arguments.truth is None else load_volume_truth(arguments.truth, volume)
