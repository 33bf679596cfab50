"""CPM: contours by charged particles."""

from cpm_core.contour import Contour
from cpm_core.coulomb import coulomb_force
from cpm_core.edge_map import edge_map
from cpm_core.engine import Engine
from cpm_core.field.convolution import electric_field
from cpm_core.formats import export, load_image
from cpm_core.image import Image
from cpm_core.initialization import circle, gradient_threshold, uniform_grid
from cpm_core.parameters import PARAMETERS, PRESETS, Parameters
from cpm_core.particles import Particles, State
from cpm_core.reconstruction import reconstruct_curve
from cpm_core.result import Result
from cpm_core.segmentation import segment

__all__ = [
    "PARAMETERS",
    "PRESETS",
    "Contour",
    "Engine",
    "Image",
    "Parameters",
    "Particles",
    "Result",
    "State",
    "circle",
    "coulomb_force",
    "edge_map",
    "electric_field",
    "export",
    "gradient_threshold",
    "load_image",
    "reconstruct_curve",
    "segment",
    "uniform_grid",
]
