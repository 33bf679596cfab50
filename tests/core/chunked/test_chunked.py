"""An image larger than memory, here a small one with small chunks: what is found is what a run in one piece finds."""

import json

import numpy as np
import pytest
import scipy

import cpm_core as cpm
from cpm_core.chunked import chunk_objects, results
from cpm_core.chunked import grid as grids
from cpm_core.chunked.chunked_contours import ChunkedContours, ChunkedTask
from cpm_core.chunked.run import run_chunks, survey_image
from cpm_core.chunked.seams import join_pieces
from cpm_core.chunked.store import RunStore
from cpm_core.contours.agreement import distances_to_contours
from cpm_core.contours.contour import Contour
from cpm_core.formats.images import ome_zarr, stack
from cpm_core.formats.images.reading import Reading

pytest.importorskip("zarr", reason="the extra `scale` is not installed")

SIDE = 128
PARAMETERS = cpm.Parameters(smoothing=1.5, edge_floor=0.1, scales=1)


MIDDLES = (25, 25), (128, 200), (190, 128), (25, 128), (200, 220), (128, 330), (300, 128), (294, 256)


def picture(shape=(320, 360), middles=MIDDLES):
    """Disks on and off seams, brighter to the right, a hole in the last, and a ring larger than a chunk."""
    row, col = np.indices(shape)
    values = np.zeros(row.shape)
    for n, (r, c) in enumerate(middles):
        values[np.hypot(row - r, col - c - 0.3 * n) < 10 + n] = 60.0 + 12.0 * n
    values[np.hypot(row - r, col - c - 2.0) < 7] = 0.0
    down, right = row - shape[0] // 2, col - shape[1] // 2
    away = np.hypot(down, right) - 8.0 * np.sin(5.0 * np.arctan2(down, right))
    values[np.abs(away - 100) < 9] = 120.0
    noise = np.random.default_rng(3).normal(0.0, 1.0, row.shape)
    return np.clip(scipy.ndimage.gaussian_filter(values, 1.0) + 20.0 + noise, 0.0, 255.0).round().astype(np.uint8)


@pytest.fixture(autouse=True, scope="module")
def small():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ome_zarr, "_TILE_SIDE", 64)
        patch.setattr(grids, "_MIN_OVERLAP", 64)
        yield


def write(path, values):
    ome_zarr.create_multiscale(path, values.shape, values.dtype, SIDE, (0.5, 0.5), "µm")
    ome_zarr.write_window(path, np.s_[:, :], values)
    return grids.ChunkedSource(path, Reading())


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return write(tmp_path_factory.mktemp("image") / "cells.zarr", picture())


def serial(function, jobs, _title):
    return ((at, function(job)) for at, job in enumerate(jobs))


def found_in(source, tmp_path, kind="grid", compute=serial, max_steps=None, objects=False) -> ChunkedContours:
    return run_chunks(
        ChunkedTask(source, PARAMETERS, kind, RunStore(tmp_path / "chunks"), max_steps, objects), compute, SIDE
    )


@pytest.fixture(scope="module")
def found(source, tmp_path_factory):
    return found_in(source, tmp_path_factory.mktemp("run"))


def contours_of(found):
    return [one for chunk in range(len(found.counts)) for one in found.read_chunk_contours(chunk)]


@pytest.mark.parametrize("kind", ["grid", "gradient"])
def test_contours_are_those_of_a_run_in_one_piece(source, tmp_path, found, kind):
    image = cpm.load_image(source.path)
    seeds = cpm.uniform_grid(image.shape)
    if kind == "gradient":
        found, seeds = found_in(source, tmp_path, kind=kind), cpm.gradient_threshold(image.values, smoothing=1.5)
    one, several = cpm.segment(image, seeds, PARAMETERS).contours, contours_of(found)
    assert len(found.counts) == 9
    assert sorted(round(c.length) for c in several) == sorted(round(c.length) for c in one)
    assert all(contour.closed for contour in (*one, *several))
    assert len(one) == 11
    for some, others in ((one, several), (several, one)):
        assert distances_to_contours(np.concatenate([c.points for c in some]), others).max() < 0.05
    assert [c.number for c in several] == list(range(1, 12))


def test_objects_are_those_of_the_image_in_one_piece(tmp_path, monkeypatch):
    monkeypatch.setattr(chunk_objects, "OBJECT_MARGINS", (64, 256))  # the ring needs the second
    middles = (22, 22), (128, 90), (90, 136), (160, 165), (230, 228)
    source = write(tmp_path / "cells.zarr", picture((256, 256), middles))
    found = found_in(source, tmp_path, objects=True)
    assert len(found.counts) == 4
    image = cpm.load_image(source.path)
    one = cpm.segment(image, cpm.uniform_grid(image.shape), PARAMETERS).objects
    several = contours_of(found)
    assert sum(found.counts) == len(one) == 6
    assert sorted({contour.group for contour in several}) == list(range(1, 7))
    boundaries = [contour for each in one for contour in each.contours]
    for some, others in ((boundaries, several), (several, boundaries)):
        assert distances_to_contours(np.concatenate([c.points for c in some]), others).max() < 0.05
    names = [str(tmp_path / name) for name in ("labels.zarr", "cells.geojson", "cells.csv")]
    results.write_results(found, names, serial, results.WRITERS)
    labels = np.asarray(ome_zarr.open_multiscale(tmp_path / "labels.zarr").arrays[0])
    for each in one:
        number = np.bincount(labels[each.mask]).argmax()
        assert number
        assert np.count_nonzero((labels == number) ^ each.mask) <= 0.02 * np.count_nonzero(each.mask)
    tiles = [json.loads(name.read_text())["features"] for name in tmp_path.glob("cells_*.geojson")]
    assert sorted(int(each["properties"]["name"].split()[1]) for tile in tiles for each in tile) == list(range(1, 7))
    from pyarrow import csv  # noqa: PLC0415

    table = csv.read_csv(tmp_path / "cells.csv")
    assert sorted(table["label"].to_pylist()) == list(range(1, 7))
    pixels = np.bincount(labels.ravel())[table["label"].to_numpy()]
    assert table["area_um2"].to_numpy() / 0.25 == pytest.approx(pixels, rel=0.03)
    assert np.isfinite(table["intensity_mean"].to_numpy()).all()


def test_objects_in_a_net_of_lines_are_those_of_the_image_in_one_piece(tmp_path, monkeypatch):
    monkeypatch.setattr(chunk_objects, "OBJECT_MARGINS", (64, 256))
    row, col = np.indices((190, 200))
    values = 80.0 * (row >= 96) + 50.0 * (col >= np.where(row < 96, 96, 106)) + 60.0
    values[(row < 20) | (row >= 172) | (col < 20) | (col >= 182)] = 20.0
    values = scipy.ndimage.gaussian_filter(values, 1.0).round().astype(np.uint8)
    source = write(tmp_path / "bricks.zarr", values)
    one = cpm.segment(cpm.load_image(source.path), cpm.uniform_grid(values.shape), PARAMETERS)
    assert one.links
    assert len(one.objects) == 4
    found = found_in(source, tmp_path, objects=True)
    results.write_results(found, [str(tmp_path / "labels.zarr")], serial, results.WRITERS)
    labels = np.asarray(ome_zarr.open_multiscale(tmp_path / "labels.zarr").arrays[0])
    assert found.count == 4
    assert len(found.find_links_near(np.s_[0:190, 0:200])) == len(one.links)
    for each in one.objects:
        number = np.bincount(labels[each.mask]).argmax()
        assert number
        assert np.count_nonzero((labels == number) ^ each.mask) <= 0.02 * np.count_nonzero(each.mask)


def test_what_depends_on_the_whole_image_is_that_of_a_run_in_one_piece(source, tmp_path):
    parameters = cpm.Parameters(gamma="auto", smoothing=2.0, max_border=0.08, scales=2)
    _, whole = survey_image(ChunkedTask(source, parameters, "grid", RunStore(tmp_path)), serial, SIDE)
    engine = cpm.Engine(cpm.load_image(source.path), parameters)
    for scale in (0, 1):
        field = engine.scale_field(parameters, scale)
        assert whole.strongest[scale] == pytest.approx(field.strongest, rel=1e-2 if scale else 1e-9)
        assert whole.floor[scale] == pytest.approx(field.floor, rel=3e-2 if scale else 1e-6)


def test_hot_pixels_at_a_seam_and_a_bright_rim_count_as_little_as_in_one_piece(source, tmp_path):
    values = np.pad(picture()[2:-2, 2:-2].astype(np.uint16), 2, constant_values=65535)
    values[127:129, 128], values[60, 64], values[200, 300] = 65535, 40000, 0
    hot = write(tmp_path / "hot.zarr", values)
    image, plain = cpm.load_image(hot.path), cpm.Engine(cpm.load_image(source.path), PARAMETERS).scale_field(PARAMETERS)
    for name, parameters in (("plain", PARAMETERS), ("gamma", cpm.Parameters(gamma=0.5, smoothing=1.5, scales=1))):
        (tmp_path / name).mkdir()
        _, whole = survey_image(ChunkedTask(hot, parameters, "grid", RunStore(tmp_path / name)), serial, SIDE)
        field = cpm.Engine(image, parameters).scale_field(parameters)
        assert whole.strongest[0] == pytest.approx(field.strongest, rel=1e-9)
    assert cpm.Engine(image, PARAMETERS).scale_field(PARAMETERS).strongest == pytest.approx(plain.strongest, rel=0.5)
    one = cpm.segment(image, cpm.uniform_grid(image.shape), PARAMETERS).contours
    several = contours_of(found_in(hot, tmp_path))
    assert sorted(round(c.length) for c in several) == sorted(round(c.length) for c in one)
    assert sum(contour.area > 100 for contour in several) >= 9


def test_a_run_that_was_ended_is_continued_with_the_other_chunks(source, tmp_path):
    done = []

    def killed(function, jobs, title):
        for at, job in enumerate(jobs):
            if title == "contours" and len(done) == 4:
                raise KeyboardInterrupt
            yield at, function(job)
            done.extend([job.number] if title == "contours" else [])

    with pytest.raises(KeyboardInterrupt):
        found_in(source, tmp_path, compute=killed, max_steps=2)
    again = []

    def continued(function, jobs, title):
        again.extend([job.number for job in jobs] if title == "contours" else [])
        return serial(function, jobs, title)

    found_in(source, tmp_path, compute=continued, max_steps=2)
    assert again == [number for number in range(9) if number not in done]
    assert RunStore(tmp_path / "chunks").open_run({"other": "settings"}) is False  # another run
    assert list((tmp_path / "chunks").glob("chunk_*")) == []


def test_files_hold_what_was_found(found, tmp_path):
    names = [str(tmp_path / name) for name in ("labels.zarr", "cells.geojson", "cells.csv", "cells.parquet")]
    written = results.write_results(found, names, serial, results.WRITERS)
    contours = contours_of(found)
    labels = ome_zarr.open_multiscale(tmp_path / "labels.zarr")
    finest = np.asarray(labels.arrays[0])
    assert (labels.spacing[1:], labels.unit) == ((0.5, 0.5), "µm")
    assert sorted(np.unique(finest)) == list(range(12))
    painted = cpm.Truth(finest.astype(np.int32), tuple(contours))
    assert cpm.compare(contours, painted).objects.found == 11
    tiles = list(tmp_path.glob("cells_*.geojson"))
    assert written[1].endswith(f"cells_*.geojson ({len(tiles)} files)")
    features = [feature for name in tiles for feature in json.loads(name.read_text())["features"]]
    assert sorted(int(one["properties"]["name"].split()[1]) for one in features) == list(range(1, 12))
    rings = sorted(len(one["geometry"]["coordinates"]) for one in features)
    assert rings[-3:] == [2, 2, 4]  # the disk and the ring have a hole each, and in the ring are three disks
    from pyarrow import csv, parquet  # noqa: PLC0415

    table, same = parquet.read_table(tmp_path / "cells.parquet"), csv.read_csv(tmp_path / "cells.csv")
    assert table.column_names == same.column_names
    assert sorted(table["label"].to_pylist()) == list(range(1, 12))
    pixels = np.bincount(finest.ravel())[table["label"].to_numpy()]
    areas = table["area_um2"].to_numpy() / 0.25
    assert np.isfinite(table["intensity_mean"].to_numpy()).all()
    assert areas == pytest.approx(pixels, rel=0.03)


def test_a_number_that_is_not_known_is_an_empty_cell(tmp_path):
    from pyarrow import parquet  # noqa: PLC0415

    parts = [{"label": np.array([1]), "confidence": np.array([at])} for at in (np.nan, 0.5)]
    for name in ("cells.csv", "cells.parquet"):
        results.write_table_parts(tmp_path / name, tmp_path / name, parts)
    assert (tmp_path / "cells.csv").read_text().split() == ['"label","confidence"', "1,", "1,0.5"]
    assert parquet.read_table(tmp_path / "cells.parquet")["confidence"].to_pylist() == [None, 0.5]


def test_pieces_are_joined_to_closed_contours_without_a_seam():
    turn = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    circle = np.stack([100.0 + 80.0 * np.sin(turn), 100.0 + 80.0 * np.cos(turn)], axis=1)

    def half(chunk):
        own = (circle[:, 1] < 106) if chunk == 0 else (circle[:, 1] > 94)
        first = int(np.flatnonzero(own & ~np.roll(own, 1))[0])
        points = np.roll(circle, -first, axis=0)[: own.sum()]
        return points[::-1] if chunk else points

    pieces = [Contour(half(chunk) + 0.001 * chunk, False, 1.0 + chunk) for chunk in (0, 1)]
    (one,) = join_pieces(pieces, [0, 1], 8.0)
    assert one.closed
    assert one.length == pytest.approx(2.0 * np.pi * 80.0, abs=0.1)
    assert one.area == pytest.approx(np.pi * 80.0**2, rel=1e-3)


def test_a_line_along_a_seam_that_two_chunks_see_a_little_apart_is_there_once():
    row = np.arange(0.0, 161.0)
    lines = [
        np.stack([row[part], np.full(part.sum(), at)], axis=1) for part, at in ((row <= 100, 50.0), (row >= 60, 50.3))
    ]
    found = join_pieces([Contour(points, False) for points in lines], [0, 1], 8.0)
    assert sum(one.length for one in found) == pytest.approx(160.0, abs=2.0)


def test_a_line_next_to_a_seam_that_one_chunk_alone_sees_stays_as_it_is():
    line = Contour(np.array([(100.0, 10.0), (125.0, 30.0), (100.0, 50.0)]), False)
    (found,) = join_pieces([line], [0], 8.0)
    np.testing.assert_array_equal(found.points, line.points)


@pytest.mark.parametrize("unit", ["nm", "µm", "mm", "cm", "m"])
def test_the_size_of_a_pixel_is_read_back_in_every_unit(tmp_path, unit):
    ome_zarr.create_multiscale(tmp_path / "x.zarr", (600, 600), np.uint8, SIDE, (0.5, 0.25), unit)
    levels = ome_zarr.open_multiscale(tmp_path / "x.zarr")
    assert (levels.spacing[1:], levels.unit) == ((0.5, 0.25), unit)


def test_an_image_is_opened_in_the_level_that_has_room(source, tmp_path, monkeypatch):
    image = cpm.load_image(source.path)
    assert (image.values == picture()).all()
    assert (image.spacing, image.unit, image.notes) == ((0.5, 0.5), "µm", ())
    monkeypatch.setattr(stack, "MAXIMUM_PIXELS", 2**19)
    values = np.arange(1200 * 800, dtype=np.uint32).reshape(1200, 800)
    ome_zarr.create_multiscale(tmp_path / "x.zarr", values.shape, values.dtype, SIDE)
    ome_zarr.write_window(tmp_path / "x.zarr", np.s_[:, :], values)
    ome_zarr.halve_window(tmp_path / "x.zarr", 1, np.s_[0:600, 0:400])
    small = cpm.load_image(tmp_path / "x.zarr")
    assert (small.values == values[::2, ::2]).all()
    assert "level 1 was opened" in small.notes[0]
    (finer,) = small.finer
    assert finer.shape == (1200, 800)
    assert (finer[700:710, 20:30] == values[700:710, 20:30]).all()


def test_an_image_of_10_000_000_000_pixels_is_opened_in_little_memory(tmp_path):
    path, side, place = tmp_path / "slide.zarr", 100_000, np.s_[51200:51328, 98304:98432]
    values = np.random.default_rng(2).integers(1, 256, (128, 128), np.uint8)
    count = ome_zarr.create_multiscale(path, (side, side), np.uint8, 1024)
    ome_zarr.write_window(path, place, values)
    for level in range(1, count):
        ome_zarr.halve_window(path, level, tuple(slice(s.start >> level, -(-s.stop >> level)) for s in place))
    assert sum(file.stat().st_size for file in path.rglob("*")) < 2**20  # what is missing is black
    image = cpm.load_image(path)
    assert image.shape == (6250, 6250)
    assert (image.stored[3200:3208, 6144:6152] == values[::16, ::16]).all()
    assert np.count_nonzero(image.stored) == 64
    assert [level.shape[0] for level in image.finer] == [100_000, 50_000, 25_000, 12_500]
    assert (image.finer[0][place] == values).all()
    assert (image.finer[2][np.s_[12800:12832, 24576:24608]] == values[::4, ::4]).all()


def test_pixels_without_data_are_refused_before_anything_runs(tmp_path):
    values = picture().astype(np.float32)
    values[200, 300] = np.nan
    with pytest.raises(ValueError, match=r"nan\.zarr has pixels without data \(NaN\)"):
        found_in(write(tmp_path / "nan.zarr", values), tmp_path)
