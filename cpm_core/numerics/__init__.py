"""Numerical foundations of the model: compiled loops and their cache, threads, grids, and the geometry of lines."""

from cpm_core.numerics.jit import compiled as compiled
from cpm_core.numerics.parallel import count_cores as count_cores
from cpm_core.numerics.parallel import run_in_parallel as run_in_parallel
from cpm_core.numerics.polyline import drop_flat_corners as drop_flat_corners
from cpm_core.numerics.polyline import path_length as path_length
from cpm_core.numerics.polyline import simplify_path as simplify_path
from cpm_core.numerics.real_numbers import check_voxel_sides as check_voxel_sides
from cpm_core.numerics.segments import PathTree as PathTree
from cpm_core.numerics.types import Array as Array
from cpm_core.numerics.types import Index as Index
from cpm_core.numerics.types import Mask as Mask
from cpm_core.numerics.types import Pixels as Pixels
from cpm_core.numerics.types import Place as Place
from cpm_core.numerics.types import Position as Position
from cpm_core.numerics.types import Single as Single
