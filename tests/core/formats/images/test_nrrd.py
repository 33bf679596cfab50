"""NRRD: values, sizes and place as its header says, whatever the packing and the order of the axes."""

import nrrd
import numpy as np
import pytest

from cpm_core import load_image, load_volume

from .made import VALUES, affine

pytestmark = pytest.mark.filterwarnings("ignore:datetime.datetime.utcnow:DeprecationWarning")
"""The package that writes them here asks for the time in an old way."""

MATRIX = affine()
HEADER = {
    "space": "left-posterior-superior",
    "space directions": MATRIX[:3, :3].T,
    "space origin": MATRIX[:3, 3],
    "kinds": ["domain"] * 3,
}


def write(path, values=VALUES, **header):
    """Values with the slowest axis first; entries that are None are left out."""
    nrrd.write(str(path), values, {key: value for key, value in header.items() if value is not None}, index_order="C")


@pytest.mark.parametrize("encoding", ["raw", "gzip", "bzip2", "ascii"])
@pytest.mark.parametrize("endian", ["little", "big"])
def test_values_sizes_and_place_are_those_of_the_header(tmp_path, encoding, endian):
    write(tmp_path / "a.nrrd", **HEADER, encoding=encoding, endian=endian)
    volume = load_volume(tmp_path / "a.nrrd")
    assert np.array_equal(volume.values, VALUES)
    assert volume.spacing == pytest.approx((2.0, 0.75, 0.5))
    np.testing.assert_allclose(volume.geometry.affine(volume.spacing)[:, [2, 1, 0, 3]], MATRIX, atol=1e-12)
    assert (volume.unit, volume.geometry.convention, volume.notes) == ("mm", "LPS", ())
    assert np.array_equal(load_image(tmp_path / "a.nrrd", page=2).values, VALUES[1])


@pytest.mark.parametrize(
    ("space", "signs", "convention"),
    [
        ("right-anterior-superior", (1, 1, 1), "RAS"),
        ("left-anterior-superior", (1, -1, 1), "LPS"),
        ("LPS", (1, 1, 1), "LPS"),
    ],
)
def test_every_space_of_a_patient_is_known(tmp_path, space, signs, convention):
    write(tmp_path / "a.nrrd", **{**HEADER, "space": space})
    volume = load_volume(tmp_path / "a.nrrd")
    found = volume.geometry.affine(volume.spacing)[:3, [2, 1, 0, 3]]
    np.testing.assert_allclose(found, np.array(signs)[:, None] * MATRIX[:3], atol=1e-12)
    assert volume.geometry.convention == convention


def test_in_another_space_only_the_sizes_are_known(tmp_path):
    write(tmp_path / "a.nrrd", **{**HEADER, "space": "scanner-xyz"})
    volume = load_volume(tmp_path / "a.nrrd")
    assert (volume.geometry, volume.spacing) == (None, pytest.approx((2.0, 0.75, 0.5)))


def test_plain_spacings_and_their_unit_are_read(tmp_path):
    write(tmp_path / "a.nrrd", spacings=[0.25, 0.5, 2.0], units=["um", "um", "um"])
    volume = load_volume(tmp_path / "a.nrrd")
    assert (volume.spacing, volume.unit, volume.geometry) == ((2.0, 0.5, 0.25), "µm", None)
    write(tmp_path / "b.nrrd")
    volume = load_volume(tmp_path / "b.nrrd")
    assert (volume.spacing, volume.unit) == ((1.0, 1.0, 1.0), None)


def test_an_axis_that_is_not_in_space_is_a_channel_a_time_or_a_color(tmp_path):
    two = np.stack([VALUES, VALUES + 7])
    space = {**HEADER, "space directions": np.vstack([HEADER["space directions"], [np.nan] * 3])}
    write(tmp_path / "a.nrrd", two, **{**space, "kinds": ["domain"] * 3 + ["list"]})
    assert np.array_equal(load_volume(tmp_path / "a.nrrd", channel=2).values, VALUES + 7)
    write(tmp_path / "b.nrrd", two, **{**space, "kinds": ["domain"] * 3 + ["time"]})
    assert np.array_equal(load_volume(tmp_path / "b.nrrd", time=2).values, VALUES + 7)
    assert ["2 points in time" in note for note in load_volume(tmp_path / "b.nrrd").notes] == [True]
    colors = np.stack([VALUES % 40, VALUES % 200, VALUES % 90], -1).astype(np.uint8)
    space = {**HEADER, "space directions": np.vstack([[np.nan] * 3, HEADER["space directions"]])}
    write(tmp_path / "c.nrrd", colors, **{**space, "kinds": ["RGB-color", *["domain"] * 3]})
    volume = load_volume(tmp_path / "c.nrrd")
    assert np.allclose(volume.values, colors @ (0.2125, 0.7154, 0.0721))
    assert volume.spacing == pytest.approx((2.0, 0.75, 0.5))


def test_times_that_itk_writes_as_an_axis_of_space_are_times(tmp_path):
    header = {"space dimension": 4, "space directions": np.diag([0.5, 0.75, 2.0, 1.0]), "space origin": [1, 2, 3, 0]}
    write(tmp_path / "a.nrrd", np.stack([VALUES, VALUES + 7]), **header, kinds=["domain"] * 4)
    volume = load_volume(tmp_path / "a.nrrd", time=2)
    assert np.array_equal(volume.values, VALUES + 7)
    assert volume.spacing == (2.0, 0.75, 0.5)


def test_values_beside_the_header_are_read_and_those_elsewhere_are_not(tmp_path):
    write(tmp_path / "a.nhdr", **HEADER, encoding="raw")
    assert np.array_equal(load_volume(tmp_path / "a.nhdr").values, VALUES)
    text = (tmp_path / "a.nhdr").read_text()
    for named in ("/dev/zero", "../a.raw", "missing.raw"):
        (tmp_path / "b.nhdr").write_text(text.replace("a.raw", named))
        with pytest.raises(ValueError, match="which is not a single file next to it"):
            load_volume(tmp_path / "b.nhdr")


@pytest.mark.parametrize("encoding", ["raw", "gzip", "bzip2", "ascii"])
def test_a_file_cut_short_is_refused(tmp_path, encoding):
    write(tmp_path / "a.nrrd", **HEADER, encoding=encoding)
    content = (tmp_path / "a.nrrd").read_bytes()
    (tmp_path / "a.nrrd").write_bytes(content[: len(content) - 200])
    with pytest.raises(ValueError, match="is damaged"):
        load_volume(tmp_path / "a.nrrd")


def test_more_than_memory_holds_is_refused_in_words(tmp_path):
    write(tmp_path / "a.nrrd", **HEADER, encoding="bzip2")
    content = (tmp_path / "a.nrrd").read_bytes().replace(b"sizes: 14 12 10", b"sizes: 99999 99999 9999")
    (tmp_path / "a.nrrd").write_bytes(content)
    with pytest.raises(ValueError, match=r"need .* GB of memory"):
        load_volume(tmp_path / "a.nrrd")


@pytest.mark.parametrize("encoding", ["raw", "gzip"])
def test_values_in_another_file_are_found_by_a_relative_path(tmp_path, monkeypatch, encoding):
    (tmp_path / "below").mkdir()
    write(tmp_path / "below" / "a.nhdr", **HEADER, encoding=encoding)
    assert len(list((tmp_path / "below").iterdir())) == 2
    monkeypatch.chdir(tmp_path)
    for path in ("below/a.nhdr", "./below/../below/a.nhdr", tmp_path / "below" / "a.nhdr"):
        assert np.array_equal(load_volume(path).values, VALUES)
