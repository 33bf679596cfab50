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
    monkeypatch.setattr(memory, "free", lambda: there)
    with pytest.raises(ValueError, match="make it smaller") as told:
        memory.check_room(shape, 80.0, "a.tif")
    fitting = re.search(r"about ([\d,]+(?: × [\d,]+)+) px", str(told.value)).group(1)
    sides = [int(side.replace(",", "")) for side in fitting.split(" × ")]
    assert 0.9 * there < 80.0 * math.prod(sides) <= there
    memory.check_room(tuple(sides), 80.0, "a.tif")


def test_the_fields_of_an_image_are_not_begun_without_memory_for_them(monkeypatch):
    image = np.eye(64)
    ImageFields(image)
    monkeypatch.setattr(memory, "free", lambda: 1000.0)
    with pytest.raises(ValueError, match=r"64 × 64 px, which need .* free"):
        ImageFields(image)


@pytest.mark.parametrize(("most", "taken", "left"), [("3000000", "1000000", 2.4e6), ("max", "1000000", math.inf)])
def test_the_limit_of_a_container_counts(monkeypatch, tmp_path, most, taken, left):
    (tmp_path / "memory.max").write_text(f"{most}\n")
    (tmp_path / "memory.current").write_text(f"{taken}\n")
    (tmp_path / "memory.stat").write_text("anon 600000\ninactive_file 300000\nactive_file 100000\n")
    monkeypatch.setattr(memory, "_GROUP", tmp_path)
    monkeypatch.setattr(memory, "_of_the_computer", lambda: 5e9)  # other programs change it at any moment
    assert memory.free() == min(left, 5e9, memory._of_the_process())


def test_where_the_system_does_not_say_nothing_is_refused(monkeypatch, tmp_path):
    for name in ("_of_the_computer", "_of_the_process"):
        monkeypatch.setattr(memory, name, lambda: math.inf)
    monkeypatch.setattr(memory, "_GROUP", tmp_path)
    memory.check_room((10**6, 10**6), 1e6, "a.tif")
