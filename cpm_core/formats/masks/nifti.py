"""NIfTI: the label mask for ITK-SNAP and other programs of radiology, by nibabel."""

from __future__ import annotations

import gzip

from cpm_core.formats.common.provenance import PROGRAM_NAME, Outcome, describe_provenance, dump_provenance
from cpm_core.formats.masks.labels import paint_labels
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.numerics.types import Array

_NIFTI_UNITS = {
    "nm": ("micron", 1e-3),
    "µm": ("micron", 1.0),
    "mm": ("mm", 1.0),
    "cm": ("mm", 10.0),
    "m": ("meter", 1.0),
}
"""Unit -> unit of NIfTI, and the factor to it."""

_SCANNER_CODE = 1
"""Code of NIfTI for positions in the coordinates of the scanner."""

_MAX_SLANT = 0.05
"""Largest deviation of axes from right angles that a rotation can represent [degrees]."""


def encode_nifti(result: Outcome, *, outlines: bool = False) -> bytes:
    """Encode the label mask of a result or a skeleton as NIfTI-1, columns first: one slice, or a volume.

    Its voxels coincide with those of the image. If the position of that is unknown, columns run to the patient's left,
    rows to the back and planes to the head, as in a picture opened without a position, so that mask and picture
    coincide. Micrometers, millimeters and meters are kept, other units converted to the nearest of them. Provenance is
    a comment after the header. ValueError when there is nothing to paint.
    """
    import nibabel

    mask = paint_labels(result, outlines=outlines)
    affine, unit, slant = locate_mask(result, "RAS")
    image = nibabel.Nifti1Image(mask.reshape((1, *mask.shape)[-3:]).transpose(), affine)
    image.set_sform(affine, _SCANNER_CODE)
    image.set_qform(affine, _SCANNER_CODE if slant < _MAX_SLANT else 0)
    image.header.set_xyzt_units(unit)
    image.header["descrip"] = f"label mask, {PROGRAM_NAME}"
    comment = nibabel.nifti1.Nifti1Extension("comment", dump_provenance(describe_provenance(result)).encode("ascii"))
    image.header.extensions.append(comment)
    return bytes(image.to_bytes())


def locate_mask(result: Outcome, space: Convention) -> tuple[Array, str, float]:
    """Locate the mask of a result in space, columns first.

    Returns
    -------
    affine : ndarray, shape (4, 4)
        Maps (col, row, plane, 1) to (x, y, z, 1) in `space`.
    unit : str
        Unit of NIfTI.
    slant : float
        Deviation of the axes from right angles [degrees].
    """
    unit, factor = _NIFTI_UNITS.get(result.unit or "", ("unknown", 1.0))
    geometry = (result.geometry or Geometry(depth=1.0 / factor)).scaled(factor)
    affine = geometry.affine(tuple(size * factor for size in result.spacing), space)
    return affine[:, [2, 1, 0, 3]], unit, geometry.slant


def encode_nifti_gz(result: Outcome, *, outlines: bool = False) -> bytes:
    """Encode and compress; the same result always gives the same bytes."""
    return gzip.compress(encode_nifti(result, outlines=outlines), 6, mtime=0)
