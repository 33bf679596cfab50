"""The image: its pixels and their size, the pyramid, the image border, regions of interest, barriers, and denoising."""

from cpm_core.image.colors import COLORS as COLORS
from cpm_core.image.colors import luminance as luminance
from cpm_core.image.drawing import KNOWN as KNOWN
from cpm_core.image.drawing import Bar as Bar
from cpm_core.image.drawing import has_matplotlib as has_matplotlib
from cpm_core.image.drawing import longest_bar as longest_bar
from cpm_core.image.geometry import CONVENTIONS as CONVENTIONS
from cpm_core.image.geometry import Convention as Convention
from cpm_core.image.image import MINIMUM_SIDE as MINIMUM_SIDE
from cpm_core.image.kind import Kind as Kind
from cpm_core.image.kind import guessed_kind as guessed_kind
from cpm_core.image.pyramid import most_scales as most_scales
from cpm_core.image.volume_regions import AnyRegions as AnyRegions
from cpm_core.image.volume_regions import of_plane as of_plane
