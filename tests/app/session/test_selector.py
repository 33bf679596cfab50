"""What is known of earlier clicks is not worked out again."""

import pytest
from cpm_app.session.features.selector import Selector

from cpm_core import Partition, example, partition
from cpm_core.objects.segmented import Click


def test_each_place_under_the_pointer_costs_one_answer_however_many_came_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    there = partition(example("disks"))
    answer, asked = there.select([(32.0, 18.0)]), []
    monkeypatch.setattr(Partition, "select", lambda *given, **more: asked.append(given) or answer)
    selector, clicks = Selector(there, ()), tuple(Click(((32.0, col),)) for col in (16.0, 18.0, 20.0))
    for col in range(300):
        selector.selection_for((*clicks, Click(((10.0, float(col)),))))
    assert len(asked) == len(clicks) + 300
