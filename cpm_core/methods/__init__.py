"""The classical methods next to the charged particles: the same image, the same drawn start, one interface.

`method` defines what a method is; `comparison` lists all methods by name and runs them. Snakes are in `snakes`, level
sets in `level_sets`, and the methods of scikit-image in `regions`.
"""

from cpm_core.methods.comparison import CONTOUR_METHODS as CONTOUR_METHODS
from cpm_core.methods.comparison import METHODS as METHODS
from cpm_core.methods.comparison import MethodStep as MethodStep
from cpm_core.methods.comparison import RunReport as RunReport
from cpm_core.methods.comparison import build_method_result as build_method_result
from cpm_core.methods.comparison import iterate_method as iterate_method
from cpm_core.methods.comparison import register_method as register_method
from cpm_core.methods.comparison import report_run as report_run
from cpm_core.methods.comparison import run_method as run_method
from cpm_core.methods.method import AnyMethod as AnyMethod
from cpm_core.methods.method import ContourMethod as ContourMethod
from cpm_core.methods.method import ContourState as ContourState
from cpm_core.methods.method import Settings as Settings
from cpm_core.methods.method import Start as Start
