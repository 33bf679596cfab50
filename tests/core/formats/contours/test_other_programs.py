"""Contours that other programs write: selections of ImageJ, annotations of QuPath, labelme and COCO, drawings."""

import base64
import contextlib
import io
import json
import struct
import zipfile

import ezdxf
import numpy as np
import PIL.Image
import pytest
import shapely
from pycocotools import mask as coco_mask
from roifile import ROI_OPTIONS, ROI_SUBTYPE, ROI_TYPE, ImagejRoi

from cpm_core import Image
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.formats import to_bytes
from cpm_core.formats.contour_file import decode_contours, describe_plane, load_contours
from cpm_core.formats.contours.contents import PlaneInfo
from cpm_core.formats.ground_truth_file import load_truth
from cpm_core.results import boundaries_result

NEAR = 0.02
"""Distance up to which lines stand for curves [px]."""


def read(content, name):
    """The file with this content."""
    if not isinstance(content, (str, bytes)):
        content = json.dumps(content)
    return decode_contours(content if isinstance(content, bytes) else content.encode(), name)


def only(content, name):
    (contour,) = read(content, name).contours
    return contour


# ImageJ


def selection(kind, **fields):
    return ImagejRoi(version=228, roitype=kind, **fields).tobytes()


def test_rectangles_ovals_and_lines_of_imagej_lie_where_it_draws_them():
    box = only(selection(ROI_TYPE.RECT, left=10, top=20, right=30, bottom=25, name="box"), "a.roi")
    assert (box.closed, box.area, box.name) == (True, 100.0, "box")
    assert box.points.min(axis=0).tolist() == [19.5, 9.5]
    oval = only(selection(ROI_TYPE.OVAL, left=10, top=20, right=30, bottom=30), "a.roi")
    assert oval.area == pytest.approx(np.pi * 10 * 5, rel=0.01)
    np.testing.assert_allclose(oval.points.mean(axis=0), (24.5, 19.5), atol=1e-6)
    line = only(selection(ROI_TYPE.LINE, x1=3.0, y1=4.0, x2=6.0, y2=8.0), "a.roi")
    assert (line.closed, line.points.tolist()) == (False, [[4.0, 3.0], [8.0, 6.0]])


def test_turned_ellipses_and_rectangles_of_imagej_are_read_by_their_axes():
    fields = {"x1": 20.0, "y1": 40.0, "x2": 60.0, "y2": 40.0}
    content = bytearray(selection(ROI_TYPE.FREEHAND, subtype=ROI_SUBTYPE.ELLIPSE, **fields))
    content[52:56] = struct.pack(">f", 0.5)
    ellipse = only(bytes(content), "a.roi")
    assert ellipse.area == pytest.approx(np.pi * 20 * 10, rel=0.002)
    content = bytearray(selection(ROI_TYPE.FREEHAND, subtype=ROI_SUBTYPE.ROTATED_RECT, **fields))
    content[52:56] = struct.pack(">f", 6.0)
    assert only(bytes(content), "a.roi").area == pytest.approx(40 * 6)


def test_polygons_freehand_lines_and_points_of_imagej_are_told_apart():
    corners = np.array([[5, 5], [25, 5], [25, 15]])
    closed = ImagejRoi.frompoints(corners)
    closed.roitype, closed.options = ROI_TYPE.POLYGON, ROI_OPTIONS(0)
    assert only(closed.tobytes(), "a.roi").area == pytest.approx(100.0)
    closed.roitype = ROI_TYPE.FREELINE
    assert not only(closed.tobytes(), "a.roi").closed
    closed.roitype = ROI_TYPE.POINT
    assert len(read(closed.tobytes(), "a.roi").points) == 3


def test_composite_selections_of_imagej_are_objects_with_holes():
    def ring(low, high):
        corners = [(low, low), (high, low), (high, high), (low, high)]
        return [number for step, corner in zip((0, 1, 1, 1), corners, strict=True) for number in (step, *corner)] + [4]

    path = np.array([*ring(10, 50), *ring(20, 30), *ring(60, 70)], np.float32)
    roi = selection(
        ROI_TYPE.RECT, left=10, top=10, right=70, bottom=70, shape_roi_size=len(path), multi_coordinates=path
    )
    found = read(roi, "a.roi").contours
    assert [(one.area, one.hole) for one in found] == [(1600.0, False), (100.0, True), (100.0, False)]
    assert len({one.group for one in found}) == 1


def test_sets_of_selections_tell_names_colors_pages_and_what_else_they_hold():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for page in (1, 2):
            fields = {
                "left": 0,
                "top": 0,
                "right": 9,
                "bottom": 9,
                "position": page,
                "stroke_color": b"\xff\x01\x02\x03",
            }
            archive.writestr(f"spot {page}.roi", selection(ROI_TYPE.RECT, **fields))
        archive.writestr("notes.txt", "x")
    found = read(stream.getvalue(), "set.zip")
    assert [(one.name, one.color) for one in found.contours] == [("spot 1", "#010203"), ("spot 2", "#010203")]
    assert found.notes == (
        "The contours lie on 2 pages, and those of all were taken.",
        "Left out: file of the set that is no selection (1).",
    )
    second = decode_contours(stream.getvalue(), "set.zip", page=2)
    assert [one.name for one in second.contours] == ["spot 2"]
    with pytest.raises(ValueError, match="none on page 5"):
        decode_contours(stream.getvalue(), "set.zip", page=5)


# QuPath


def qupath(properties):
    ring = [[1, 1], [9, 1], [9, 9], [1, 1]]
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


@pytest.mark.parametrize(
    ("properties", "name", "shade"),
    [
        ({"classification": {"name": "Tumor", "colorRGB": -3670016}}, "Tumor", "#c80000"),
        ({"name": "c7", "color": [1, 2, 3], "classification": {"name": "x", "color": [200, 0, 0]}}, "c7", "#010203"),
        ({"classification": "Stroma"}, "Stroma", ""),
        ({"objectType": "annotation"}, "", ""),
    ],
)
def test_classes_and_colors_of_qupath_are_read(properties, name, shade):
    contour = only(qupath(properties), "a.geojson")
    assert (contour.name, contour.color) == (name, shade)


@pytest.mark.parametrize(
    "given",
    [{"names": ["Tumor", "Positive"]}, {"name": "Tumor: Positive"}, ["Tumor", "Positive"], "Tumor: Positive"],
)
def test_derived_classes_of_qupath_are_read_and_written_back(given):
    one = only(qupath({"classification": given}), "a.geojson")
    assert (one.name, one.category) == ("Tumor: Positive", "Tumor: Positive")
    written = json.loads(to_bytes(boundaries_result((40, 40), "a", contours=(one,)), ".geojson"))
    assert written["features"][0]["properties"]["classification"]["name"] == "Tumor: Positive"


def test_the_nucleus_of_a_cell_of_qupath_is_told():
    cell = qupath({}) | {"nucleusGeometry": qupath({})["geometry"]}
    found = read({"type": "FeatureCollection", "features": [cell, cell]}, "a.geojson")
    assert len(found.contours) == 2
    assert found.notes == ("Left out: nucleus of a cell (2).",)


# COCO

DISK = np.hypot(*np.mgrid[-20:21, -25:26]) < 15.5
DISK[18:23, 20:26] = False


def coco(segmentation, **more):
    return {
        "images": [{"id": 7, "file_name": "a.png", "height": 41, "width": 51}, {"id": 8, "file_name": "b.png"}],
        "categories": [{"id": 3, "name": "cell"}],
        "annotations": [{"id": 1, "image_id": 7, "category_id": 3, "segmentation": segmentation}],
        **more,
    }


@pytest.mark.parametrize("compressed", [True, False])
def test_run_length_masks_of_coco_are_read(compressed):
    packed = coco_mask.encode(np.asfortranarray(DISK.astype(np.uint8)))
    counts = packed["counts"].decode()
    if not compressed:
        flat = DISK.T.ravel()
        bounds = np.flatnonzero(np.diff(flat, prepend=0, append=0))
        counts = np.diff([0, *bounds, flat.size]).tolist()
    found = read(coco({"size": list(DISK.shape), "counts": counts}), "a.json")
    assert found.shape == DISK.shape
    assert [one.name for one in found.contours] == ["cell", "cell"]
    assert [one.hole for one in found.contours] == [False, True]
    np.testing.assert_array_equal(rasterize_labels(found.contours, DISK.shape) > 0, DISK)


def test_polygons_of_coco_are_read_and_other_images_told():
    other = {"id": 2, "image_id": 8, "category_id": 3, "segmentation": [[0, 0, 1, 0, 1, 1]]}
    content = coco([[1.5, 2.5, 11.5, 2.5, 11.5, 12.5]])
    content["annotations"] += [other, {"id": 3, "image_id": 7, "category_id": 3, "bbox": [0, 0, 1, 1]}]
    found = read(content, "a.json")
    assert [one.points.tolist() for one in found.contours] == [[[2, 1], [2, 11], [12, 11]]]
    assert found.notes == (
        "The file has instances of 2 images: those of a.png were read.",
        "Left out: instance without an outline (1).",
    )


IMAGES = [
    {"id": 11, "file_name": "train\\A 1.png", "height": 40, "width": 50},
    {"id": 12, "file_name": "train/b.tif", "height": 40, "width": 50, "extra": {"name": "before.jpg"}},
    {"id": "13", "file_name": "train/c.png", "height": 30, "width": 50},
    {"id": 139},
    {"id": 14, "file_name": "x/twice.png"},
    {"id": 15, "file_name": "y/twice.png"},
    {"id": 16, "file_name": "empty.png"},
]
"""Images of one file; each but the last has an instance whose first column is its place among them."""


def of_image(name, shape=(40, 50), images=IMAGES):
    """First column in the instances of an image, and the notes."""
    entries = [
        {"id": k, "image_id": image["id"], "segmentation": [[k + 0.5, 1, k + 9, 1, k + 9, 9]]}
        for k, image in enumerate(images)
        if image["id"] != 16
    ]
    content = json.dumps({"images": images, "annotations": entries}).encode()
    found = decode_contours(content, "many.json", PlaneInfo(shape, name=name))
    return found.contours[0].points[:, 1].min(), found.notes


@pytest.mark.parametrize(
    ("name", "place"),
    [("A 1.png", 0), ("a 1.PNG", 0), ("b.tif", 1), ("b.nii", 1), ("before.jpg", 1), ("000139.jpg", 3)],
)
def test_of_the_images_in_a_coco_file_that_at_hand_is_read(name, place):
    assert of_image(name) == (place, ())


def test_the_only_image_of_the_size_is_told_where_none_has_the_name():
    assert of_image("other.png", (30, 50), IMAGES[:3]) == (
        2,
        ("Its instances are those of train/c.png, not of other.png.",),
    )
    assert of_image("other.png", images=IMAGES[:1])[1] == (
        "Its instances are those of train\\A 1.png, not of other.png.",
    )


def test_another_size_under_the_name_is_told():
    assert of_image("c.png") == (2, ("Its image has 30 x 50 px, this one 40 x 50 px.",))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("other.png", "such as train.*1.png, but none named other.png"),
        ("twice.png", "has 2 images named twice.png"),
        ("empty.png", "but none of empty.png"),
    ],
)
def test_coco_files_that_do_not_tell_the_image_at_hand_are_refused(name, said):
    with pytest.raises(ValueError, match=said):
        of_image(name)


def test_the_truth_is_that_of_the_image_at_hand(tmp_path):
    file = tmp_path / "many.json"
    entry = {"id": 1, "image_id": 12, "segmentation": [[5, 5, 15, 5, 15, 15, 5, 15]]}
    file.write_text(json.dumps({"images": IMAGES, "annotations": [{**entry, "image_id": 11}, entry]}))
    truth = load_truth(file, (40, 50), name="b.tif")
    assert ((truth.labels > 0).sum(), truth.notes) == (100, ())
    assert "2 images" in load_truth(file, (40, 50)).notes[0]


# labelme


def shape(kind, points, **more):
    return {"label": kind, "points": points, "group_id": None, "shape_type": kind, "flags": {}, **more}


def picture(mask):
    stream = io.BytesIO()
    PIL.Image.fromarray(mask.astype(np.uint8) * 255).save(stream, "PNG")
    return base64.b64encode(stream.getvalue()).decode()


def test_all_shapes_of_labelme_are_read():
    shapes = [
        shape("polygon", [[1, 1], [9, 1], [9, 9]]),
        shape("rectangle", [[30.5, 25.5], [10.5, 20.5]]),
        shape("oriented_rectangle", [[20, 10], [30, 20], [20, 30], [10, 20]]),
        shape("circle", [[50.5, 50.5], [60.5, 50.5]]),
        shape("line", [[0.5, 0.5], [5.5, 5.5]]),
        shape("linestrip", [[0.5, 0.5], [5.5, 5.5], [7.5, 5.5]]),
        shape("point", [[3, 3]]),
        shape("points", [[3, 3], [4, 5]]),
        shape("mask", [[3.0, 2.0], [53.0, 42.0]], mask=picture(DISK)),
    ]
    found = read({"version": "6.3.1", "flags": {}, "shapes": shapes, "imageHeight": 90, "imageWidth": 80}, "a.json")
    by_name = {one.name: one for one in found.contours if one.name}
    assert by_name["rectangle"].area == 100.0
    assert by_name["oriented_rectangle"].area == pytest.approx(200.0)
    assert by_name["circle"].area == pytest.approx(np.pi * 100, rel=0.002)
    assert not by_name["linestrip"].closed
    assert len(found.points) == 3
    assert (found.shape, found.notes) == ((90, 80), ())
    masked = [one for one in found.contours if one.group]
    painted = np.zeros((90, 80), bool)
    painted[2:43, 3:54] = DISK
    np.testing.assert_array_equal(rasterize_labels(masked, (90, 80)) > 0, painted)


def test_shapes_of_labelme_that_are_not_known_are_told():
    shapes = [shape("line", [[0, 0], [5, 5]]), shape("sphere", [[0, 0], [5, 5]])]
    assert read({"shapes": shapes}, "a.json").notes == ("Left out: shape of the kind sphere (1).",)


def test_shapes_of_one_group_are_one_object():
    shapes = [shape("circle", [[30, 30], [50, 30]]), shape("circle", [[30, 30], [35, 30]])]
    for one in shapes:
        one["group_id"] = 4
    outer, inner = read({"shapes": shapes}, "a.json").contours
    assert (outer.hole, inner.hole, outer.group) == (False, True, inner.group)


# SVG


def drawing(body, attributes='viewBox="0 0 100 80"'):
    return f'<svg xmlns="http://www.w3.org/2000/svg" {attributes}>{body}</svg>'


def test_arcs_and_curves_of_paths_lie_on_their_circle_and_what_follows_a_closed_line_is_another():
    arcs = "M10.5 50.5 A40 40 0 0 1 90.5 50.5 C90.5 72.59 72.59 90.5 50.5 90.5 S10.5 72.59 10.5 50.5z l5 0 0 5"
    circle, line = read(drawing(f'<path d="{arcs}"/>'), "a.svg").contours
    assert (circle.closed, line.closed) == (True, False)
    np.testing.assert_allclose(np.hypot(*(circle.points - 50.0).T), 40.0, atol=0.05)
    np.testing.assert_allclose(line.points, [(50, 10), (50, 15), (55, 15)])


def test_shapes_groups_and_transformations_are_read_with_their_names_and_colors():
    body = (
        '<g transform="translate(10,0)" stroke="red"><g transform="scale(2)">'
        '<rect id="box" x="1" y="2" width="4" height="3"/></g>'
        '<circle cx="20.5" cy="30.5" r="5" style="stroke:#00ff00;fill:none"><title>disk</title></circle></g>'
        '<polyline points="1,1 2,2 3,1" fill="none"/><text x="1" y="2">a</text>'
        '<ellipse cx="50" cy="40" rx="8" ry="4" transform="rotate(90 50 40)" stroke="rgb(1,2,3)"/>'
        '<defs><rect width="9" height="9"/></defs>'
    )
    found = read(drawing(body), "a.svg")
    box, disk, line, ellipse = found.contours
    assert (box.name, box.color, box.area) == ("box", "#ff0000", 48.0)
    assert box.points[0].tolist() == [3.5, 11.5]
    assert (disk.name, disk.color) == ("disk", "#00ff00")
    np.testing.assert_allclose(disk.points.mean(axis=0), (30, 30), atol=1e-6)
    assert not line.closed
    assert np.ptp(ellipse.points[:, 0]) == pytest.approx(16, abs=NEAR)
    assert found.notes == ("Left out: text (1).",)


def test_a_drawing_of_another_size_is_scaled_to_the_image_of_the_same_shape():
    image = Image(np.zeros((160, 200)))
    body = '<rect x="0" y="0" width="50" height="80"/>'
    contour = decode_contours(drawing(body).encode(), "a.svg", describe_plane(image)).contours[0]
    assert contour.points.max(axis=0).tolist() == [159.5, 99.5]


# DXF


def cad(draw, version="R2010", units=0):
    document = ezdxf.new(version)
    document.units = units
    draw(document.modelspace())
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode(document.output_encoding)


HUNDRED = describe_plane(Image(np.zeros((100, 100))))


@pytest.mark.parametrize(("add", "closed"), [
    (lambda m: m.add_line((5, 5), (60, 40)), False),
    (lambda m: m.add_lwpolyline([(10, 10, 0, 0, 0.4), (50, 12, 0, 0, -0.7), (20, 55, 0, 0, 1)], close=True), True),
    (lambda m: m.add_circle((50, 40), 20, dxfattribs={"extrusion": (0, 0, -1)}), True),
    (lambda m: m.add_open_spline([(10, 10), (30, 60), (50, 20), (70, 70), (80, 30)], 3), False),
])  # fmt: skip
def test_entities_of_cad_run_where_ezdxf_finds_them(add, closed):
    made = []
    (contour,) = decode_contours(cad(lambda space: made.append(add(space))), "a.dxf", HUNDRED).contours
    places = np.array([(99.5 - y, x - 0.5) for x, y, _ in ezdxf.path.make_path(made[0]).flattening(0.001)])
    assert shapely.LineString(contour.path).hausdorff_distance(shapely.LineString(places)) < 2 * NEAR
    assert contour.closed == closed


def test_units_layers_and_colors_of_cad_are_read():
    def draw(space):
        space.doc.layers.add("nuclei", color=1)
        space.add_circle((1.0, 2.0), 0.5, dxfattribs={"layer": "nuclei"})
        space.add_circle((2.0, 2.0), 0.5, dxfattribs={"color": 5})
        space.add_circle((3.0, 2.0), 0.5).rgb = (1, 2, 3)
        space.add_text("scale")
        space.add_point((1.0, 1.0))

    image = Image(np.zeros((40, 50)), (100.0, 100.0), "µm")
    found = decode_contours(cad(draw, units=ezdxf.units.MM), "a.dxf", describe_plane(image))
    first, second, third = found.contours
    assert [one.color for one in found.contours] == ["#ff0000", "#0000ff", "#010203"]
    assert [one.name for one in found.contours] == ["nuclei", "", ""]
    np.testing.assert_allclose(
        [one.points.mean(axis=0) for one in (first, second, third)],
        [(19.5, 9.5), (19.5, 19.5), (19.5, 29.5)],
        atol=1e-6,
    )
    assert np.ptp(first.points[:, 1]) == pytest.approx(10.0, abs=NEAR)
    assert found.notes == ("Left out: entity TEXT (1).",)
    np.testing.assert_allclose(found.points, [(29.5, 9.5)])


def test_a_drawing_without_an_image_tells_that_its_own_height_is_taken():
    content = cad(lambda space: space.add_line((0, 0), (10, 20)))
    assert "does not state the height" in " ".join(read(content, "a.dxf").notes)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.zip", b"PK\x03\x04 broken"),
        ("a.roi", b"Iout\x00"),
        ("a.svg", "<svg"),
        ("a.svg", "<html/>"),
        ("a.dxf", "0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nx\n"),
        ("a.dxf", "hello"),
        ("a.json", {"images": [], "annotations": [{"image_id": 1}]}),
        ("a.json", coco({"size": [4, 4], "counts": [3, 5]})),
        ("a.json", {"shapes": [shape("mask", [[0, 0], [3, 3]], mask="!")]}),
    ],
)
def test_damaged_files_are_refused_in_a_sentence(name, content):
    with pytest.raises(ValueError, match=name) as caught:
        read(content, name)
    assert str(caught.value).endswith(".")


def test_a_file_that_is_not_there_or_no_text_is_refused(tmp_path):
    with contextlib.chdir(tmp_path):
        for name in ("a.roi", "a.png", "a.xyz"):
            with pytest.raises(ValueError, match=rf"{name}.*does not exist"):
                load_contours(name)
        with pytest.raises(ValueError, match=r"a\.json is damaged"):
            read(b"\xff\xfe\x00", "a.json")
