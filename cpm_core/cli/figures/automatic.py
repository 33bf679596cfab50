"""Segmentation from starts that need no drawing: the experiments of Fig. 12 and 13."""

from __future__ import annotations

from cpm_core.cli.figures import pictures
from cpm_core.cli.figures.pages import Page
from cpm_core.cli.figures.recovery import from_start_to_result

_TOLERANCE = 1.5


def medical() -> Page:
    """Fig. 12: two starts on strong gradients, two uniform ones."""
    scenes = {
        "cells; start on gradients": pictures.cells(),
        "chromosomes; start on gradients": pictures.chromosomes(),
        "hand; uniform start": pictures.radiograph(),
        "head; uniform start": pictures.slice_of_a_head(),
    }
    return from_start_to_result(scenes, _TOLERANCE)


def natural() -> Page:
    """Fig. 13: shaded and textured scenes, started on strong gradients."""
    scenes = {
        "pebbles on sand": pictures.pebbles(),
        "hills and a lake": pictures.hills(),
        "pears on cloth": pictures.pears(),
    }
    return from_start_to_result(scenes, _TOLERANCE)
