"""NIfTI: the label mask for ITK-SNAP and other programs of radiology, by nibabel."""

from __future__ import annotations

import gzip

from cpm_core.formats.common.provenance import PROGRAM, Outcome, facts_of, text_of
from cpm_core.formats.masks.labels import labels_of
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.numerics.types import Array

_UNITS = {
    "nm": ("micron", 1e-3),
    "µm": ("micron", 1.0),
    "mm": ("mm", 1.0),
    "cm": ("mm", 10.0),
    "m": ("meter", 1.0),
}
_SCANNER = 1
_SQUARE = 0.05
"""How far axes may be from right angles for a rotation to give their directions [degrees]."""


def encode(result: Outcome, *, outlines: bool = False) -> bytes:
    """Make a NIfTI-1 file, columns first, from the label mask of a result or a skeleton: one slice, or a volume.

    It lies where its image lies, voxel upon voxel. Where that is not known columns run to the patient's left, rows to
    the back and planes to the head, as in a picture that is opened without a position, so that mask and picture
    coincide. Micrometers, millimeters and meters are kept, other units converted to the nearest of them. How the labels
    were found is a comment behind the header. ValueError when there is nothing to paint.
    """
    import nibabel

    mask = labels_of(result, outlines=outlines)
    affine, unit, slant = placed(result, "RAS")
    image = nibabel.Nifti1Image(mask.reshape((1, *mask.shape)[-3:]).transpose(), affine)
    image.set_sform(affine, _SCANNER)
    image.set_qform(affine, _SCANNER if slant < _SQUARE else 0)
    image.header.set_xyzt_units(unit)
    image.header["descrip"] = f"label mask, {PROGRAM}"
    comment = nibabel.nifti1.Nifti1Extension("comment", text_of(facts_of(result)).encode("ascii"))
    image.header.extensions.append(comment)
    return bytes(image.to_bytes())


def placed(result: Outcome, space: Convention) -> tuple[Array, str, float]:
    """Where the mask of a result lies, columns first: a matrix of shape (4, 4), its unit, and how slanted its axes are.

    The unit is one of NIfTI.
    """
    unit, factor = _UNITS.get(result.unit or "", ("unknown", 1.0))
    geometry = (result.geometry or Geometry(depth=1.0 / factor)).scaled(factor)
    affine = geometry.affine(tuple(size * factor for size in result.spacing), space)
    return affine[:, [2, 1, 0, 3]], unit, geometry.slant


def encode_packed(result: Outcome, *, outlines: bool = False) -> bytes:
    """Compress what `encode` makes; the same result always gives the same bytes."""
    return gzip.compress(encode(result, outlines=outlines), 6, mtime=0)
