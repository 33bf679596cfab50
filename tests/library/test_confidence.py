"""How sure an answer is can be read from it, and asked for."""

from __future__ import annotations

import numpy as np
import pytest

import cpm_core as cpm


def test_an_answer_in_the_background_says_that_there_may_be_no_object():
    partition = cpm.partition(cpm.example("disks"))
    for place, remark in (((32, 18), ""), ((5, 5), "There may be no object here: the confidence is almost zero.")):
        chosen = partition.select([place])
        assert chosen.remark == remark
        assert (chosen.confidence < 0.05) == bool(remark)
        again = partition.select([place, (place[0], place[1] + 1)], previous=chosen)
        assert again.has_same_region(chosen) and again.remark == remark


def test_all_objects_are_at_least_as_sure_as_asked():
    rows, cols = np.mgrid[:96, :96]
    values = np.zeros((96, 96))
    for row, col, height in ((24, 24, 200.0), (24, 70, 120.0), (70, 30, 60.0), (70, 70, 20.0)):
        values[np.hypot(rows - row, cols - col) < 12] = height
    image = cpm.Image(values + np.random.default_rng(5).normal(0.0, 6.0, values.shape))
    sure = sorted(one.confidence for one in cpm.select_all(image))
    assert len(sure) >= 3
    middle = 0.5 * (sure[0] + sure[-1])
    kept = cpm.select_all(image, min_confidence=middle)
    assert len(kept) == sum(share >= middle for share in sure)
    assert cpm.select_all(image, min_confidence=1.0) == ()
    first = cpm.select(image, [(24, 24)])
    assert cpm.select_all(image, [first], min_confidence=1.0) == (first,)
    for wrong in (-0.1, 2, "sure"):
        with pytest.raises(ValueError, match=r"min_confidence is .* but must be from 0 to 1"):
            cpm.select_all(image, min_confidence=wrong)


def test_all_objects_take_the_parameters_of_their_run():
    image = cpm.example("disks")
    assert len(cpm.select_all(image, parameters="automatic")) == 2
    with pytest.raises(ValueError, match="parameters is"):
        cpm.select_all(image, parameters="atomatic")
