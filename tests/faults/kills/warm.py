"""Loads the compiled loops into the process that others are copies of."""

from cpm_core.objects.warm_up import warm_up
from cpm_core.objects.warm_up.parts import FIRST

warm_up(parts=FIRST)
