"""Memory of a window that is used for hours.

What is free is given back to the system, and only while the worker has nothing to do; runs that follow each other take
no more than the first few.
"""

from __future__ import annotations

import gc
import weakref

import numpy as np
from cpm_app.model.document.document import Document
from cpm_app.session.timeline.timeline import Timeline

from cpm_core import Engine, Parameters
from cpm_core.image.regions import Regions
from cpm_core.model.starts import circle


def test_runs_in_many_regions_hold_the_fields_of_a_few() -> None:
    """A method has the fields of the image in its regions; the timeline makes those of a former run again."""
    row, col = np.indices((48, 48))
    plain = Engine(np.where(np.hypot(row - 24, col - 24) < 12, 200.0, 20.0), Parameters(scales=1))
    timeline, made = Timeline(lambda _: plain), []
    for run in range(9):
        corner = 40.0 + 0.5 * run
        regions = Regions(interest=[[(2, 2), (2, corner), (corner, corner), (corner, 2)]])
        document = Document(parameters=Parameters(scales=1, beta=0.5 + 0.01 * run))
        timeline.begin_run(plain.start(circle((24.0, 24.0), 8.0)), document)
        made.append(weakref.ref(timeline.method_of_run(timeline.current_run, regions)))
        gc.collect()
    assert len({branch.run for branch in timeline.timeline_state.branches}) == 1  # runs without a step are not kept
    assert sum(engine() is not None for engine in made) <= 3
