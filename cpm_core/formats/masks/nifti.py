"""NIfTI: the label mask for ITK-SNAP and other programs of radiology, by nibabel."""

from __future__ import annotations

import gzip
from collections.abc import Callable

from cpm_core.formats.common.provenance import PROGRAM_NAME, Outcome, describe_provenance, dump_provenance
from cpm_core.formats.images.nifti import measure_displacement
from cpm_core.formats.images.stack import MAX_SILENT_SLANT
from cpm_core.formats.masks.labels import paint_labels
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.numerics.types import Array, Sides

_NIFTI_UNITS = {
    "nm": ("micron", 1e-3),
    "µm": ("micron", 1.0),
    "mm": ("mm", 1.0),
    "cm": ("mm", 10.0),
    "m": ("meter", 1.0),
}
"""Unit -> unit of NIfTI, and the factor to it."""


def encode_nifti(result: Outcome, *, outlines: bool = False) -> bytes:
    """Encode the label mask of a result or a skeleton as NIfTI-1, columns first: one slice, or a volume.

    Its voxels coincide with those of the image. The qform is the nearest matrix at right angles, and of an image from a
    NIfTI both matrices and codes are those of its file. If the position is unknown, columns run to the patient's left,
    rows to the back and planes to the head, as in a picture opened without a position, so that mask and picture
    coincide. Micrometers, millimeters and meters are kept, other units converted to the nearest of them. Provenance is
    a comment after the header. ValueError when there is nothing to paint.
    """
    import nibabel

    mask = paint_labels(result, outlines=outlines)
    affine, unit = locate_mask(result, "RAS")
    image = nibabel.Nifti1Image(mask.reshape((1, *mask.shape)[-3:]).transpose(), affine)
    geometry = result.geometry or Geometry()
    image.set_sform(affine, geometry.codes[0])
    image.set_qform(locate_mask(result, "RAS", Geometry.qform_affine)[0], geometry.codes[1])
    image.header.set_xyzt_units(unit)
    image.header["descrip"] = f"label mask, {PROGRAM_NAME}"
    comment = nibabel.nifti1.Nifti1Extension("comment", dump_provenance(describe_provenance(result)).encode("ascii"))
    image.header.extensions.append(comment)
    return bytes(image.to_bytes())


def describe_displacement(result: Outcome) -> str:
    """Describe how far from a slanted image programs that require right angles show its labels; empty if nowhere."""
    import nibabel

    geometry = result.geometry
    if geometry is None or geometry.to_qform is not None or geometry.slant <= MAX_SILENT_SLANT:
        return ""
    affine, _ = locate_mask(result, "RAS")
    header = nibabel.Nifti1Header()
    header.set_qform(affine)
    apart = measure_displacement(header.get_qform() - affine, (1, *result.shape)[:-4:-1])
    return (
        f"The axes of {result.source} are not at right angles, so that ITK-SNAP and other programs show labels in a "
        f"NIfTI up to {apart:.3g} {result.unit} beside it: .nrrd keeps their place."
    )


def locate_mask(
    result: Outcome, space: Convention, to_affine: Callable[[Geometry, Sides, Convention], Array] = Geometry.affine
) -> tuple[Array, str]:
    """Locate the mask of a result in space, columns first; by the qform with `Geometry.qform_affine`.

    Returns
    -------
    affine : ndarray, shape (4, 4)
        Maps (col, row, plane, 1) to (x, y, z, 1) in `space`.
    unit : str
        Unit of NIfTI.
    """
    unit, factor = _NIFTI_UNITS.get(result.unit or "", ("unknown", 1.0))
    geometry = (result.geometry or Geometry(depth=1.0 / factor)).scaled(factor)
    affine = to_affine(geometry, tuple(size * factor for size in result.spacing), space)
    return affine[:, [2, 1, 0, 3]], unit


def encode_nifti_gz(result: Outcome, *, outlines: bool = False) -> bytes:
    """Encode and compress; the same result always gives the same bytes."""
    return gzip.compress(encode_nifti(result, outlines=outlines), 6, mtime=0)
