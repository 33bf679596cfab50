"""The gallery: shapes have their stated position, scenes their stated boundary, figures are written completely."""

import functools
import io
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cpm_core import Contour, edge_map
from cpm_core.numerics.polyline import sample_path
from docs.gallery import figures, pictures, silhouettes, skeletons
from docs.gallery.figures import FIGURES, Figure, write_figures
from docs.gallery.outlines import (
    coverage,
    polygon,
)
from docs.gallery.pages import Map, Page, Picture, Stairs
from docs.gallery.plotting import draw
from docs.gallery.scenes import closed

from ..core.scenes import circle_points

ROOT = Path(__file__).parents[2]
COMMITTED = ROOT / "assets" / "gallery"

SCENES = {
    **{
        build.__name__: build
        for build in (
            silhouettes.letter_u,
            silhouettes.flower,
            silhouettes.spiral,
            silhouettes.comb,
            silhouettes.across,
            silhouettes.for_noise,
            silhouettes.for_sensitivity,
            silhouettes.out_of_reach,
            pictures.angiogram,
            pictures.cell_in_haze,
            pictures.leaf_on_gravel,
            pictures.spotted_fish,
            pictures.cells,
            pictures.chromosomes,
            pictures.radiograph,
            pictures.slice_of_a_head,
            pictures.pebbles,
            pictures.hills,
            pictures.pears,
        )
    },
    **{name: lambda name=name: silhouettes.silhouettes()[name] for name in silhouettes.silhouettes()},
    **{name: lambda name=name: silhouettes.embedded()[name] for name in silhouettes.embedded()},
}


@functools.cache
def scene_of(name):
    return SCENES[name]()


@settings(deadline=None)
@given(st.lists(st.floats(3.0, 18.0), min_size=3, max_size=12), st.tuples(st.floats(19.0, 25.0), st.floats(19.0, 30.0)))
def test_coverage_adds_up_to_the_area(radii, center):
    angle = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    ring = np.stack([center[0] + radii * np.sin(angle), center[1] + radii * np.cos(angle)], axis=1)
    seen = coverage(polygon(ring), (46, 52))
    assert seen.min() >= 0.0
    assert seen.max() <= 1.0
    assert seen.sum() == pytest.approx(Contour(ring, closed=True).area, rel=0.01, abs=0.3)


@pytest.mark.parametrize("name", SCENES)
def test_the_image_has_an_edge_at_the_true_boundary(name):
    """Across the true boundary the maximum of the edge map is within a pixel of it, at seven points of eight.

    The others are at sharp corners; at a wrong boundary it would be so at four points of ten.
    """
    scene = scene_of(name)
    strength = edge_map(scene.values, 1.5)
    across = np.linspace(-2.5, 2.5, 21)
    places, normals = [], []
    for contour in scene.truth:
        points = sample_path(contour.path, 1.0)
        along = points[2:] - points[:-2]
        places.append(points[1:-1])
        normals.append(np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None])
    place, normal = np.concatenate(places), np.concatenate(normals)
    probes = place + across[:, None, None] * normal
    seen = ndimage.map_coordinates(strength, probes.reshape(-1, 2).T, order=1, mode="nearest").reshape(21, -1)
    assert (np.abs(across[seen.argmax(axis=0)]) <= 1.0).mean() >= 0.875


@pytest.mark.parametrize("name", SCENES)
def test_scenes_are_the_same_every_time_and_begin_inside_the_image(name):
    one, other = scene_of(name), SCENES[name]()
    assert np.array_equal(one.values, other.values)
    assert np.array_equal(one.seeds, other.seeds)
    assert ((one.seeds >= 0) & (one.seeds <= np.array(one.values.shape) - 1)).all()
    assert np.isfinite(one.values).all()


@pytest.mark.parametrize("name", ["ellipse", "grey starfish", "grey cross in noise"])
def test_a_medial_axis_is_equally_far_from_the_outline_on_both_sides(name):
    shape = skeletons.shapes()[name]
    outline = np.concatenate([sample_path(ring.path, 0.1) for ring in closed(shape.outline)])
    for line in shape.axis:
        along = (line.points[1] - line.points[0]) / line.length
        for place in sample_path(line.path, 4.0):
            off = outline - place
            left = off[:, 0] * along[1] - off[:, 1] * along[0] > 0.0
            one, other = (np.hypot(*off[side].T).min() for side in (left, ~left))
            assert one == pytest.approx(other, abs=0.25)  # a chord may cut an inner corner by as much
        end = line.points[1]  # the farthest place: the disk about it touches the outline at the tip
        assert np.hypot(*(outline - end).T).min() == pytest.approx(
            np.hypot(*(outline[np.argmax((outline - end) @ along)] - end)), abs=0.02
        )


RESULT = {
    "recall": 1.0,
    "precision": 0.9,
    "tolerance_px": 1.0,
    "mean_distance_px": 0.1,
    "closed": 1,
    "closed_true": 2,
    "contours": 3,
    "steps": 10,
    "particles": 20,
}


GRAY = np.add.outer(np.arange(30.0), np.arange(40.0))
PICTURE = Picture(
    "a picture",
    GRAY,
    particles=circle_points((15, 20), 8.0, 12),
    contours=[
        Contour(circle_points((15, 20), 10.0, 60), closed=True),
        Contour(GRAY[:2, :2], closed=False, junctions=(True, False)),
    ],
    field=np.ones((2, 30, 40)),
    caption=["one line", "another"],
    facts=RESULT,
)
STAIRS = Stairs("stairs", (0.0, 1.0, 2.0), {"a": [3, 2, 1], "b": [3, 3, 1]}, "x", "y", facts={"a": [3, 2, 1]})
MAP = Map("a map", np.eye(2), (0.0, 1.0), (0.0, 1.0), "x", "y", facts={"f": [[1, 0], [0, 1]]})


def small_page():
    return Page([[PICTURE, STAIRS], [None, MAP]], note="so much")


def opened(png):
    with PIL.Image.open(io.BytesIO(png)) as picture:
        picture.load()
        return picture


def test_a_page_is_drawn_as_a_picture_of_the_size_of_its_panels():
    picture = opened(draw(small_page(), "All kinds of panels"))
    assert picture.format == "PNG"
    assert picture.width == 2 * 18 + 2 * 290 + 14
    assert np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0).shape[0] > 50
    five = opened(draw(Page([[PICTURE] * 5]), "Five"))
    assert five.width <= 1600
    assert np.asarray(five.convert("L"))[:10].min() == 255  # the margin is empty


@pytest.fixture
def tiny(monkeypatch):
    """A gallery of two small figures."""
    table = {name: Figure(name, f"Title {name}", "About it.", small_page) for name in ("fig05", "fig06")}
    monkeypatch.setattr(figures, "FIGURES", table)
    return table


def test_figures_are_written_with_an_index_and_all_measured_values(tiny, tmp_path):
    reported = []
    written = write_figures(
        tmp_path / "new", progress=lambda figure, entry: reported.append((figure.name, entry["measured"]))
    )
    assert sorted(path.name for path in written) == ["README.md", "fig05.png", "fig06.png", "figures.json"]
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == sorted(path.name for path in written)
    measured = json.loads((tmp_path / "new" / "figures.json").read_text(encoding="utf-8"))
    assert measured["fig06"]["panels"][0] == {"panel": "a picture", **RESULT}
    assert [panel["panel"] for panel in measured["fig05"]["panels"]] == ["a picture", "stairs", "a map"]
    text = (tmp_path / "new" / "README.md").read_text(encoding="utf-8")
    assert text.count("recall 1.000 and precision 0.900") == 2
    assert re.findall(r"\]\((.*?)\)", text) == ["fig05.png", "fig06.png"]
    assert [name for name, _ in reported] == ["fig05", "fig06"]
    assert reported[0][1].startswith("so much; recall 1.000")


def test_matplotlib_is_not_loaded_before_something_is_drawn():
    program = "import sys, cpm_core.cli, docs.gallery.figures; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "False\n", "")


def test_the_gallery_of_the_project_is_complete_and_small():
    text = (COMMITTED / "README.md").read_text(encoding="utf-8")
    assert list(json.loads((COMMITTED / "figures.json").read_text(encoding="utf-8"))) == list(FIGURES)
    assert re.findall(r"\]\((.*?)\)", text) == [f"{name}.png" for name in FIGURES]
    assert sum(path.stat().st_size for path in COMMITTED.iterdir()) < 2_500_000
    for name, figure in FIGURES.items():
        assert figure.about in text
        assert opened((COMMITTED / f"{name}.png").read_bytes()).width <= 1600
