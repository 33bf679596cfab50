"""Surfaces as other programs write them: polygons, text or binary, either order of bytes, more than is needed."""

import struct

import numpy as np
import pytest

from cpm_core.formats.surface_file import decode_surface

CUBE = np.array([(x, y, z) for z in (0, 3) for y in (0, 3) for x in (0, 3)], float) + 1.0
SQUARES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = [(a, *pair) for a, b, c, d in SQUARES for pair in ((b, c), (c, d))]


def check(content, name):
    surface, _ = decode_surface(content, name)
    assert surface.closed and len(surface.faces) == 12
    assert surface.volume == pytest.approx(27.0)
    assert sorted(map(tuple, surface.vertices.tolist())) == sorted(map(tuple, CUBE[:, ::-1].tolist()))


def test_ply_as_text_with_colors_and_polygons():
    head = (
        "ply\r\nformat ascii 1.0\r\ncomment SPACE=LPS\r\nelement vertex 8\r\nproperty float x\r\nproperty float y\r\n"
        "property float z\r\nproperty uchar red\r\nelement face 6\r\nproperty list uchar int vertex_index\r\n"
        "property float quality\r\nelement edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\nend_header\r\n"
    )
    rows = [*(f"{x} {y} {z} 200" for x, y, z in CUBE), *(f"4 {a} {b} {c} {d} .5" for a, b, c, d in SQUARES), "0 1"]
    check((head + "\r\n".join(rows)).encode(), "cube.ply")


@pytest.mark.parametrize(("name", "order"), [("little", "<"), ("big", ">")])
def test_ply_in_either_order_of_bytes_with_polygons_of_several_kinds(name, order):
    polygons = [*SQUARES[:4], *TRIANGLES[8:]]
    head = (
        f"ply\nformat binary_{name}_endian 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
        f"property double z\nelement face {len(polygons)}\nproperty uchar flags\n"
        "property list int32 uint32 vertex_indices\nend_header\n"
    )
    body = b"".join(struct.pack(f"{order}3d", *place) for place in CUBE)
    body += b"".join(struct.pack(f"{order}Bi{len(one)}I", 1, len(one), *one) for one in polygons)
    check(head.encode() + body, "cube.ply")


def test_stl_as_text():
    lines = ["solid cube"]
    for corners in CUBE[TRIANGLES]:
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x:e} {y} {z}" for x, y, z in corners), "endloop"]
        lines += ["endfacet"]
    check("\n".join([*lines, "endsolid cube"]).encode(), "cube.stl")


def test_stl_whose_header_begins_like_text_is_binary():
    corners = CUBE[TRIANGLES].astype("<f4")
    body = b"".join(bytes(12) + corner.tobytes() + bytes(2) for corner in corners)
    check(b"solid by another program".ljust(80) + struct.pack("<I", 12) + body, "cube.stl")


def test_obj_with_textures_polygons_and_places_from_the_end():
    lines = ["mtllib a.mtl", "o cube", *(f"v {x} {y} {z} 1 0 0" for x, y, z in CUBE), "vt 0 0", "l 1 2"]
    lines += ["usemtl red", *(f"f {a + 1}/1 {b + 1}/1 {c + 1}/1 {d - 8}/1" for a, b, c, d in SQUARES)]
    check("\n".join(lines).encode(), "cube.obj")


def test_vtk_as_text_with_lines_and_polygons():
    places = "\n".join(f"{x} {y} {z}" for x, y, z in CUBE)
    squares = "\n".join("4 " + " ".join(map(str, square)) for square in SQUARES)
    text = f"# vtk DataFile Version 4.2\ncube\nASCII\nDATASET POLYDATA\nPOINTS 8 float\n{places}\n"
    text += f"LINES 1 3\n2 0 1\nPOLYGONS 6 30\n{squares}\nPOINT_DATA 8\nSCALARS a float 1\n"
    check(text.encode(), "cube.vtk")


def test_vtk_of_version_five_is_read():
    squares = np.array(SQUARES)
    parts = [
        b"# vtk DataFile Version 5.1\ncube SPACE=LPS\nBINARY\nDATASET POLYDATA\nPOINTS 8 double\n",
        CUBE.astype(">f8").tobytes(),
        b"\nMETADATA\nINFORMATION 0\n\nPOLYGONS 7 24\nOFFSETS vtktypeint64\n",
        np.arange(0, 25, 4).astype(">i8").tobytes(),
        b"\nCONNECTIVITY vtktypeint64\n",
        squares.astype(">i8").tobytes(),
        b"\nCELL_DATA 6\nPOINT_DATA 8\n",
    ]
    check(b"".join(parts), "cube.vtk")


def test_a_surface_that_is_turned_inside_out_is_turned_outward():
    rows = [*(f"v {x} {y} {z}" for x, y, z in CUBE), *(f"f {a + 1} {c + 1} {b + 1}" for a, b, c in TRIANGLES)]
    check("\n".join(rows).encode(), "cube.obj")
