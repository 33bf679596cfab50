"""Larger models answer the prompts that the network answers, as candidates with confidence within the same limits."""

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.formats.common.provenance import describe_provenance
from cpm_core.numerics.grids import true_bounds
from cpm_core.objects import Partition, compute_iou
from cpm_core.objects.prior.larger_models import check_model, encode_image, is_fetched
from tests.core.objects import onnx_models

pytestmark = pytest.mark.skipif(find_spec("osam") is None, reason="the extra `sam` is not installed")

ROWS, COLS = np.indices((150, 200))
RING = (np.hypot(ROWS - 60, COLS - 120) < 40) & (np.hypot(ROWS - 60, COLS - 120) > 12)
HOLE = np.hypot(ROWS - 60, COLS - 120) <= 12
VALUES = 100.0 * RING + 130.0 * HOLE


@pytest.fixture(params=onnx_models.DECODERS)
def model(request, tmp_path) -> str:
    return onnx_models.write_model(tmp_path, request.param)


@pytest.fixture
def partition(model) -> Partition:
    return Partition(cpm.Image(VALUES), (), model=model)


PROMPTS = {
    "click": ({"inside": [(60, 150)]}, RING),
    "scribble": ({"stroke": [(90, 105), (92, 120), (90, 135)]}, RING),
    "box": ({"box": [(47, 106), (73, 134)]}, HOLE),
    "circle": ({"inside": cpm.circle((90, 120), 6)}, RING),
}


@pytest.mark.parametrize(("prompt", "truth"), PROMPTS.values(), ids=PROMPTS)
def test_a_model_answers_every_prompt(partition, prompt, truth) -> None:
    found = partition.select(**prompt)
    assert compute_iou(found.mask, truth) > 0.8
    assert (found.model, found.features.predicted_iou) == (Path(partition.model).name, pytest.approx(0.97))


def test_its_answers_are_candidates_with_confidence(partition) -> None:
    found = partition.find_candidates([(60, 150)])
    assert max(compute_iou(one.mask, RING | HOLE) for one in found) > 0.8
    ring = max(found, key=lambda one: compute_iou(one.mask, RING))
    assert ring.confidence == max(one.confidence for one in found) > 0.5


def test_what_only_edges_bound_is_no_answer_of_a_model(model, monkeypatch) -> None:
    row, col = np.indices((90, 120))
    bounded = (row < 50) & (col < 70)
    values = 60.0 + 90.0 * bounded + np.random.default_rng(3).normal(0.0, 2.0, bounded.shape)
    cut = Partition(cpm.Image(values), (), model=model)
    monkeypatch.setattr(type(cut._predictor), "predict_objects", lambda *given: iter(()))
    found = cut.find_candidates([(25, 35)])
    assert max(compute_iou(one.mask, bounded) for one in found) > 0.9
    assert {one.model for one in found} == {""}


def test_limits_hold_and_clicks_correct(partition) -> None:
    found = partition.select([(60, 150)], excluded=ROWS > 80)
    assert found.mask.any() and true_bounds(found.mask)[1][0] == 80
    first = partition.select([(60, 150)])
    with_hole = partition.select([(60, 150), (60, 120)], previous=first)
    assert with_hole.mask[60, 120] and not (first.mask & ~with_hole.mask).any()
    less = partition.select([(60, 150)], [(60, 90)], previous=first)
    assert not less.mask[60, 90] and not (less.mask & ~first.mask).any()


def test_what_particles_have_closed_comes_first_and_gives_the_boundary(model) -> None:
    disks = cpm.example("disks")
    assert cpm.partition(disks, model=model).select([(32, 18)]).model == ""
    large, truth = (np.kron(each, np.ones((2, 2))) for each in (VALUES, RING))
    run = cpm.segment(large, cpm.circle((120.5, 240.5), 90), "shape")
    ways = Partition.from_result(run, model), Partition(cpm.Image(large), (), model=model)
    exact, coarse = (way.select(stroke=[(180, 210), (184, 240), (180, 270)]) for way in ways)
    assert exact.model == coarse.model == Path(model).name
    assert min(compute_iou(one.mask, truth > 0) for one in (exact, coarse)) > 0.9
    assert sum(map(len, exact.gaps)) < sum(map(len, coarse.gaps))


def test_files_name_the_model(model) -> None:
    found = cpm.select(VALUES, [(60, 150)], model=model)
    facts = describe_provenance(cpm.objects_result([found]))
    assert facts["model"] == found.model == Path(model).name
    assert "model" not in describe_provenance(cpm.objects_result([replace(found, model="")]))


@pytest.fixture
def home(monkeypatch, tmp_path) -> Path:
    """A home without models."""
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(tmp_path / "home"))
    return tmp_path / "home"


def pull_small_files(kind, progress, cancel) -> None:
    """What osam does, with small files."""
    folder = Path(next(iter(kind._blobs.values())).path).parent
    folder.mkdir(parents=True, exist_ok=True)
    onnx_models.write_model(folder, "sam2")
    for part, blob in kind._blobs.items():
        for megabytes in (0, 75):
            try:
                progress(part, megabytes * 10**6, None)
            except Exception as error:
                raise RuntimeError("canceled" if cancel.is_set() else "failed") from error
        (folder / f"small.{part}.onnx").rename(blob.path)


def test_weights_are_fetched_on_request_alone(home, monkeypatch) -> None:
    kind, shares = pytest.importorskip("osam").apis.get_model_type_by_name("sam2:tiny"), []
    with pytest.raises(ValueError, match="is not on this computer: fetch it once by cpm model sam2:tiny"):
        cpm.select(VALUES, [(60, 150)], model="sam2:tiny")
    monkeypatch.setattr(kind, "pull", classmethod(pull_small_files))
    with pytest.raises(StoppedError):
        cpm.fetch_model("sam2:tiny", stop)
    assert not is_fetched("sam2:tiny")
    cpm.fetch_model("sam2:tiny", shares.append)
    assert shares == [0.0, 0.5, 0.5, 1.0]
    monkeypatch.delattr(kind, "pull")
    found = cpm.select(VALUES, [(60, 150)], model="sam2:tiny")
    assert compute_iou(found.mask, RING) > 0.85 and found.model == "sam2:tiny"


class StoppedError(Exception):
    """The user has stopped it."""


def stop(_: float) -> None:
    raise StoppedError


@pytest.mark.parametrize(
    ("model", "ndim", "sentence"),
    [("sam9", 2, "sam9.* is not known: choose one of efficientsam:10m"), ("sam2", 3, "not in volumes")],
)
def test_models_that_cannot_answer_say_why(model, ndim, sentence) -> None:
    with pytest.raises(ValueError, match=sentence):
        check_model(model, ndim)


def test_files_of_no_model_say_so(tmp_path) -> None:
    for part in ("encoder", "decoder"):
        (tmp_path / f"{part}.onnx").write_bytes(b"nothing")
    with pytest.raises(ValueError, match="is no model of a known kind"):
        encode_image(str(tmp_path), np.zeros((8, 8, 3), np.uint8))
