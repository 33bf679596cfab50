"""Labels lie on their image for ITK, which ITK-SNAP, 3D Slicer and MITK read files with, whatever both come from."""

import csv

import nrrd
import numpy as np
import pytest
import SimpleITK
import tifffile
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from cpm_core import export, load_volume, to_bytes
from tests.core.formats.images.made import (
    ACROSS,
    OBLIQUE,
    VALUES,
    affine,
    write_metaimage,
    write_nifti,
    write_series,
    write_slice,
)

SimpleITK.ProcessObject.SetGlobalWarningDisplay(False)

SIDES = (0.5, 0.75, 2.0)
NEAR = 0.01
"""How far labels may lie from their image [mm]."""

QUATERNION_ERROR = 0.05
"""How far labels may lie from an image that a NIfTI turns by about half a turn, whose quaternion of 32 bits gives the
angle to some 0.001 only [voxels]."""

LABELS = np.zeros(VALUES.shape, np.uint8)
LABELS[2:7, 3:9, 4:12] = 3
CORNERS = np.array(np.meshgrid(*([0.0, side - 1.0] for side in VALUES.shape[::-1]))).reshape(3, -1).T
OTHER = affine(turn=Rotation.from_euler("xyz", (25, -30, 100), degrees=True).as_matrix(), origin=(3.0, -12.0, 20.0))
HEIGHTS = np.arange(len(VALUES)) * 2.0


def write_source(kind, folder):
    """An image with a place, and the path of all of its files."""
    path = folder / kind
    if kind.startswith("nifti"):
        codes = {"qform": (0, 1), "sform": (2, 0), "same": (1, 1), "both": (1, 2)}[kind.split()[1]]
        path = folder / "image.nii.gz"
        image = write_nifti(path)
        image.set_sform(affine(), codes[0])
        image.set_qform(OTHER if kind == "nifti both" else affine(), codes[1])
        image.header.set_xyzt_units("mm")
        image.to_filename(path)
    elif kind == "nrrd":
        path = folder / "image.nrrd"
        head = {"space": "right-anterior-superior", "kinds": ["domain"] * 3}
        head |= {"space directions": affine()[:3, :3].T, "space origin": affine()[:3, 3]}
        nrrd.write(str(path), VALUES.T, head)
    elif kind == "metaimage":
        path = folder / "image.mha"
        write_metaimage(path)
    elif kind == "tiff":
        path = folder / "image.tif"
        tags = {"resolution": (5000.0, 2500.0), "resolutionunit": "CENTIMETER", "metadata": None}
        tifffile.imwrite(path, VALUES, photometric="minisblack", **tags)
    else:
        write_series(path, HEIGHTS, OBLIQUE if kind == "dicom turned" else ACROSS)
    return path


def find_place(path):
    """The affine matrix by which ITK reads a file or a series, from (col, row, plane) to LPS."""
    reader = SimpleITK.ImageFileReader()
    if path.is_dir():
        reader = SimpleITK.ImageSeriesReader()
        reader.SetFileNames(reader.GetGDCMSeriesFileNames(str(path)))
    else:
        reader.SetFileName(str(path))
    image = reader.Execute()
    matrix = np.array(image.GetDirection()).reshape(3, 3) * image.GetSpacing()
    return matrix, np.array(image.GetOrigin()), SimpleITK.GetArrayFromImage(image)


def measure_distance(one, other):
    """The largest distance between the corners of two volumes in space."""
    (turn, origin, _), (turned, moved, _) = one, other
    return np.linalg.norm(CORNERS @ (turn - turned).T + origin - moved, axis=1).max()


@pytest.mark.parametrize("suffix", [".nii", ".nii.gz", ".nrrd", ".seg.nrrd"])
@pytest.mark.parametrize(
    "kind",
    ["nifti qform", "nifti sform", "nifti same", "nifti both", "nrrd", "metaimage", "dicom across", "dicom turned"],
)
def test_labels_lie_on_their_image(tmp_path, kind, suffix):
    source, target = write_source(kind, tmp_path), tmp_path / f"labels{suffix}"
    image = load_volume(source)
    export(LABELS, target, image=image)
    here, there = find_place(source), find_place(target)
    assert np.array_equal(there[2], LABELS)
    apart = measure_distance(here, there)
    assert apart < NEAR or any("in other files only the sform" in note for note in image.notes)
    assert apart < NEAR or not suffix.startswith(".nii")


@pytest.mark.parametrize("suffix", [".nii", ".nrrd"])
def test_labels_of_a_tiff_have_its_pixels(tmp_path, suffix):
    source, target = write_source("tiff", tmp_path), tmp_path / f"labels{suffix}"
    export(LABELS, target, image=load_volume(source))
    (here, origin, _), (there, moved, found) = find_place(source), find_place(target)
    assert np.array_equal(found, LABELS)
    np.testing.assert_allclose(there[:, :2], here[:, :2], rtol=1e-5)
    assert origin.tolist() == moved.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("angle", [-20.0, 3.0, 15.0])
def test_labels_of_a_tilted_gantry_lie_on_its_slices_or_it_is_told_how_far_away(tmp_path, angle):
    lean, told = np.radians(angle), []
    along = ((1.0, 0.0, 0.0), (0.0, np.cos(lean), np.sin(lean)))
    (tmp_path / "series").mkdir()
    for number, height in enumerate(HEIGHTS):
        place = (-20.0, 10.0, 5.0 + height)
        write_slice(tmp_path / "series" / f"{number:03}.dcm", VALUES[number], place, along, number=number + 1)
    exact = np.transpose([np.array(along[0]) * 0.5, np.array(along[1]) * 0.75, (0.0, 0.0, 2.0)])
    targets = [tmp_path / "labels.nrrd", tmp_path / "labels.nii.gz"]
    export(LABELS, *targets, image=load_volume(tmp_path / "series"), warn=told.append)
    straight, apart = (measure_distance((exact, (-20.0, 10.0, 5.0), LABELS), find_place(file)) for file in targets)
    assert straight < NEAR
    assert len(told) == 1
    assert f"up to {apart:.3g} mm beside" in told[0]


@given(
    arrays(float, 3, elements=st.floats(-180, 180)),
    arrays(float, 3, elements=st.floats(-500, 500)),
    arrays(float, 3, elements=st.floats(0.05, 8.0)),
    st.sampled_from([(0, 1), (1, 0), (4, 2)]),
)
@settings(max_examples=25, deadline=None)
def test_labels_lie_on_a_nifti_that_is_turned_in_any_way(tmp_path_factory, angles, origin, sides, codes):
    folder = tmp_path_factory.mktemp("turned")
    matrix = affine(sides, Rotation.from_euler("xyz", angles, degrees=True).as_matrix(), origin)
    image = write_nifti(folder / "a.nii", matrix=matrix)
    image.set_sform(matrix, codes[0])
    image.set_qform(matrix, codes[1])
    image.to_filename(folder / "a.nii")
    export(LABELS, folder / "l.nii", folder / "l.nrrd", image=load_volume(folder / "a.nii"))
    here = find_place(folder / "a.nii")
    for name in ("l.nii", "l.nrrd"):
        assert measure_distance(here, find_place(folder / name)) < NEAR + QUATERNION_ERROR * sides.max()


def test_the_table_has_centers_in_space_where_itk_has_them(tmp_path):
    source = write_source("nrrd", tmp_path)
    image = load_volume(source)
    (row,) = csv.DictReader(to_bytes(LABELS, ".table.csv", image=image).decode().splitlines())
    read = SimpleITK.ReadImage(str(source))
    labels = SimpleITK.GetImageFromArray(LABELS)
    labels.CopyInformation(read)
    shapes = SimpleITK.LabelShapeStatisticsImageFilter()
    shapes.Execute(labels)
    center = [float(row[f"{axis}_LPS_mm"]) for axis in "xyz"]
    np.testing.assert_allclose(center, shapes.GetCentroid(3), atol=NEAR)
    np.testing.assert_allclose(float(row["volume_mm3"]), shapes.GetPhysicalSize(3), rtol=1e-5)
