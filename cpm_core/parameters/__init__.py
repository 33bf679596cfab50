"""Parameters of the model: numbers and choices, presets, and the provenance of results."""

from cpm_core.parameters.choices import CHOICES as CHOICES
from cpm_core.parameters.choices import Invalidates as Invalidates
from cpm_core.parameters.parameters import DEFAULTS as DEFAULTS
from cpm_core.parameters.parameters import PLANE_PRESETS as PLANE_PRESETS
from cpm_core.parameters.parameters import PRESETS as PRESETS
from cpm_core.parameters.parameters import Parameters as Parameters
from cpm_core.parameters.provenance import Provenance as Provenance
from cpm_core.parameters.provenance import taken as taken
from cpm_core.parameters.quotation import shown as shown
from cpm_core.parameters.table import AUTOMATIC as AUTOMATIC
from cpm_core.parameters.table import OF_CHARGES as OF_CHARGES
from cpm_core.parameters.table import OF_PLANES as OF_PLANES
from cpm_core.parameters.table import OF_SKELETONS as OF_SKELETONS
from cpm_core.parameters.table import OF_STARTS as OF_STARTS
from cpm_core.parameters.table import OF_VOLUMES as OF_VOLUMES
from cpm_core.parameters.table import PARAMETERS as PARAMETERS
from cpm_core.parameters.table import UNLIMITED_REACH as UNLIMITED_REACH
from cpm_core.parameters.table import ParameterInfo as ParameterInfo
from cpm_core.parameters.table import invalidating as invalidating
