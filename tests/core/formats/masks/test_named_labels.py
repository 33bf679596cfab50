"""Label volumes with names and colors, as ITK-SNAP and 3D Slicer read and write them."""

import shlex
from dataclasses import replace

import nibabel
import nrrd
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Contour, Geometry, Image, Result, export, load_surface
from cpm_core.contours import join_surfaces, label_voxels
from cpm_core.contours.ground_truth import label_gray_levels, number_gray_levels
from cpm_core.contours.surface import surface_from_labels
from cpm_core.image.surface import Label

from ..images.made import write_metaimage

SHAPE, SPACING = (12, 14, 16), (2.0, 1.0, 0.5)
LABELS = np.zeros(SHAPE, np.int32)
LABELS[2:5, 3:6, 4:9] = 3
LABELS[6:10, 7:12, 9:14] = 7
LABELS[2:4, 9:12, 2:4] = 7
NAMES = (Label(3, 'left "kidney"', "#ff8000"), Label(7, "vein: a \\ b", "#0010ff"))
VOLUME = Image(np.arange(LABELS.size).reshape(SHAPE), SPACING, "mm", "ct.nii", geometry=Geometry((5.0, -6.0, 7.0)))


def result(labels=LABELS, names=NAMES):
    bodies = [(n, surface_from_labels((labels == n).astype(np.int32), SPACING, "mm")) for n in np.unique(labels)[1:]]
    surface = replace(join_surfaces(bodies, SPACING, "mm"), labels=names)
    return Result(np.empty((0, 3)), (), surface, 0, True, "", SHAPE, SPACING, "mm", "ct.nii", image=VOLUME)


def described(path):
    rows = [shlex.split(line) for line in path.read_text().splitlines() if not line.startswith("#")]
    assert all(len(row) == 8 and row[4:7] in (["1", "1", "1"], ["0", "0", "0"]) for row in rows)
    return {int(row[0]): (row[7], tuple(map(int, row[1:4]))) for row in rows}


@pytest.mark.parametrize("suffix", [".nii", ".nii.gz"])
def test_a_description_of_itk_snap_is_written_next_to_the_labels(tmp_path, suffix):
    export(result(), tmp_path / f"a{suffix}")
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"a{suffix}", "a.txt"]
    assert np.array_equal(np.asarray(nibabel.load(tmp_path / f"a{suffix}").dataobj).T, LABELS)
    assert described(tmp_path / "a.txt") == {
        0: ("Clear Label", (0, 0, 0)),
        3: ("left 'kidney'", (255, 128, 0)),  # a name ends at a quotation mark
        7: ("vein: a \\ b", (0, 16, 255)),
    }


def test_the_entries_of_slicer_name_the_segments(tmp_path):
    export(result(), tmp_path / "a.seg.nrrd")
    values, head = nrrd.read(str(tmp_path / "a.seg.nrrd"))
    assert np.array_equal(values.T, LABELS)
    assert head["Segmentation_SourceRepresentation"] == "Binary labelmap"
    for index, label in enumerate(NAMES):
        assert head[f"Segment{index}_Name"].replace("\\\\", "\\") == label.name
        assert (int(head[f"Segment{index}_LabelValue"]), int(head[f"Segment{index}_Layer"])) == (label.number, 0)
        color = [round(255 * float(part)) for part in head[f"Segment{index}_Color"].split()]
        assert f"#{bytes(color).hex()}" == label.color
        places = np.argwhere(label.number == LABELS)[:, ::-1]
        extent = np.array(head[f"Segment{index}_Extent"].split(), int).reshape(3, 2)
        assert np.array_equal(extent, np.stack([places.min(axis=0), places.max(axis=0)], axis=1))
    assert len({head[f"Segment{index}_ID"] for index in range(2)}) == 2


def test_slicerio_finds_the_segments_where_the_volume_lies(tmp_path):
    slicerio = pytest.importorskip("slicerio")
    export(result(), tmp_path / "a.seg.nrrd")
    found = slicerio.read_segmentation(str(tmp_path / "a.seg.nrrd"))
    assert [one["labelValue"] for one in found["segments"]] == [3, 7]
    assert found["segments"][0]["name"] == NAMES[0].name
    assert np.allclose(found["ijkToLPS"], VOLUME.geometry.affine(SPACING, "LPS")[:, [2, 1, 0, 3]])
    assert np.array_equal(found["voxels"].T, LABELS)


@pytest.mark.parametrize("name", ["a.nii.gz", "a.nii", "a.nrrd", "a.seg.nrrd"])
def test_labels_come_back_with_their_numbers_names_and_colors(tmp_path, name):
    export(result(names=(NAMES[0], Label(7, "Größe", "#0010ff"))), tmp_path / name)
    surface = load_surface(tmp_path / name, VOLUME)
    assert np.array_equal(label_voxels(surface, SHAPE), LABELS)
    assert [label.color for label in surface.labels] == ["#ff8000", "#0010ff"]
    assert [label.name.replace("'", '"') for label in surface.labels] == [NAMES[0].name, "Größe"]


@pytest.mark.parametrize("name", ["a.nii.gz", "a.seg.nrrd"])
def test_a_single_label_with_a_name_is_one_object_even_in_two_parts(tmp_path, name):
    alone = np.where(LABELS == 7, 7, 0).astype(np.int32)
    export(result(alone, NAMES[1:]), tmp_path / name)
    surface = load_surface(tmp_path / name, VOLUME)
    assert np.array_equal(label_voxels(surface, SHAPE), alone)


def test_contours_of_one_slice_are_named_too(tmp_path):
    square = np.array([(2.0, 2.0), (2.0, 9.0), (9.0, 9.0), (9.0, 2.0)])
    contours = (Contour(square, True, name="cell"), Contour(square + 12.0, True, color="#123456"))
    found = Result(np.empty((0, 2)), contours, None, 0, True, "", (30, 30), (1.0, 1.0), None, "a.png")
    export(found, tmp_path / "a.nii")
    names = described(tmp_path / "a.txt")
    assert (names[1][0], names[2]) == ("cell", ("Label 2", (0x12, 0x34, 0x56)))


def test_without_names_there_is_no_description(tmp_path):
    export(result(names=()), tmp_path / "a.nii.gz", tmp_path / "a.nrrd")
    assert not (tmp_path / "a.txt").exists()
    assert "Segment0_Name" not in nrrd.read_header(str(tmp_path / "a.nrrd"))


def test_another_text_is_not_replaced_and_nothing_is_written(tmp_path):
    (tmp_path / "a.txt").write_text("notes on the patient")
    with pytest.raises(ValueError, match=r"go into a\.txt, but this is another file"):
        export(result(), tmp_path / "a.nii")
    assert (tmp_path / "a.txt").read_text() == "notes on the patient"
    assert not (tmp_path / "a.nii").exists()
    (tmp_path / "a.txt").unlink()
    for names in (NAMES, NAMES[::-1]):  # a description is replaced, as the labels are
        export(result(names=names), tmp_path / "a.nii")


def test_segments_that_overlap_come_from_the_layers_of_slicer(tmp_path):
    one, other = LABELS == 3, np.zeros(SHAPE, bool)
    other[3:8, 4:9, 6:11] = True
    assert (one & other).any()
    layers = np.stack([one.T, other.T]).astype(np.uint8)
    matrix = VOLUME.geometry.affine(SPACING, "LPS")[:, [2, 1, 0, 3]]
    head = {
        "space": "left-posterior-superior",
        "kinds": ["list", "domain", "domain", "domain"],
        "space directions": np.vstack([np.full(3, np.nan), matrix[:3, :3].T]),
        "space origin": matrix[:3, 3],
    }
    for index, name in enumerate(["organ", "vessel"]):
        known = {"ID": f"S_{index}", "Name": name, "Color": "1 0.5 0", "LabelValue": "1", "Layer": str(index)}
        head |= {f"Segment{index}_{key}": value for key, value in known.items()}
    nrrd.write(str(tmp_path / "a.seg.nrrd"), layers, head)
    surface = load_surface(tmp_path / "a.seg.nrrd", VOLUME)
    assert [(label.number, label.name) for label in surface.labels] == [(1, "organ"), (2, "vessel")]
    for number, mask in ((1, one), (2, other)):
        alone = replace(surface, faces=surface.faces[surface.numbers == number], numbers=None)
        assert np.array_equal(label_voxels(alone, SHAPE) > 0, mask)


def test_labels_that_were_saved_without_their_margin_are_put_in_place(tmp_path):
    begin, end = (1, 2, 1), (11, 13, 15)
    part = LABELS[tuple(map(slice, begin, end))]
    there = VOLUME.geometry.starting_at(begin, SPACING).affine(SPACING, "RAS")[:, [2, 1, 0, 3]]
    nibabel.save(nibabel.Nifti1Image(part.T.astype(np.uint8), there), tmp_path / "part.nii")
    assert np.array_equal(label_voxels(load_surface(tmp_path / "part.nii", VOLUME), SHAPE), LABELS)
    there[:3, 3] -= 40.0  # beyond the volume
    nibabel.save(nibabel.Nifti1Image(part.T.astype(np.uint8), there), tmp_path / "part.nii")
    with pytest.raises(ValueError, match="of this volume"):
        load_surface(tmp_path / "part.nii", VOLUME)


@pytest.mark.parametrize("text", ["", "# nothing", "1 2 3", '1 300 0 0 1 1 1 "too red"', "\0\0"])
def test_a_text_of_another_kind_names_nothing(tmp_path, text):
    export(result(names=()), tmp_path / "a.nii")
    (tmp_path / "a.txt").write_text(text)
    labels = load_surface(tmp_path / "a.nii", VOLUME).labels
    assert labels == ((Label(1, "too red", "#ff0000"),) if "red" in text else ())


@pytest.mark.parametrize("name", ["a.npy", "a.tif", "a.mha", "a.nrrd", "a.nii"])
def test_every_reader_gives_the_numbers_and_a_text_next_to_it_the_names(tmp_path, name):
    labels = LABELS.astype(np.int16)
    if name == "a.npy":
        np.save(tmp_path / name, labels)
    elif name == "a.mha":
        write_metaimage(tmp_path / name, labels, matrix=VOLUME.geometry.affine(SPACING, "LPS")[:, [2, 1, 0, 3]])
    else:
        export(result(names=()), tmp_path / name)
    (tmp_path / "a.txt").write_text('3 255 128 0 1 1 1 "kidney"\n7 0 16 255 1 1 1 "vein"\n')
    surface = load_surface(tmp_path / name, VOLUME)
    assert np.array_equal(label_voxels(surface, SHAPE), LABELS)
    assert surface.labels == (Label(3, "kidney", "#ff8000"), Label(7, "vein", "#0010ff"))


ATLAS = 614_454_277
"""Largest label of a brain atlas."""


@pytest.mark.parametrize("name", ["a.nii.gz", "a.seg.nrrd"])
def test_labels_of_a_brain_atlas_are_read_and_written_with_their_names(tmp_path, name):
    large = np.where(LABELS == 7, ATLAS, LABELS).astype(np.int32)
    nibabel.Nifti1Image(large.T, VOLUME.geometry.affine(SPACING, "RAS")[:, [2, 1, 0, 3]]).to_filename(
        tmp_path / "l.nii"
    )
    (tmp_path / "l.txt").write_text(
        f'3 255 128 0 1 1 1 "kidney"\n{ATLAS} 0 16 255 1 1 1 "vein"\n5 0 0 0 1 1 1 "none"\n'
    )
    surface = load_surface(tmp_path / "l.nii", VOLUME)
    export(
        replace(result(), surface=replace(surface, labels=tuple(replace(one, color="") for one in surface.labels))),
        tmp_path / name,
    )
    back = load_surface(tmp_path / name, VOLUME)
    assert np.array_equal(label_voxels(back, SHAPE), large)
    assert {one.number: one.name for one in back.labels} == {3: "kidney", ATLAS: "vein", 5: "none"}
    assert len({one.color for one in back.labels}) == 3
    table = replace(result(), surface=back).table()
    assert table["label"].tolist() == [3, ATLAS]
    assert table["volume"].tolist() == [(large == 3).sum(), (large == ATLAS).sum()]


@given(
    st.sets(st.integers(1, 2**31 - 1), min_size=1, max_size=6),
    st.floats(-9e-4, 9e-4),
    st.sampled_from([0, 0, -3, -1024]),
)
@settings(max_examples=60, deadline=None)
def test_whole_labels_keep_their_numbers_also_off_by_the_slope_of_a_file(numbers, off, background):
    labels = np.repeat([0, *numbers], 5).reshape(1, -1, 1)
    stored = np.where(labels > 0, labels * 1.0 + off, background)
    found, whole = number_gray_levels(stored, "a")
    assert whole
    assert np.array_equal(found, labels)


def is_refused(read, stored):
    try:
        read(stored, "a")
    except ValueError as error:
        assert f"has the label {stored.min()}, and none may be below 0" in str(error)
        return True
    return False


@given(st.sets(st.sampled_from([-2, -1, 0, 1, 4, 614_454_277]), min_size=2), st.randoms())
@settings(max_examples=60, deadline=None)
def test_no_label_below_0_becomes_an_object_or_the_background_of_others(labels, random):
    values = [*labels] * 3
    random.shuffle(values)
    stored = np.repeat(values, 3).reshape(1, -1, 1)
    for read in (label_gray_levels, number_gray_levels):
        assert is_refused(read, stored) == (sorted(labels)[1] <= 0)


def test_names_do_not_belong_to_ranks(tmp_path):
    np.save(tmp_path / "a.npy", np.where(LABELS == 7, 2.5, LABELS))
    (tmp_path / "a.txt").write_text('1 255 128 0 1 1 1 "one"\n2 0 16 255 1 1 1 "two"\n')
    notes = []
    surface = load_surface(tmp_path / "a.npy", VOLUME, warn=notes.append)
    assert surface.labels == ()
    assert "no whole numbers" in notes[0]


@pytest.mark.parametrize("levels", [(0.0, 0.003, 0.006), (0.0, 0.4, 1.0), (0.0, 0.05, 1.0), (1e-5, 2e-5, 3e-5)])
def test_gray_levels_that_are_no_numbers_of_labels_stay_apart(levels):
    stored = np.repeat(levels, 4).reshape(1, -1, 1)
    assert np.array_equal(label_gray_levels(stored, "a").ravel(), np.repeat([0, 1, 2], 4))
