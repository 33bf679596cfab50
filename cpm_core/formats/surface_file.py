"""Surface files: triangles in any known format, selected by the suffix of the file, and label volumes."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core.contours.ground_truth import number_gray_levels
from cpm_core.contours.surface import join_surfaces, surface_from_labels
from cpm_core.formats.common.atomic import find_suffix
from cpm_core.formats.common.content import AnySource, explain_decoding_errors, find_local_file, read_content
from cpm_core.formats.images.decoded import DecodedImage
from cpm_core.formats.images.readers import IMAGES_READABLE, explain_image_errors, load_volume, open_stack
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stack import read_volume
from cpm_core.formats.masks import dicom_seg, itk_snap, nrrd
from cpm_core.formats.meshes import obj, ply, stl, vtk
from cpm_core.formats.meshes.coordinates import find_voxel_transform
from cpm_core.formats.meshes.triangles import ParsedTriangles
from cpm_core.image.geometry import Convention, Geometry, geometry_from_affine
from cpm_core.image.image import Image
from cpm_core.image.surface import Label, Surface
from cpm_core.numerics.types import Array, Texts

_LOG = logging.getLogger(__name__)

_MESH_READERS: dict[str, tuple[str, Callable[[bytes], ParsedTriangles]]] = {
    ".ply": ("triangles of MeshLab, Blender and others", ply.read_ply),
    ".stl": ("triangles for printing", stl.read_stl),
    ".obj": ("triangles of drawing programs", obj.read_obj),
    ".vtk": ("poly data of ParaView and 3D Slicer", vtk.read_vtk),
}
"""Suffix -> kind of file, and the function that reads it."""

SURFACES_READABLE: dict[str, str] = {suffix: what for suffix, (what, _) in _MESH_READERS.items()}
"""Suffixes of files that surfaces can be read from -> what they are; volumes are read as labels."""

_COORDINATE_HEAD_SIZE = 4096
"""Part of a file in which coordinates and unit are stated, from its beginning [bytes]."""

_MAX_MISALIGNMENT = 0.5
"""Largest displacement of labels from their volume [voxels]."""

_MAX_PART_MISALIGNMENT = 0.2
"""Largest displacement of labels of a part of a volume from its voxels [voxels]."""


def load_surface(
    path: AnySource,
    image: Image | None = None,
    *,
    space: Convention | None = None,
    warn: Callable[[str], object] = _LOG.warning,
) -> Surface:
    """Read a surface from a file of triangles, or the surfaces of the objects of a label volume.

    Parameters
    ----------
    path : path-like or file-like
        A file with one of the suffixes `SURFACES_READABLE`, written by `export` or by another program. Or a volume of
        labels, which is 0 outside: the surface runs between its voxels.
    image : Image, optional
        The volume that the surface belongs to: vertices are returned in its voxels. Without it a voxel is one unit of
        the file.
    space : {"LPS", "RAS"}, optional
        Directions of x, y and z; by default as stated in the file, else LPS.
    warn : callable, optional
        Called with a sentence for each assumption; by default a warning is logged.

    Returns
    -------
    Surface
        Its triangles, oriented outward; `Surface.numbers` are those of the objects if the file has them.

    Raises
    ------
    ValueError
        When the file cannot be read, contains no triangles, or none in the volume; one sentence with its name and what
        to do.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> cpm.export(result, "ball.ply")
    >>> surface = cpm.load_surface("ball.ply", result.image)
    >>> bool(np.abs(surface.vertices - result.surface.vertices).max() < 0.001), surface.closed
    (True, True)
    """
    file = find_local_file(path)
    surface, notes = read_surface(file, image, space)
    for note in notes:
        warn(f"{file.name}: {note}")
    return surface


def read_surface(path: AnySource, image: Image | None = None, space: Convention | None = None) -> tuple[Surface, Texts]:
    """Read a surface, and list what was assumed; see `load_surface`."""
    file = find_local_file(path)
    if file.suffix.lower() not in SURFACES_READABLE:
        return _read_label_surfaces(file, image)
    return decode_surface(read_content(file), file.name, image, space)


def decode_surface(
    content: bytes, name: str, image: Image | None = None, space: Convention | None = None
) -> tuple[Surface, Texts]:
    """Decode a surface from the content of a file of triangles, and list what was assumed."""
    with explain_decoding_errors(name, "is damaged or no surface of this kind: write it again."):
        found = _MESH_READERS[Path(name).suffix.lower()][1](content)
    place, notes = find_voxel_transform(content[:_COORDINATE_HEAD_SIZE].decode("latin-1"), image, space)
    faces = found.faces[:, ::-1] if place.is_mirrored else found.faces
    try:
        surface = Surface(place.to_voxels(found.points), faces, place.spacing, place.unit, numbers=found.numbers)
    except ValueError as error:
        raise ValueError(f"{name} cannot be used. {error}") from error
    if surface.volume < 0.0 and surface.closed:
        surface = replace(surface, faces=surface.faces[:, ::-1])
    used = surface.vertices[np.unique(surface.faces)]
    if not len(used):
        raise ValueError(f"{name} contains no triangles: choose another file.")
    if image is not None and not ((used >= -0.5) & (used <= np.array(image.shape) - 0.5)).all(axis=1).any():
        raise ValueError(
            f"The surface of {name} lies outside the volume {image.source}: choose the surface of this volume, in "
            "its unit, and say whether it is in LPS or RAS."
        )
    return surface, notes


def _read_label_surfaces(file: Path, image: Image | None) -> tuple[Surface, Texts]:
    """Read the surfaces of the objects in a label volume, halfway between voxels; whole labels keep their names."""
    if parts := read_overlapping_parts(file):
        if image is None:
            raise ValueError(
                f"{file.name} has segments that lie in another file: name it with --image, or open it first."
            )
        names, bodies = [], []
        for name, masks in parts:
            inside = np.zeros(image.shape)
            for mask in masks:
                _add_aligned_labels(mask, file.name, image, inside)
            names.append(name)
            bodies.append(
                (name.number, surface_from_labels((inside > 0.0).astype(np.int32), image.spacing, image.unit))
            )
        return replace(join_surfaces(bodies, image.spacing, image.unit), labels=tuple(names)), ()
    volume = image or load_volume(file)
    values, notes = (volume.values, volume.notes) if image is None else read_aligned_labels(file, image)
    labels, whole = number_gray_levels(values, file.name)
    surface = surface_from_labels(labels, volume.spacing, volume.unit)
    known = tuple(one.label for one in nrrd.read_segments(file)) or itk_snap.read_sibling_description(
        file, find_suffix(file, IMAGES_READABLE)
    )
    if known and not whole:
        return surface, (*notes, "Its values are no whole numbers, so that the names of its labels were left out.")
    if known and surface.numbers is None:
        surface = replace(surface, numbers=np.full(len(surface.faces), labels.max()))
    return replace(surface, labels=known), notes


def read_overlapping_parts(file: Path) -> Iterable[tuple[Label, Sequence[DecodedImage]]]:
    """Read the segments of a file that may overlap, as masks with positions of their own; empty for label volumes."""
    with explain_image_errors(file):
        return dicom_seg.read_dicom_seg(file) or nrrd.read_overlapping_segments(file, nrrd.read_segments(file)) or ()


def read_aligned_labels(file: Path, volume: Image) -> tuple[Array, Texts]:
    """Read the values of a label volume in the axis order of the volume that it belongs to, and list what was assumed.

    If only a part of it was saved, as some programs do around nonzero labels, the rest is 0. The values have the shape
    of `volume`. ValueError when the file cannot be read, has another size, or lies elsewhere in space.
    """
    stack = open_stack(file)
    with explain_image_errors(file):
        found = read_volume(stack, Reading())
    values = np.zeros(volume.shape)
    _add_aligned_labels(found, file.name, volume, values)
    return values, found.notes


def _add_aligned_labels(labels: DecodedImage, name: str, volume: Image, into: Array) -> None:
    """Add the values of labels to those of a volume, in its axis order.

    `into` has the shape of `volume`. ValueError when labels lie elsewhere in space, or have another size.
    """
    with np.errstate(invalid="ignore"):  # a NaN may be one that warns
        values: Array = np.asarray(labels.values, float)
    part: tuple[slice, ...] = (slice(None),) * 3
    if labels.geometry is not None and volume.geometry is not None:
        qform, _ = geometry_from_affine(volume.geometry.qform_affine(volume.spacing)[:, [2, 1, 0, 3]], "LPS")
        places = (volume.geometry, replace(qform, convention=volume.geometry.convention))
        aligned = (_align_labels(labels, values, labels.geometry, volume, place) for place in places)
        found = next(filter(None, aligned), None)
        if found is None:
            raise ValueError(
                f"{name} lies elsewhere in space than {volume.source}: choose the labels of this volume, or "
                "save them without a place, as .npy or .tif."
            )
        values, part = found
    if values.shape != into[part].shape:
        has, wanted = (" x ".join(map(str, shape)) for shape in (labels.values.shape, volume.shape))
        raise ValueError(f"{name} has {has} voxels, but this volume has {wanted}: choose the labels of this volume.")
    into[part] += values


def _align_labels(
    labels: DecodedImage, values: Array, lies_at: Geometry, volume: Image, place: Geometry
) -> tuple[Array, tuple[slice, ...]] | None:
    """Turn the `values` of labels as a volume lies at a place, by its sform or qform; None if they lie elsewhere.

    Returns
    -------
    values : ndarray
        The values, in the axis order of the volume.
    part : tuple of slice
        The voxels that they are of.
    """
    from nibabel.orientations import apply_orientation, inv_ornt_aff, io_orientation

    part: tuple[slice, ...] = (slice(None),) * 3
    spacing = labels.spacing
    if len(values) == 1:  # a slice, as thick as those of the volume
        across = lies_at.affine((1.0, 1.0, 1.0), "LPS")[:3, 0]
        thick = np.abs(np.linalg.solve(place.affine(volume.spacing, "LPS")[:3, :3], across)).max()
        spacing = (1.0 / float(thick), *spacing[1:])
    measured = labels.unit == volume.unit and np.allclose(sorted(spacing), sorted(volume.spacing), rtol=1e-3)
    sides = (spacing, volume.spacing) if measured else 2 * ((1.0, 1.0, 1.0),)  # else spacings were set by hand
    to_volume = np.linalg.solve(place.affine(sides[1], "LPS"), lies_at.affine(sides[0], "LPS"))
    turn = io_orientation(to_volume)
    lies = to_volume @ inv_ornt_aff(turn, values.shape)
    values, most = apply_orientation(values, turn), _MAX_MISALIGNMENT
    first = np.rint(lies[:3, 3]).astype(int)
    last = first + values.shape
    if measured and values.shape != volume.shape and (first >= 0).all() and (last <= volume.shape).all():
        lies[:3, 3] -= first
        part, most = tuple(map(slice, first, last)), _MAX_PART_MISALIGNMENT
    aside = np.abs(lies - np.eye(4))[:3]
    return (values, part) if (aside @ [*volume.shape, 1.0 if measured else 0.0]).max() <= most else None
