"""Work that cannot fit into memory is refused with a size that would."""

import math
import re

import numpy as np
import pytest

from cpm_core.model.image_fields import ImageFields
from cpm_core.numerics import memory


@pytest.mark.parametrize("shape", [(30_000, 20_000), (900, 800, 700)])
def test_an_image_that_cannot_fit_is_refused_with_a_size_that_would(monkeypatch, shape):
    there = 0.1 * 80.0 * math.prod(shape)
    monkeypatch.setattr(memory, "available_memory", lambda: there)
    with pytest.raises(ValueError, match="make it smaller") as told:
        memory.check_field_memory(shape, 80.0, "a.tif")
    fitting = re.search(r"about ([\d,]+(?: × [\d,]+)+) px", str(told.value)).group(1)
    sides = [int(side.replace(",", "")) for side in fitting.split(" × ")]
    assert 0.9 * there < 80.0 * math.prod(sides) <= there
    memory.check_field_memory(tuple(sides), 80.0, "a.tif")


def test_the_fields_of_an_image_are_not_begun_without_memory_for_them(monkeypatch):
    image = np.eye(64)
    ImageFields(image)
    monkeypatch.setattr(memory, "available_memory", lambda: 1000.0)
    with pytest.raises(ValueError, match=r"64 × 64 px, which need .* free"):
        ImageFields(image)
