"""Loads the compiled loops into the process that others are copies of."""

from cpm_core.warm_up import FIRST, warm_up

warm_up(parts=FIRST)
