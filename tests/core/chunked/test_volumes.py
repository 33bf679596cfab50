"""A volume larger than memory, here a small one with small chunks: surfaces are those of a run in one piece."""

import shutil

import numpy as np
import pytest
import scipy

import cpm_core as cpm
from cpm_core.chunked import grid as grids
from cpm_core.chunked import results, volume_results
from cpm_core.chunked.chunked_contours import ChunkedTask
from cpm_core.chunked.store import RunStore
from cpm_core.chunked.volume_objects import run_volume
from cpm_core.chunked.volume_run import run_particles
from cpm_core.contours.surface_agreement import sample_triangles
from cpm_core.formats.images import ome_zarr
from cpm_core.formats.images.reading import Reading
from tests.core.chunked.test_chunked import serial

pytest.importorskip("zarr", reason="the extra `scale` is not installed")

SHAPE, SIDE = (104, 96, 100), 64
PARAMETERS = cpm.PRESETS["volume"]


def distance():
    """Distance inside a ball on the corner of eight chunks, an ellipsoid, a torus around a seam, a shell, a small ball.

    The shell is hollow, and the last ball touches the border of the volume.
    """
    p, r, c = np.indices(SHAPE, sparse=True)

    def ball(plane, row, col, radius):
        return radius - np.sqrt((p - plane) ** 2 + (r - row) ** 2 + (c - col) ** 2)

    ellipsoid = 8.0 * (1.0 - np.sqrt(((p - 24) / 16) ** 2 + ((r - 66) / 10) ** 2 + ((c - 30) / 8) ** 2))
    torus = 6.0 - np.sqrt((np.sqrt((r - 24) ** 2 + (c - 64) ** 2) - 17) ** 2 + (p - 22) ** 2)
    shell = np.minimum(ball(84, 24, 24, 14), -ball(84, 24, 24, 7))
    return np.maximum.reduce([ball(64.3, 63.8, 64.1, 13), ellipsoid, torus, shell, ball(100, 70, 24, 9)])


BODIES = 5


def write(path, values):
    ome_zarr.create_multiscale(path, values.shape, values.dtype, SIDE, (0.5, 0.5, 0.5), "µm")
    ome_zarr.write_window(path, np.s_[:, :, :], values)
    return grids.ChunkedSource(path, Reading(), "zyx")


@pytest.fixture(autouse=True, scope="module")
def small():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ome_zarr, "_TILE_SIDE", 64)
        yield


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    values = 30.0 + 150.0 * np.clip(distance() + 0.5, 0.0, 1.0)
    values += np.random.default_rng(5).normal(0.0, 2.0, SHAPE)
    values = scipy.ndimage.gaussian_filter(values, 0.6).round().astype(np.uint8)
    return write(tmp_path_factory.mktemp("volume") / "bodies.zarr", values)


def found_in(source, folder, kind="grid", compute=serial, max_steps=None, side=SIDE, objects=False):
    task = ChunkedTask(source, PARAMETERS, kind, RunStore(folder / "chunks"), max_steps, objects)
    return run_volume(task, compute, side)


@pytest.fixture(scope="module")
def found(source, tmp_path_factory):
    return found_in(source, tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def files(found, tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    names = [str(folder / name) for name in ("labels.zarr", "bodies.ply", "bodies.csv", "bodies.parquet")]
    assert results.write_results(found, names, serial, volume_results.WRITERS) == names
    return folder


def apart(one, other):
    """Distances of vertices within the volume from another surface [voxels]."""
    inside = one.vertices[one.vertices[:, 0] < SHAPE[0] - 1]
    return sample_triangles(other, SHAPE).distances_to(inside * one.spacing) / one.spacing[0]


def test_surfaces_are_those_of_a_run_in_one_piece_and_of_the_bodies(source, files):
    image = cpm.load_volume(source.path)
    one = cpm.segment(image, cpm.seeds_everywhere(image), PARAMETERS).surface
    several = cpm.load_surface(files / "bodies.ply", image)
    assert several.closed
    assert (several.components, several.euler) == (one.components, one.euler) == (BODIES + 1, 2 * BODIES)
    assert max(apart(one, several).max(), apart(several, one).max()) < 0.05
    assert several.volume == pytest.approx(one.volume, rel=1e-3)
    assert several.volume > 0.0
    inner = several.vertices[several.vertices[:, 0] < 98.0]  # away from the flat end at the border
    off = scipy.ndimage.map_coordinates(distance(), inner.T, order=1)
    assert np.abs(off).mean() < 0.1
    assert np.percentile(np.abs(off), 99) < 0.3


def test_each_body_is_found_once_in_all_files(found, files):
    from pyarrow import csv, parquet  # noqa: PLC0415

    assert found.count == BODIES
    table, same = parquet.read_table(files / "bodies.parquet"), csv.read_csv(files / "bodies.csv")
    assert table.column_names == same.column_names
    assert table["label"].to_pylist() == list(range(1, BODIES + 1))
    volumes = table["volume_um3"].to_numpy()
    assert (np.diff(volumes) < 0.0).all()
    levels = ome_zarr.open_multiscale(files / "labels.zarr")
    labels = np.asarray(levels.arrays[0])
    assert (levels.spacing, levels.unit, levels.axes) == ((0.5, 0.5, 0.5), "µm", "zyx")
    assert np.bincount(labels.ravel())[1:] * 0.125 == pytest.approx(volumes, rel=0.02)
    for number in range(1, BODIES + 1):  # what is one is one, through all seams
        assert scipy.ndimage.label(labels == number)[1] == 1
        center = [table[f"center_{axis}_um"][number - 1].as_py() for axis in ("plane", "row", "col")]
        assert center == pytest.approx(np.argwhere(labels == number).mean(axis=0) * 0.5, abs=0.1)
    surface = cpm.load_surface(files / "bodies.ply", cpm.load_volume(files / "labels.zarr"))
    assert sorted(np.unique(surface.numbers)) == list(range(1, BODIES + 1))


def test_objects_of_chunks_are_those_of_a_run_in_one_piece_split_where_they_touch(tmp_path):
    p, r, c = np.indices((40, 48, 96), sparse=True)
    balls = [((20, 24, 24), 9.0), ((20, 24, 40), 9.5), ((20, 24, 58), 10.5), ((20, 24, 82), 8.0)]
    inside = np.max([radius - np.sqrt(sum((x - y) ** 2 for x, y in zip((p, r, c), at, strict=True)))
                     for at, radius in balls], axis=0)  # fmt: skip
    values = 30.0 + 150.0 * np.clip(inside + 0.5, 0.0, 1.0)
    values += np.random.default_rng(5).normal(0.0, 4.0, values.shape)
    source = write(tmp_path / "touching.zarr", values.round().astype(np.uint8))
    found = found_in(source, tmp_path, objects=True)
    assert len(found.grid.chunks) == 2
    names = [str(tmp_path / name) for name in ("labels.zarr", "objects.ply", "objects.csv")]
    results.write_results(found, names, serial, volume_results.WRITERS)
    image = cpm.load_volume(source.path)
    objects = cpm.segment(image, cpm.seeds_everywhere(image), PARAMETERS).objects
    assert found.count == len(objects) == len(balls)
    labels = np.asarray(ome_zarr.open_multiscale(tmp_path / "labels.zarr").arrays[0])
    surface = cpm.load_surface(tmp_path / "objects.ply", image)
    table = np.genfromtxt(tmp_path / "objects.csv", delimiter=",", names=True)
    assert surface.closed
    assert set(surface.numbers.tolist()) == set(table["label"].tolist()) == set(range(1, len(balls) + 1))
    for one in objects:
        number = int(np.bincount(labels[one.mask]).argmax())
        assert (one.mask & (labels == number)).sum() > 0.97 * (one.mask | (labels == number)).sum()
        row = table[number - 1]
        assert (row["volume_um3"], row["confidence"]) == pytest.approx((one.size, one.confidence), rel=0.02)
        assert [row[f"center_{axis}_um"] for axis in ("plane", "row", "col")] == pytest.approx(
            np.argwhere(one.mask).mean(axis=0) * 0.5, abs=0.1
        )


@pytest.mark.long
def test_dark_bodies_are_found_where_most_of_the_border_is_bright(tmp_path):
    values = (200.0 - 150.0 * np.clip(distance() + 0.5, 0.0, 1.0)).astype(np.uint8)
    found = found_in(write(tmp_path / "dark.zarr", values), tmp_path, kind="gradient")
    assert found.count == BODIES
    assert found.table["volume"].sum() == pytest.approx((distance() > 0.0).sum() * 0.125, rel=0.02)


@pytest.mark.long
def test_a_body_larger_than_a_chunk_is_filled_where_no_chunk_sees_its_surface(tmp_path):
    p, r, c = np.indices((96, 96, 96), sparse=True)
    off = 37.0 - np.sqrt((p - 48) ** 2 + (r - 48) ** 2 + (c - 48) ** 2)
    values, inside = (30.0 + 150.0 * np.clip(off + 0.5, 0.0, 1.0)).astype(np.uint8), off > 0.0
    found = found_in(write(tmp_path / "large.zarr", values), tmp_path, side=SIDE // 2)
    results.write_results(found, [str(tmp_path / "labels.zarr")], serial, volume_results.WRITERS)
    assert found.count == 1
    labels = np.asarray(ome_zarr.open_multiscale(tmp_path / "labels.zarr").arrays[0])
    assert (labels != inside).mean() < 2e-3


def test_a_run_that_was_ended_is_continued_with_the_other_chunks(source, found, tmp_path):
    shutil.copytree(found.volume.task.store.folder, tmp_path / "chunks")
    for name in ("parts_3.npz", "parts_6.npz", "necks_7.npz"):
        (tmp_path / "chunks" / name).unlink()
    again = []

    def continued(function, jobs, title):
        again.extend([(title, job.number) for job in jobs])
        return serial(function, jobs, title)

    same = found_in(source, tmp_path, compute=continued)
    assert again == [("necks", 7), ("bodies", 3), ("bodies", 6)]
    assert (same.body_of_part == found.body_of_part).all()


def test_a_hot_voxel_counts_as_little_as_in_one_piece(tmp_path):
    values = np.random.default_rng(0).normal(100.0, 2.0, (40, 72, 72))
    values[10:30, 20:50, 20:50] += 80.0
    values[8, 64, 33], values[20, 5, 5] = 6e4, -6e4
    (tmp_path / "chunks").mkdir()
    hot = write(tmp_path / "hot.zarr", values.astype(np.float32))
    volume, _ = run_particles(ChunkedTask(hot, PARAMETERS, "grid", RunStore(tmp_path / "chunks")), serial, SIDE)
    field = cpm.Engine(cpm.load_volume(hot.path), PARAMETERS).scale_field(PARAMETERS)
    assert volume.statistics.strongest[0] == pytest.approx(field.strongest, rel=1e-6)
    assert field.strongest < 200.0
