"""The classical methods next to the charged particles: the same image, the same drawn start, one interface.

`method` defines what a method is; `comparison` lists all methods by name and runs them. Snakes are in `snakes`, level
sets in `level_sets`, and the methods of scikit-image in `regions`.
"""

from cpm_core.methods.comparison import (
    CONTOUR_METHODS,
    METHODS,
    MethodStep,
    RunReport,
    build_method_result,
    iterate_method,
    register_method,
    report_run,
    run_method,
)
from cpm_core.methods.method import AnyMethod, ContourMethod, ContourState, Settings, Start

__all__ = [
    "CONTOUR_METHODS",
    "METHODS",
    "AnyMethod",
    "ContourMethod",
    "ContourState",
    "MethodStep",
    "RunReport",
    "Settings",
    "Start",
    "build_method_result",
    "iterate_method",
    "register_method",
    "report_run",
    "run_method",
]
