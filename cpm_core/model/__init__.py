"""The model of the paper: particles, the laws that move them, and one step of a run in the plane and in a volume."""

from cpm_core.model.equations import EPSILON_BOUND as EPSILON_BOUND
from cpm_core.model.image_fields import ImageFields as ImageFields
