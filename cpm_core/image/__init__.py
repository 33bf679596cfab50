"""The image: its pixels and their size, the pyramid, the image border, regions of interest, barriers, and denoising."""

from cpm_core.image.colors import COLOR_CHOICES as COLOR_CHOICES
from cpm_core.image.colors import compute_luminance as compute_luminance
from cpm_core.image.drawing import KNOWN_UNITS as KNOWN_UNITS
from cpm_core.image.drawing import ScaleBar as ScaleBar
from cpm_core.image.drawing import fit_scale_bar as fit_scale_bar
from cpm_core.image.geometry import CONVENTIONS as CONVENTIONS
from cpm_core.image.geometry import Convention as Convention
from cpm_core.image.image import MINIMUM_SIDE as MINIMUM_SIDE
from cpm_core.image.kind import ImageKind as ImageKind
from cpm_core.image.kind import guess_kind as guess_kind
from cpm_core.image.pyramid import max_scales as max_scales
from cpm_core.image.volume_regions import AnyRegions as AnyRegions
from cpm_core.image.volume_regions import plane_regions as plane_regions
