"""Samples of surfaces, center lines and points of volumes: own files, and those of other programs."""

from __future__ import annotations

import struct
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core import centerlines, export
from cpm_core.formats import CENTERLINES_WRITABLE, VOLUMES_WRITABLE
from tests.core.formats.meshes.test_meshes import RESULT

from .encoders import Sample

_CUBE = np.array([(x, y, z) for z in (0, 3) for y in (0, 3) for x in (0, 3)], float) + 1.0
_SQUARES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
_TRIANGLES = [(a, *pair) for a, b, c, d in _SQUARES for pair in ((b, c), (c, d))]
_PLACES = "\n".join(f"{x} {y} {z}" for x, y, z in _CUBE)
_FACES = "\n".join("4 " + " ".join(map(str, square)) for square in _SQUARES)
_PROPERTIES = "element vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 6\n"


def _own() -> list[Sample]:
    inside = np.zeros((12, 12, 40), bool)
    inside[4:9, 4:9, 4:36] = True
    found = replace(RESULT, particles=np.array([(1.0, 2.0, 3.25), (4.0, 5.0, 6.0)]))
    with tempfile.TemporaryDirectory() as folder:
        files = [
            Path(folder, f"a{suffix}") for suffix in (*VOLUMES_WRITABLE, *CENTERLINES_WRITABLE) if suffix != ".seg.dcm"
        ]
        for file in files:
            export(centerlines(inside) if file.suffix in CENTERLINES_WRITABLE else found, file)
        return [Sample(file.suffix, file.read_bytes()) for file in files]


def _of_others() -> list[Sample]:
    vertices = b"".join(struct.pack(">3f", *place) for place in _CUBE)
    squares = b"".join(struct.pack(">B4i", 4, *square) for square in _SQUARES)
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners)
        + "endloop\nendfacet\n"
        for corners in _CUBE[_TRIANGLES]
    )
    fifth = [
        b"# vtk DataFile Version 5.1\ncube SPACE=LPS\nBINARY\nDATASET POLYDATA\nPOINTS 8 double\n",
        _CUBE.astype(">f8").tobytes() + b"\nPOLYGONS 7 24\nOFFSETS vtktypeint64\n",
        np.arange(0, 25, 4).astype(">i8").tobytes() + b"\nCONNECTIVITY vtktypeint64\n",
        np.array(_SQUARES).astype(">i8").tobytes() + b"\n",
    ]
    ply = f"ply\nformat {{}} 1.0\n{_PROPERTIES}property list uchar int vertex_index\nend_header\n"
    vtk = f"# vtk DataFile Version 4.2\ncube\nASCII\nDATASET POLYDATA\nPOINTS 8 float\n{_PLACES}\n"
    texts = (
        (".ply", f"{ply.format('ascii')}{_PLACES}\n{_FACES}\n"),
        (".stl", f"solid cube\n{facets}endsolid cube\n"),
        (".obj", "v " + _PLACES.replace("\n", "\nv ") + "\nvt 0 0\nf 1/1 2/1 4/1 3/1\nf -1 -2 -3\nl 1 2\n"),
        (".vtk", f"{vtk}POLYGONS 6 30\n{_FACES}\nPOINT_DATA 8\nSCALARS a float 1\n"),
        (
            ".swc",
            "# a\n1 2 1 1 1 1 -1\n2 2 2 2 2 .5 1\n3 2 3 3 3 .5 2\n4 2 1 3 3 .5 2\n5 2 9 9 9 1 -1\n6 2 8 8 9 1 5\n",
        ),
        (".csv", "plane,row,col\n1,2,3\n4,5.5,6\n"),
    )
    return [
        *(Sample(suffix, text.encode()) for suffix, text in texts),
        Sample(".ply", ply.format("binary_big_endian").encode() + vertices + squares),
        Sample(".vtk", b"".join(fifth)),
    ]


def surfaces() -> list[Sample]:
    """The samples."""
    return [*_own(), *_of_others()]
