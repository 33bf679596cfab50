"""A short run of each part that tries damaged and random input; ``python -m tests.faults`` runs them at length."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest

from tests.faults.fuzzing import calls, command_line, files, images, sessions, volumes
from tests.faults.fuzzing.inputs.mutations import VALUES, mutated_json
from tests.faults.fuzzing.inputs.session_samples import sample
from tests.faults.fuzzing.limits import TooLongError, failure_of, in_time
from tests.faults.fuzzing.trials import at_length, at_once, random_of
from tests.faults.report import Budget


def test_damaged_files_are_read_or_refused_in_one_sentence(tmp_path: Path) -> None:
    assert at_once(files.trial, 10, tmp_path) == 200


def test_damaged_sessions_are_read_or_refused_in_one_sentence(tmp_path: Path, compiled_loops: None) -> None:
    assert at_once(sessions.trial, 2, tmp_path) == 40


def test_calls_give_finite_results_or_are_refused_in_one_sentence(tmp_path: Path, compiled_loops: None) -> None:
    calls.prepare()
    assert calls.trial(Random(1), tmp_path, 60) > 50


def test_runs_on_any_image_end_within_it(tmp_path: Path, compiled_loops: None) -> None:
    assert images.trial(Random(1), tmp_path, 10) > 10


def test_runs_on_any_volume_end_within_it(tmp_path: Path, compiled_loops: None) -> None:
    volumes.prepare()
    assert volumes.trial(Random(1), tmp_path, 10) > 10


def test_any_arguments_end_in_words(tmp_path: Path, compiled_loops: None) -> None:
    assert at_once(command_line.trial, 2, tmp_path) == 8


def test_a_trial_is_the_same_for_the_same_seed(tmp_path: Path) -> None:
    contents = []
    for _ in range(2):
        at_once(files.trial, 1, tmp_path, seed=5)
        contents.append({path.name: path.read_bytes() for path in tmp_path.iterdir()})
    assert contents[0] == contents[1]


def test_what_damages_one_session_stays_out_of_the_next_and_fills_no_memory(tmp_path: Path) -> None:
    before = json.dumps(VALUES)
    sizes = [len(json.dumps(mutated_json(sample(tmp_path), random_of(5, number)))) for number in range(200)]
    assert json.dumps(VALUES) == before
    assert max(sizes) < 200e6


def test_what_never_ends_is_stopped_and_told_with_its_place() -> None:
    def endless() -> None:
        while True:
            pass

    with pytest.raises(TooLongError) as caught, in_time(0.05):
        endless()
    assert failure_of(caught.value).startswith("TooLongError: took more than 0.05 s [tests/faults/fuzzing/")


def fail(random: Random, folder: Path) -> int:
    raise KeyError(f"lost in {folder.name}")


def test_a_failure_is_told_with_what_repeats_it(tmp_path: Path) -> None:
    (failure,) = at_length(fail, Budget(0.01, 7, tmp_path)).failures
    assert failure.startswith(f"trial 0 of seed 7: KeyError: 'lost in {tmp_path.name}' [tests/faults/fuzzing/test_fuzz")
