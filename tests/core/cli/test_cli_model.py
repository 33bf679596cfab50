"""``cpm model`` lists larger models, and ``cpm run --object --model`` lets one answer."""

import json

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.cli import main
from tests.core.cli.test_help import VALIDATOR


def test_the_models_are_listed_with_size_and_license(capsys) -> None:
    assert main(["model", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    VALIDATOR.validate(listed)
    assert [one["name"] for one in listed["models"]] == list(cpm.MODELS)
    assert main(["model"]) == 0
    assert cpm.MODELS["sam2:tiny"].summary in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--circle", "9,9,5", "--model", "sam2"], "--model is given without --object"),
        (["--volume", "--object", "9,9,9", "--model", "sam2"], "not in volumes"),
        (["--object", "9,9", "--model", "sam9"], "is not known: choose one of"),
    ],
)
def test_a_model_that_cannot_answer_is_refused_before_the_run(options, sentence, tmp_path, capsys) -> None:
    np.save(tmp_path / "a.npy", np.zeros((20, 20)))
    assert main(["run", str(tmp_path / "a.npy"), *options]) == 2
    assert sentence in capsys.readouterr().err


def test_the_named_model_answers_and_files_name_it(tmp_path) -> None:
    pytest.importorskip("osam")
    models = pytest.importorskip("tests.core.objects.onnx_models")
    rows, cols = np.indices((64, 64))
    np.save(tmp_path / "a.npy", np.where(np.hypot(rows - 32, cols) < 18, 200.0, 20.0))
    (tmp_path / "mine").mkdir()
    model, target = models.write_model(tmp_path / "mine", "sam2"), tmp_path / "a.json"
    assert main(["run", str(tmp_path / "a.npy"), "--object", "32,8", "--model", model, "--export", str(target)]) == 0
    assert json.loads(target.read_text("utf-8"))["provenance"]["model"] == "mine"
