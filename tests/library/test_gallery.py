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
from cpm_core.numerics.polyline import sampled
from docs.gallery import figures, pictures, recovery, silhouettes, skeletons, studies
from docs.gallery.__main__ import main
from docs.gallery.figures import FIGURES, Figure, summary, write_figures
from docs.gallery.outlines import (
    blended,
    coverage,
    curve,
    disk,
    ellipse,
    limb,
    polygon,
    rings,
    round_ring,
    stroke,
    union,
    without,
)
from docs.gallery.pages import Map, Page, Picture, Stairs
from docs.gallery.plotting import draw
from docs.gallery.runs import run
from docs.gallery.scenes import closed

from ..core.scenes import antialiased, circle_points

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


def test_the_coverage_of_a_disk_is_that_of_points_within_its_pixels():
    seen = coverage(round_ring((30.3, 40.6), 20.2), (64, 80))
    inside = antialiased((64, 80), lambda row, col: np.hypot(row - 30.3, col - 40.6) < 20.2)
    assert np.abs(seen - (inside - 40.0) / 160.0).max() < 0.07  # of 8 x 8 points, one line of eight may differ by half


@settings(deadline=None)
@given(st.lists(st.floats(3.0, 18.0), min_size=3, max_size=12), st.tuples(st.floats(19.0, 25.0), st.floats(19.0, 30.0)))
def test_coverage_adds_up_to_the_area(radii, center):
    angle = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    ring = np.stack([center[0] + radii * np.sin(angle), center[1] + radii * np.cos(angle)], axis=1)
    seen = coverage(polygon(ring), (46, 52))
    assert seen.min() >= 0.0
    assert seen.max() <= 1.0
    assert seen.sum() == pytest.approx(Contour(ring, closed=True).area, rel=0.01, abs=0.3)


def test_a_point_enclosed_by_two_rings_is_outside():
    seen = coverage((*round_ring((30, 30), 20.0), *round_ring((30, 30), 8.0)), (60, 60))
    assert seen.sum() == pytest.approx(np.pi * (400 - 64), rel=1e-3)
    assert seen[30, 30] == 0.0
    assert seen[30, 44] == 1.0


def test_a_shape_that_reaches_out_of_the_image_is_cut_by_its_border():
    half = coverage(polygon([(-10.5, -9.5), (-10.5, 4.5), (30.5, 4.5), (30.5, -9.5)]), (20, 10))
    assert np.array_equal(half, np.repeat([[1.0] * 5 + [0.0] * 5], 20, axis=0))


def test_a_limb_is_the_union_of_disks_of_linear_radius():
    a, b, wide, thin = np.array([20.0, 20.0]), np.array([40.0, 60.0]), 12.0, 4.0
    points = np.random.default_rng(0).uniform(0.0, 64.0, (300, 2))
    share = np.linspace(0.0, 1.0, 2001)
    centers, radii = a + share[:, None] * (b - a), wide + share * (thin - wide)
    brute = (np.linalg.norm(points[:, None] - centers, axis=2) - radii).min(axis=1)
    np.testing.assert_allclose(limb(tuple(a), tuple(b), wide, thin)(points), brute, atol=2e-3)


SHAPES = {
    "disk": disk((40, 40), 17.3),
    "limb": limb((20, 25), (55, 60), 12.0, 5.0),
    "stroke": stroke([(20, 20), (40, 30), (60, 60)], 9.0),
    "union": union(disk((30, 30), 15.0), disk((48, 50), 18.0)),
    "hole": without(disk((40, 40), 30.0), disk((36, 42), 11.0)),
    "blend": blended(8.0, disk((30, 30), 15.0), limb((30, 30), (64, 60), 7.0)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_rings_lie_on_the_zero_of_the_signed_distance(name):
    shape = SHAPES[name]
    found = rings(shape, (80, 80))
    assert len(found) == (2 if name == "hole" else 1)
    assert np.abs(shape(np.concatenate(found))).max() < 1e-6
    between = np.concatenate([0.5 * (ring + np.roll(ring, -1, axis=0)) for ring in found])
    assert np.abs(shape(between)).max() < 0.25  # at most where a chord cuts a corner
    assert np.median(np.abs(shape(between))) < 0.005


@pytest.mark.parametrize("shape", [disk((40, 40), 60.0), disk((5, 40), 20.0), disk((40, 40), -1.0)])
def test_a_shape_that_is_empty_or_too_large_is_refused(shape):
    with pytest.raises(ValueError, match="empty or reaches out"):
        rings(shape, (80, 80))


def test_curves_have_the_given_distance_from_their_center():
    (ring,) = ellipse((40, 50), 10.0, 20.0, 0.7)
    down, right = (ring - (40, 50)).T
    along, across = right * np.cos(0.7) + down * np.sin(0.7), down * np.cos(0.7) - right * np.sin(0.7)
    np.testing.assert_allclose(np.hypot(along / 20.0, across / 10.0), 1.0, rtol=1e-9)
    (star,) = curve((40, 50), lambda angle: 20.0 + 5.0 * np.cos(3.0 * angle))
    angle = np.arctan2(*(star - (40, 50)).T)
    np.testing.assert_allclose(np.linalg.norm(star - (40, 50), axis=1), 20.0 + 5.0 * np.cos(3.0 * angle), rtol=1e-9)


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
        points = sampled(contour.path, 1.0)
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
    outline = np.concatenate([sampled(ring.path, 0.1) for ring in closed(shape.outline)])
    for line in shape.axis:
        along = (line.points[1] - line.points[0]) / line.length
        for place in sampled(line.path, 4.0):
            off = outline - place
            left = off[:, 0] * along[1] - off[:, 1] * along[0] > 0.0
            one, other = (np.hypot(*off[side].T).min() for side in (left, ~left))
            assert one == pytest.approx(other, abs=0.25)  # a chord may cut an inner corner by as much
        end = line.points[1]  # the farthest place: the disk about it touches the outline at the tip
        assert np.hypot(*(outline - end).T).min() == pytest.approx(
            np.hypot(*(outline[np.argmax((outline - end) @ along)] - end)), abs=0.02
        )


def test_noise_changes_the_given_percentage_of_pixels():
    gray = np.full((120, 100), 100.0)
    for spoil, levels in ((studies.uniform, 256), (studies.salt_and_pepper, 2)):
        spoiled = spoil(gray, 60.0, 3)
        changed = spoiled[spoiled != 100.0]
        assert len(changed) / gray.size == pytest.approx(0.6, abs=0.004)
        assert len(np.unique(changed)) <= levels
        assert (changed.min(), changed.max()) == (0.0, 255.0)
        assert changed.mean() == pytest.approx(127.5, abs=3.0)
    assert (studies.gaussian(gray, 20.0, 3) - gray).std() == pytest.approx(20.0, rel=0.02)
    strong = studies.gaussian(gray, 100.0, 3)
    assert (strong.min(), strong.max()) == (0.0, 255.0)


@pytest.mark.parametrize("contrast", [20.0, 40.0, 60.0])
def test_more_damping_never_finds_more_objects(contrast):
    """Without any damping particles swing on, and where they are at the end is chance."""
    found = recovery.count_over_damping(contrast, (0.2, 0.4, 1.0, 4.0))
    assert found == sorted(found, reverse=True)
    assert found[0] == len(silhouettes.ACROSS)
    assert found[-1] < found[0]


def test_a_run_has_snapshots_at_the_requested_steps_and_at_its_end():
    scene = silhouettes.for_sensitivity()
    done = run(scene, at=(10, 20, 10**6))
    assert [moment.step for moment in done.moments] == [10, 20]
    assert done.moments[0].agreement.recall < done.end.agreement.recall
    assert done.end.step > 20
    assert done.end.facts["steps"] == done.end.step
    assert done.end.facts["particles"] == len(done.end.particles)


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


def test_a_summary_holds_ranges_and_sums():
    other = {**RESULT, "recall": 0.5, "closed": 2, "steps": 30, "mean_distance_px": None}
    assert summary([RESULT, other]) == (
        "recall 0.500 to 1.000 and precision 0.900 within 1.0 px, mean distance 0.100 px, 3 of 4 closed contours, "
        "10 to 30 steps, 20 particles"
    )
    assert summary([]) == ""


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


def test_one_figure_made_again_leaves_the_others_in_the_index(tiny, tmp_path):
    write_figures(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    (tmp_path / "fig05.png").write_bytes(b"old")
    assert [path.name for path in write_figures(tmp_path, ["fig05"])] == ["fig05.png", "figures.json", "README.md"]
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_figure_of_the_gallery_is_made_by_the_command_line(tmp_path, capsys):
    assert main(["--output", str(tmp_path), "--only", "fig08"]) is None
    output = capsys.readouterr()
    assert re.match(r"fig08 +\d+\.\d s  Boundary concavities: recall ", output.out)
    assert output.out.endswith(f"Wrote 3 files to {tmp_path}\n")
    assert output.err == ""
    assert opened((tmp_path / "fig08.png").read_bytes()).width == 2 * 18 + 5 * 290 + 4 * 14


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("", "--output"),
        ("--output new --only fig99", "no figure fig99: choose among fig05"),
        ("--output file", "file is a file, so file cannot be a folder: name another one"),
        ("--output damaged", "cannot be read: remove it"),
        ("--output none/new/in/here", "new is a file, so none/new/in/here cannot be a folder"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(tiny, tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("a file", encoding="utf-8")
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "figures.json").write_text("[", encoding="utf-8")
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "new").write_text("a file", encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(SystemExit):
        main(arguments.split())
    assert words in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


def test_without_matplotlib_a_sentence_says_what_to_install(tiny, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(SystemExit):
        main(["--output", str(tmp_path / "new")])
    assert "pip install matplotlib" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


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
