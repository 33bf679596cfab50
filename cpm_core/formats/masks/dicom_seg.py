"""DICOM SEG: objects as segments that refer to the images of a series, by highdicom and pydicom."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import skimage

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import build_label
from cpm_core.formats.common.provenance import VERSION
from cpm_core.formats.images.decoded import DecodedImage
from cpm_core.formats.images.dicom import decode_frames, is_dicom, read_frames
from cpm_core.formats.images.dicom_series import DicomFrame
from cpm_core.formats.masks.labels import find_named_labels, paint_labels
from cpm_core.formats.masks.nifti import locate_mask
from cpm_core.image.geometry import Geometry
from cpm_core.image.surface import Label
from cpm_core.results.result import Result

_SEGMENTATION_CLASS = "1.2.840.10008.5.1.4.1.1.66.4"
"""Class of files whose frames are binary or fractional segments."""

_LABELMAP_CLASS = "1.2.840.10008.5.1.4.1.1.66.7"
"""Class of files whose frames are label maps."""

_MAX_SLICE_OFFSET = 0.01
"""Largest distance of a slice from its expected position [mm]; also largest difference of unit vectors."""

_TISSUE_CODE = ("85756007", "SCT", "Tissue")
"""Code of the standard for the kind of the segments."""

_EDGE_DETECTION_CODE = ("123103", "DCM", "Edge Detection")
"""Code of the standard for the method that found them."""

_MAX_LABEL_LENGTH = 64
"""Longest label of a segment [characters]."""

_LAB_RANGE = np.array([[0.0, -128.0, -128.0], [100.0, 127.0, 127.0]])
"""Colors of 0 and 65535 in the color of a segment: CIELab with white point D65, as DCMTK writes it."""


def encode_dicom_seg(result: Result, image: Path | None = None) -> bytes:
    """Encode the objects of a result as a segmentation of the series in a file or folder, one named segment each.

    Segments are numbered from 1 without gaps, as highdicom requires. ValueError when there is nothing to paint,
    and when the result does not lie in a DICOM series.
    """
    import highdicom
    import pydicom
    from pydicom.sr.coding import Code

    mask = paint_labels(result)
    numbers = np.unique(mask)[1:].tolist()
    names = {label.number: label for label in find_named_labels(result)}
    frames = _find_source_frames(result, image)
    sources = [pydicom.dcmread(path, stop_before_pixels=True) for path in dict.fromkeys(frame.path for frame in frames)]
    order = np.argsort([frame.index for frame in frames], kind="stable")
    algorithm = highdicom.AlgorithmIdentificationSequence("CPM", Code(*_EDGE_DETECTION_CODE), VERSION)
    segments = []
    for number, old in enumerate(numbers, start=1):
        label = names.get(old, Label(old))
        lab = skimage.color.rgb2lab(np.frombuffer(bytes.fromhex(label.color[1:] or "ffffff"), np.uint8) / 255.0)
        segments.append(
            highdicom.seg.SegmentDescription(
                number,
                (label.name or f"Segment {old}")[:_MAX_LABEL_LENGTH],
                Code(*_TISSUE_CODE),
                Code(*_TISSUE_CODE),
                "SEMIAUTOMATIC",
                algorithm,
                display_color=highdicom.color.CIELabColor(*lab.tolist()) if label.color else None,
            )
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about oddities in the headers of the series
            made = highdicom.seg.Segmentation(
                sources,
                np.searchsorted([0, *numbers], mask)[order].astype(np.uint16),
                "BINARY",
                segments,
                series_instance_uid=highdicom.UID(),
                series_number=1,
                sop_instance_uid=highdicom.UID(),
                instance_number=1,
                manufacturer="CPM",
                manufacturer_model_name="CPM",
                software_versions=VERSION,
                device_serial_number="0",
            )
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(f"{result.source} lacks what a segmentation refers to: {error}") from error
    stream = io.BytesIO()
    made.save_as(stream, enforce_file_format=True)
    return stream.getvalue()


def _find_source_frames(result: Result, image: Path | None) -> list[DicomFrame]:
    """Find the images of the series that a result lies in, one per plane; ValueError if there is none."""
    affine, unit = locate_mask(result, "LPS")
    refused = ValueError(
        f"{result.source} is no DICOM series with positions, but a segmentation refers to one: choose .nii.gz or .nrrd."
    )
    if image is None or unit != "mm" or result.image is None or not (image.is_dir() or is_dicom(image)):
        raise refused
    planes = np.arange(result.shape[0])
    wanted = affine[:3, 3] + planes[:, None] * affine[:3, 2]
    along = affine[:3, :2] / np.linalg.norm(affine[:3, :2], axis=0)
    series: dict[str, list[DicomFrame]] = {}
    for frame in sorted(read_frames(image)[0], key=lambda frame: frame.sort_key):
        if frame.shape != result.shape[1:] or frame.origin is None or frame.directions is None:
            continue
        if np.abs(frame.directions.T - along).max() < _MAX_SLICE_OFFSET:
            series.setdefault(frame.series, []).append(frame)
    found = []
    for frames in series.values():
        away = np.linalg.norm(wanted[:, None] - [frame.origin for frame in frames], axis=-1)
        if away.min(axis=1).max() < _MAX_SLICE_OFFSET:
            found.append([frames[index] for index in away.argmin(axis=1)])
    middle = len(planes) // 2
    for frames in found:  # several may share a position, such as those before and after a contrast agent
        if len(found) == 1 or np.array_equal(
            decode_frames("", frames[middle:][:1]).values[0], result.image.values[middle]
        ):
            return frames
    raise refused


def read_dicom_seg(path: Path) -> list[tuple[Label, list[DecodedImage]]]:
    """Read the segments of a file, each with the images in which it has pixels, as masks with their position.

    Empty for files of another kind.
    """
    import pydicom

    dataset: Any = pydicom.dcmread(path) if is_dicom(path) else {}
    kind = dataset.get("SOPClassUID")
    if kind not in (_SEGMENTATION_CLASS, _LABELMAP_CLASS):
        return []
    frames, _ = read_frames(path)
    pixels = dataset.pixel_array.reshape((-1, *frames[0].shape))
    if dataset.get("SegmentationType") == "FRACTIONAL":
        pixels = 2 * pixels.astype(float) >= float(dataset.MaximumFractionalValue)
    found: dict[int, tuple[Label, list[DecodedImage]]] = {}
    for segment in dataset.SegmentSequence:
        color = _decode_color(segment.get("RecommendedDisplayCIELabValue"))
        label = build_label(int(segment.SegmentNumber), str(segment.get("SegmentLabel", "")), color)
        found[label.number] = label, []
    for frame, values, own in zip(frames, pixels, dataset.PerFrameFunctionalGroupsSequence, strict=True):
        if frame.origin is None or frame.directions is None or frame.spacing is None:
            raise UnreadableError(f"{path.name} does not state where its segments lie: save it again.")
        masks = {number: values == number for number in np.unique(values[values > 0]).tolist()}
        if kind == _SEGMENTATION_CLASS:
            group = own if "SegmentIdentificationSequence" in own else dataset.SharedFunctionalGroupsSequence[0]
            masks = {int(group.SegmentIdentificationSequence[0].ReferencedSegmentNumber): values > 0}
        axes = (np.cross(*frame.directions), frame.directions[1], frame.directions[0])
        geometry = Geometry(frame.origin, axes, "LPS")  # type: ignore[arg-type]
        for number, mask in masks.items():
            found[number][1].append(DecodedImage(mask[np.newaxis], (1.0, *frame.spacing), "mm", geometry=geometry))
    return list(found.values())


def _decode_color(stored: Any) -> bytes:
    """Decode red, green and blue of a segment; empty without a color."""
    if stored is None or len(stored) != 3:
        return b""
    lab = _LAB_RANGE[0] + np.array(stored, float) / 65535.0 * (_LAB_RANGE[1] - _LAB_RANGE[0])
    return bytes(np.rint(255.0 * np.clip(skimage.color.lab2rgb(lab), 0.0, 1.0)).astype(np.uint8))
