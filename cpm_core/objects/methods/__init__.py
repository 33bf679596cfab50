"""The classical methods beside the charged particles: the same image, the same drawn start, one interface.

`method` says what a method is; `registry` has all of them by name; `run` runs one. Snakes are in `snakes`, level
sets in `level_sets`, and what scikit-image and OpenCV have in `regions`.
"""

from cpm_core.objects.methods.compared import Compared
from cpm_core.objects.methods.method import AnyMethod, ContourMethod, ContourState, Start
from cpm_core.objects.methods.outcome import result_of
from cpm_core.objects.methods.registry import CONTOUR_METHODS, method_named, runnable
from cpm_core.objects.methods.run import Facts, Moment, facts_of, moments, run_method
from cpm_core.objects.methods.settings import Settings

__all__ = [
    "CONTOUR_METHODS",
    "AnyMethod",
    "Compared",
    "ContourMethod",
    "ContourState",
    "Facts",
    "Moment",
    "Settings",
    "Start",
    "facts_of",
    "method_named",
    "moments",
    "result_of",
    "run_method",
    "runnable",
]
