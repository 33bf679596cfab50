"""Provenance: every file names the program, the image, its hash, the method and what it was given, and no time."""

import contextlib
import csv
import gzip
import hashlib
import io
import json
import re
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import ezdxf
import nibabel
import nrrd
import numpy as np
import PIL.Image
import pytest
import roifile
import tifffile
from pycocotools.coco import COCO

import cpm_core
from cpm_core import Image, Parameters, PlacedCharge, Regions, circle, load_image, objects_result, partition, to_bytes
from cpm_core.formats import CONTOURS_WRITABLE
from cpm_core.formats.common.provenance import VERSION, describe_provenance, flatten_provenance, record_drawn_shapes
from cpm_core.formats.writers import FIGURE_SUFFIXES
from cpm_core.parameters.provenance import Provenance
from cpm_core.shapes import Barrier, Circle, Points

from ..scenes import disk
from .drawn import CELL, RESULT
from .meshes.test_meshes import RESULT as IN_VOLUME

MADE = Provenance(
    "cpm",
    {"reach": 2.0, "smoothing": "auto", "scales": 3},
    seeds=64,
    shapes=({"shape": "circle", "center": [30.0, 35.0], "radius": 5.0},),
    scale=0,
    steered=True,
    sha256=hashlib.sha256(b"image").hexdigest(),
)
FOUND = replace(RESULT, provenance=MADE, source="cells <&> µ.png")
FACTS = describe_provenance(FOUND)
DISK = disk((64, 64), (32.0, 32.0), 20.0).values


def in_json(content):
    return json.loads(content)["provenance"]


def in_rows(content):
    return next(csv.DictReader(io.StringIO(content.decode(), newline="")))


def in_coco(content):
    made = COCO()
    made.dataset = json.loads(content)
    with contextlib.redirect_stdout(None):
        made.createIndex()
    return made.dataset["info"]["provenance"]


def in_drawing(content):
    return json.loads(ElementTree.fromstring(content).find("{http://www.w3.org/2000/svg}metadata").text)


def as_java(text):
    """What the properties of Java make of escapes."""
    return re.sub(r"\\u([0-9a-f]{4})", lambda found: chr(int(found.group(1), 16)), text)


def in_roi(content):
    lines = roifile.ImagejRoi.frombytes(content).props.splitlines()
    return dict(as_java(line.removeprefix("cpm_")).split(": ", 1) for line in lines)


def in_set(content):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        each = [in_roi(archive.read(name)) for name in archive.namelist()]
    assert all(told == each[0] for told in each)
    return each[0]


def in_dxf(content):
    assert not ezdxf.read(io.StringIO(content.decode())).audit().errors
    lines = content.decode().splitlines()
    told = [text for code, text in zip(lines[::2], lines[1::2], strict=True) if code == "999"]
    assert max(map(len, told)) < 256, "release 12 has no longer lines"
    whole = "\n".join(told).replace("\n  ", " ")
    return dict(as_java(line).split(": ", 1) for line in whole.splitlines())


def in_png(content):
    with PIL.Image.open(io.BytesIO(content)) as picture:
        assert picture.info["Software"] == f"CPM {VERSION}"
        return json.loads(picture.info["Description"])


def in_tiff(content):
    with tifffile.TiffFile(io.BytesIO(content)) as file:
        assert file.pages.first.software == f"CPM {VERSION}"
        assert "DateTime" not in file.pages.first.tags
        return dict(line.split(": ", 1) for line in file.imagej_metadata["Info"].splitlines())


def in_nifti(content):
    volume = nibabel.Nifti1Image.from_bytes(content)
    (comment,) = volume.header.extensions
    assert comment.get_code() == 6, "a text"
    assert volume.header["descrip"].item() == f"label mask, CPM {VERSION}".encode()
    return json.loads(comment.text)


def in_figure(content):
    if content.startswith(b"\x89PNG"):
        with PIL.Image.open(io.BytesIO(content)) as picture:
            return json.loads(picture.info["Description"])
    if content.startswith(b"%PDF"):
        subject = re.search(rb"/Subject \((.*?)(?<!\\)\)", content, re.DOTALL).group(1)
        return json.loads(re.sub(rb"\\([()\\])", rb"\1", subject))
    return json.loads(ElementTree.fromstring(content).find(".//{http://purl.org/dc/elements/1.1/}description").text)


READERS = {
    ".svg": in_drawing,
    ".csv": in_rows,
    ".measures.csv": in_rows,
    ".table.csv": in_rows,
    ".json": in_json,
    ".geojson": in_json,
    ".zip": in_set,
    ".roi": in_roi,
    ".labelme.json": in_json,
    ".coco.json": in_coco,
    ".png": in_png,
    ".tif": in_tiff,
    ".tiff": in_tiff,
    ".nii": in_nifti,
    ".nii.gz": lambda content: in_nifti(gzip.decompress(content)),
    ".nrrd": lambda content: json.loads(nrrd.read_header(io.BytesIO(content))["cpm"]),
    ".dxf": in_dxf,
    **dict.fromkeys(FIGURE_SUFFIXES, in_figure),
}
"""What a reader of each format finds: all facts, or their entries as texts."""


def told_by(result, suffix):
    only = replace(result, contours=(CELL,)) if suffix == ".roi" else result
    return READERS[suffix](to_bytes(only, suffix))


@pytest.mark.parametrize("suffix", CONTOURS_WRITABLE)
def test_every_format_tells_how_its_contours_were_found(suffix):
    told = told_by(FOUND, suffix)
    assert told == FACTS or flatten_provenance(FACTS).items() <= told.items()


@pytest.mark.parametrize("suffix", CONTOURS_WRITABLE)
def test_the_same_result_always_gives_the_same_bytes(suffix, monkeypatch):
    only = replace(FOUND, contours=(CELL,))
    first = to_bytes(only, suffix)
    monkeypatch.setattr("time.time", lambda: 2e9)
    assert to_bytes(only, suffix) == first


def test_no_folder_is_told_and_a_skeleton_has_its_own_parameters():
    assert describe_provenance(replace(FOUND, source="C:\\Users\\someone\\secret\\a.png"))["image"]["name"] == "a.png"
    facts = describe_provenance(cpm_core.skeleton(DISK))
    assert (facts["method"], facts["parameters"]["pruning"]) == ("skeleton", 1.0)
    assert "w1" not in facts["parameters"], "it has no effect"


def test_programs_that_know_no_quoted_cells_read_the_tables():
    facts = describe_provenance(
        record_drawn_shapes(FOUND, (Circle((30.0, 35.0), 5.0), Barrier(((1.0, 2.0), (3.0, 4.0)))))
    )
    texts = flatten_provenance(facts | {"stop_reason": 'stopped, as "asked"'})
    assert texts["shapes"] == "shape=circle center=30.0 35.0 radius=5.0; shape=barrier points=1.0 2.0 3.0 4.0"
    assert texts["parameters"] == "reach=2.0 smoothing=auto scales=3"
    assert not any("," in text for text in texts.values())
    for suffix in (".csv", ".measures.csv"):
        lines = to_bytes(record_drawn_shapes(FOUND, (Circle((30.0, 35.0), 5.0),)), suffix).decode().splitlines()
        assert {line.count(",") for line in lines} == {lines[0].count(",")}


def test_a_run_on_a_file_has_the_hash_of_its_bytes(tmp_path):
    PIL.Image.fromarray(DISK.astype(np.uint8)).save(tmp_path / "disk.png")
    image = load_image(tmp_path / "disk.png")
    result = cpm_core.segment(image, circle((32, 32), 10), Parameters(scales=1, beta=0.7), max_steps=3)
    facts = describe_provenance(result)
    assert facts["image"] == {
        "name": "disk.png",
        "sha256": hashlib.sha256((tmp_path / "disk.png").read_bytes()).hexdigest(),
    }
    assert facts["seeds"] == len(circle((32, 32), 10))
    assert (facts["scale"], facts["steps"], facts["stop_reason"]) == (0, 3, "stopped after 3 steps, as requested")
    assert facts["parameters"]["beta"] == 0.7
    assert (facts["program"], facts["version"]) == ("CPM", cpm_core.__version__)


def test_a_run_on_an_array_has_the_hash_of_its_gray_levels_and_tells_regions_and_charges():
    values = DISK
    barrier = ((5.0, 5.0), (5.0, 30.0))
    result = cpm_core.segment(
        values,
        circle((32, 32), 10),
        Parameters(scales=1),
        max_steps=2,
        regions=Regions(barriers=(barrier,)),
        charges=[PlacedCharge((4.0, 4.0), 1.0)],
    )
    facts = describe_provenance(result)
    assert facts["image"]["array_sha256"] == hashlib.sha256(values.astype("<f8").tobytes()).hexdigest()
    kinds = {shape["shape"]: shape for shape in facts["shapes"]}
    assert kinds["charge"]["strength"] == 1.0
    assert kinds["barrier"]["points"] == barrier


def test_what_was_drawn_is_told_and_many_points_by_their_number():
    shapes = (Circle((30.0, 35.0), 5.0), Barrier(((1.0, 2.0), (3.0, 4.0))), Points(tuple((n, n) for n in range(500))))
    told = describe_provenance(record_drawn_shapes(FOUND, shapes))["shapes"]
    assert [shape["shape"] for shape in told] == ["circle", "barrier", "points"]
    assert (told[0]["radius"], told[2]["positions"]) == (5.0, 500)


def test_objects_tell_their_clicks_and_their_image():
    image = Image(DISK, source="disk.png")
    chosen = partition(cpm_core.segment(image, circle((32, 32), 10), Parameters(scales=1))).select([(32, 32)])
    facts = describe_provenance(objects_result([chosen], image))
    assert facts["method"] == "objects"
    assert facts["shapes"] == [{"shape": "object", "inside": [[32.0, 32.0]], "outside": []}]
    assert facts["image"]["array_sha256"] == image.sha256


def test_files_of_surfaces_tell_it_as_far_as_they_have_room():
    result = replace(IN_VOLUME, provenance=MADE, particles=np.arange(9.0).reshape(3, 3))
    title = to_bytes(result, ".vtk").split(b"\n")[1].decode()
    assert f"IMAGE={MADE.sha256} METHOD=cpm " in title
    assert title.endswith(" reach=2.0 smoothing=auto")  # what is not the default
    begin = to_bytes(result, ".stl")[:80].decode().rpartition("IMAGE=")[2]
    assert len(begin) >= 40
    assert MADE.sha256.startswith(begin)
    rows = list(csv.DictReader(io.StringIO(to_bytes(result, ".points.csv").decode(), newline="")))
    told = flatten_provenance(describe_provenance(result))
    assert {name: rows[0][name] for name in told} == told
    assert not any(rows[1][name] for name in told)
