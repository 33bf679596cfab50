"""NRRD: the label mask for 3D Slicer and other programs of radiology."""

from __future__ import annotations

import gzip

from cpm_core.formats.common.provenance import Outcome, facts_of, text_of
from cpm_core.formats.masks.labels import labels_of
from cpm_core.formats.masks.nifti import placed
from cpm_core.numerics.types import Array


def encode(result: Outcome, *, outlines: bool = False) -> bytes:
    """Make a packed NRRD file, columns first, from the label mask of a result or a skeleton: one slice, or a volume.

    It lies where its image lies, as that of NIfTI; see `nifti.placed`. How the labels were found is a key of it. The
    same result always gives the same bytes. ValueError when there is nothing to paint.
    """
    mask = labels_of(result, outlines=outlines)
    affine, unit, _ = placed(result, "LPS")
    head = {
        "type": mask.dtype.name,
        "dimension": "3",
        "sizes": " ".join(map(str, reversed((1, *mask.shape)[-3:]))),
        "encoding": "gzip",
        "endian": "little",
        "space": "left-posterior-superior",
        "space directions": " ".join(map(_vector, affine[:3, :3].T)),
        "space origin": _vector(affine[:3, 3]),
        "kinds": "domain domain domain",
    }
    if unit != "unknown":
        head["space units"] = " ".join([f'"{unit}"'] * 3)
    lines = ["NRRD0004", *(f"{name}: {value}" for name, value in head.items()), f"cpm:={text_of(facts_of(result))}", ""]
    content = gzip.compress(mask.astype(mask.dtype.newbyteorder("<")).tobytes(), mtime=0)
    return "\n".join([*lines, ""]).encode("ascii") + content


def _vector(values: Array) -> str:
    return f"({','.join(map(repr, values.tolist()))})"
