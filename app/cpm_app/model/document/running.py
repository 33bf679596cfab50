"""The run of a document from its start to its result."""

from __future__ import annotations

from collections.abc import Callable

from cpm_app.model.document.document import Document
from cpm_core import Engine, Evolution, Result, State
from cpm_core.shapes import ImageSeeds


def run_document(engine: Engine, document: Document, seeds: ImageSeeds, progress: Callable[[State], object]) -> Result:
    """Run a document to its result; `progress` is called with each state, first the start.

    `seeds` are the seeds of the starts that depend on the image.
    """
    run = Evolution(engine, engine.start(document.collect_seeds(seeds)), document.parameters, charges=document.charges)
    for moment in run:
        progress(moment.state)
    return run.result
