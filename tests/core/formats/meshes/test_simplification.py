"""Surfaces made simpler at export: smoother, with fewer triangles, and how far this moves them is told."""

import logging
from dataclasses import replace

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.formats.meshes.simplification import Simplification, measure_change, simplify_surface
from cpm_core.formats.meshes.stl import read_stl
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface

SPACING = (2.0, 1.0, 1.0)


@pytest.fixture
def ball() -> Surface:
    away = np.linalg.norm((np.moveaxis(np.indices((15, 29, 29)), 0, -1) - (7, 14, 14)) * SPACING, axis=-1)
    return replace(Region.from_mask(away < 11.3).find_surface(), spacing=SPACING, unit="mm")


def roughness(surface: Surface) -> float:
    away = np.linalg.norm((surface.vertices - (7, 14, 14)) * SPACING, axis=1)
    return float(away.std())


def test_smoothing_removes_the_steps_between_voxels_and_keeps_the_volume(ball: Surface) -> None:
    smooth = simplify_surface(ball, Simplification(smoothing=10))
    assert smooth.closed
    assert roughness(smooth) < 0.75 * roughness(ball)
    assert smooth.volume == pytest.approx(ball.volume, rel=0.01)
    change = measure_change(ball, smooth)
    assert 0.0 < change.mean < change.largest < 1.0
    assert measure_change(ball, ball).largest < 1e-9


def test_a_rim_stays_where_it_is(ball: Surface) -> None:
    half = replace(ball, faces=ball.faces[(ball.vertices[ball.faces][..., 0] < 7.0).all(axis=1)])
    smooth = simplify_surface(half, Simplification(smoothing=5))
    moved = (smooth.vertices != ball.vertices).any(axis=1)
    assert moved.any()
    assert smooth.free_edges == half.free_edges
    assert not moved[ball.vertices[:, 0] > 7.0].any()


def test_each_object_keeps_its_share_of_triangles_without_a_gap(ball: Surface) -> None:
    pytest.importorskip("fast_simplification")
    count = len(ball.faces)
    both = replace(
        ball,
        vertices=np.concatenate([ball.vertices, ball.vertices + 40.0]),
        faces=np.concatenate([ball.faces, ball.faces + len(ball.vertices)]),
        numbers=np.repeat([3, 8], count),
    )
    few = simplify_surface(both, Simplification(triangles=0.25))
    assert few.closed
    for number in (3, 8):
        assert np.count_nonzero(few.numbers == number) == pytest.approx(0.25 * count, rel=0.02)
    assert few.volume == pytest.approx(both.volume, rel=0.01)


def test_only_files_of_triangles_are_simplified_and_the_change_is_said(ball, tmp_path, caplog) -> None:
    whole, smooth = tmp_path / "whole.stl", tmp_path / "smooth.stl"
    cpm.export(replace(ball, left_out=2), whole)
    assert "2 parts were left out" in caplog.text
    with caplog.at_level(logging.WARNING):
        cpm.export(ball, smooth, surface_smoothing=10)
    assert "mm on average and by" in caplog.text
    kept = [read_stl(path.read_bytes()).points for path in (whole, smooth)]
    assert np.abs(kept[0]).max() != np.abs(kept[1]).max()


@pytest.mark.parametrize("wrong", [{"smoothing": -1}, {"smoothing": 101}, {"triangles": 0.0}, {"triangles": 1.5}])
def test_values_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be"):
        Simplification(**wrong)
