"""Loads the compiled loops into the process that others are copies of."""

from cpm_core.objects.warm_up import reconstruct_once, step_once

step_once()
reconstruct_once()
