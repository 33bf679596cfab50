"""Loads the compiled loops into the process that others are copies of, in a way that a copy can use."""

import numba

from cpm_core.objects.warm_up import reconstruct_once, step_once

numba.config.THREADING_LAYER = "workqueue"  # the only one whose threads a copy starts again
step_once()
reconstruct_once()
