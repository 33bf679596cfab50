"""Size of a pixel: every spelling of a unit is the same length, and without a unit the ratio of the sides is kept."""

import nrrd
import numpy as np
import PIL.Image
import pytest
import tifffile
from hypothesis import given
from hypothesis import strategies as st

from cpm_core import load_image, load_volume
from cpm_core.formats.images.resolution import conversion_factor, find_unit, spacing_from_sizes

from .made import VALUES, affine, write_metaimage

SPELLINGS = {
    1e-12: ("pm", "picometer", "picometres"),
    1e-10: ("Å", "\u212b", "A\u030a", "angstrom", "Angstroms", "Ångström", "\\u00C5"),
    1e-9: ("nm", "NM", "nanometer", "nanometre", "nanometers", "Nanometres"),
    1e-6: ("um", "\u00b5m", "\u03bcm", "\\u00B5m", "\\u03bcm", "micron", "Microns", "micrometer", "Micrometers",
           "micrometre", "MICROMETRES", " um "),
    1e-3: ("mm", "MM", "millimeter", "millimetres"),
    1e-2: ("cm", "centimeter", "Centimetres"),
    0.0254: ("in", "in.", "inch", "Inches"),
    0.3048: ("ft", "foot", "feet"),
    1.0: ("m", "meter", "metres"),
    1e3: ("km", "kilometers"),
}  # fmt: skip
METERS = {name: meters for meters, names in SPELLINGS.items() for name in names}
UNKNOWN = ("", "pixel", "pixels", "reference frame", "bananas")
SIZES = st.floats(0.1, 10.0)


def in_meters(spacing, unit):
    return np.array(spacing) * conversion_factor(unit, "m")


@given(st.lists(st.tuples(SIZES, st.sampled_from(sorted(METERS))), min_size=1, max_size=3))
def test_sizes_in_any_units_become_lengths_in_one(sides):
    spacing, unit = spacing_from_sizes(*zip(*sides, strict=True))
    assert unit in ("nm", "µm", "mm", "cm", "m")
    np.testing.assert_allclose(in_meters(spacing, unit), [size * METERS[name] for size, name in sides], rtol=1e-12)


@given(st.lists(SIZES, min_size=1, max_size=3), st.sampled_from(UNKNOWN))
def test_without_a_known_unit_the_sides_keep_their_ratio(sizes, name):
    spacing, unit = spacing_from_sizes(sizes, [name] * len(sizes))
    assert (unit, spacing[-1]) == (None, 1.0)
    np.testing.assert_allclose(np.array(spacing) * sizes[-1], sizes)


@pytest.mark.parametrize("sizes", [(1.0, 0.0), (-1.0, 1.0), (np.nan, 1.0), (1.0, np.inf)])
def test_sizes_that_cannot_be_are_not_taken(sizes):
    assert spacing_from_sizes(sizes, ("mm", "mm")) == ((1.0, 1.0), None)


def test_a_side_without_a_unit_has_that_of_the_others_and_a_strange_one_leaves_none():
    assert spacing_from_sizes((3.0, 2.0), ("", "mm")) == ((3.0, 2.0), "mm")
    assert spacing_from_sizes((3.0, 2.0), ("pixel", "mm")) == ((1.0, 1.0), None)


def test_a_unit_of_an_argument_is_one_in_which_lengths_are_kept():
    assert [find_unit(name) for name in ("microns", "inch", "pixel")] == ["µm", None, None]


def write_ome(path, unit):
    sizes = {f"PhysicalSize{axis}{end}": value for axis in "ZYX" for end, value in (("", 0.5), ("Unit", unit))}
    tifffile.imwrite(path, VALUES, metadata={"axes": "ZYX", **sizes}, ome=True)


def write_imagej(path, unit):
    metadata = {"axes": "ZYX", "spacing": 0.5, "unit": "".join(c if c.isascii() else f"\\u{ord(c):04X}" for c in unit)}
    tifffile.imwrite(path, VALUES.astype(np.uint16), imagej=True, resolution=(2, 2), metadata=metadata)


def replace_unit(path, unit):
    path.write_bytes(path.read_bytes().replace(b"UNIT", unit.encode(), 3))


def write_nrrd(path, unit):
    vectors = {"space": "LPS", "space directions": np.diag([0.5] * 3), "space units": 3 * ["UNIT"]}
    nrrd.write(str(path), VALUES, vectors, index_order="C")
    replace_unit(path, unit)


def write_nrrd_without_a_place(path, unit):
    nrrd.write(str(path), VALUES, {"spacings": [0.5] * 3, "units": 3 * ["UNIT"]}, index_order="C")
    replace_unit(path, unit)


def write_mha(path, unit):
    write_metaimage(path, matrix=affine((0.5,) * 3), DistanceUnits="UNIT")
    replace_unit(path, unit)


WRITERS = {
    "a.ome.tif": write_ome,
    "b.tif": write_imagej,
    "c.nrrd": write_nrrd,
    "d.nrrd": write_nrrd_without_a_place,
    "e.mha": write_mha,
}


@pytest.mark.filterwarnings("ignore:datetime.datetime.utcnow:DeprecationWarning")
@pytest.mark.parametrize("unit", ["Å", "angstrom", "nm", "micron", "µm", "inch", "cm"])
@pytest.mark.parametrize("name", WRITERS)
def test_every_format_has_the_same_units(tmp_path, name, unit):
    WRITERS[name](tmp_path / name, unit)
    volume = load_volume(tmp_path / name)
    np.testing.assert_allclose(in_meters(volume.spacing, volume.unit), 3 * [0.5 * METERS[unit]], rtol=1e-6)


def test_a_place_is_in_the_unit_of_its_sizes(tmp_path):
    write_metaimage(tmp_path / "a.mha", DistanceUnits="angstrom")
    volume = load_volume(tmp_path / "a.mha")
    assert volume.unit == "nm"
    np.testing.assert_allclose(volume.geometry.affine(volume.spacing)[:3, [2, 1, 0, 3]], 0.1 * affine()[:3], atol=1e-12)


def test_axes_of_imagej_may_have_units_of_their_own(tmp_path):
    text = "ImageJ=1.54f\nimages=10\nslices=10\nunit=mm\nyunit=mm\nzunit=cm\nspacing=0.1\n"
    pixels = VALUES.astype(np.uint16)
    tifffile.imwrite(tmp_path / "a.tif", pixels, description=text, metadata=None, resolution=(4, 4))
    volume = load_volume(tmp_path / "a.tif")
    assert (volume.unit, volume.spacing) == ("mm", pytest.approx((1.0, 0.25, 0.25)))


@pytest.mark.parametrize("unit", ["pixel", None])
def test_a_stack_of_imagej_without_a_unit_keeps_the_ratio_of_its_sides(tmp_path, unit):
    metadata = {"axes": "ZYX", "spacing": 4.0} | ({"unit": unit} if unit else {})
    tifffile.imwrite(tmp_path / "a.tif", VALUES.astype(np.uint16), imagej=True, metadata=metadata, resolution=(1, 1),
                     resolutionunit="NONE")  # fmt: skip
    volume = load_volume(tmp_path / "a.tif")
    assert (volume.unit, volume.spacing) == (None, (4.0, 1.0, 1.0))


@pytest.mark.parametrize("kind", ["tif", "jpg"])
def test_a_resolution_without_a_unit_is_the_ratio_of_the_sides(tmp_path, kind):
    path = tmp_path / f"a.{kind}"
    if kind == "tif":
        tifffile.imwrite(path, VALUES[0], resolution=(3, 1), resolutionunit="NONE")
    else:
        PIL.Image.fromarray((VALUES[0] % 251).astype(np.uint8)).save(path, quality=95)
        content = bytearray(path.read_bytes())
        content[13:18] = bytes((0, 0, 3, 0, 1))  # unit, and densities along columns and rows
        path.write_bytes(content)
    image = load_image(path)
    assert (image.unit, image.spacing) == (None, pytest.approx((3.0, 1.0)))
