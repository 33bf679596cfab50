"""Parameters of the model: numbers and choices, presets, and the provenance of results."""

from cpm_core.parameters.choices import CHOICE_PARAMETERS as CHOICE_PARAMETERS
from cpm_core.parameters.choices import Invalidates as Invalidates
from cpm_core.parameters.formatting import quote_value as quote_value
from cpm_core.parameters.parameters import DEFAULT_VALUES as DEFAULT_VALUES
from cpm_core.parameters.parameters import PLANE_PRESETS as PLANE_PRESETS
from cpm_core.parameters.parameters import PRESETS as PRESETS
from cpm_core.parameters.parameters import Parameters as Parameters
from cpm_core.parameters.parameters import choose_parameters as choose_parameters
from cpm_core.parameters.provenance import Provenance as Provenance
from cpm_core.parameters.provenance import select_parameters as select_parameters
from cpm_core.parameters.table import AUTOMATIC_PARAMETERS as AUTOMATIC_PARAMETERS
from cpm_core.parameters.table import CHARGE_PARAMETERS as CHARGE_PARAMETERS
from cpm_core.parameters.table import PARAMETERS as PARAMETERS
from cpm_core.parameters.table import PLANE_PARAMETERS as PLANE_PARAMETERS
from cpm_core.parameters.table import SKELETON_PARAMETERS as SKELETON_PARAMETERS
from cpm_core.parameters.table import START_PARAMETERS as START_PARAMETERS
from cpm_core.parameters.table import UNLIMITED_REACH as UNLIMITED_REACH
from cpm_core.parameters.table import VOLUME_PARAMETERS as VOLUME_PARAMETERS
from cpm_core.parameters.table import ParameterInfo as ParameterInfo
from cpm_core.parameters.table import find_invalidating as find_invalidating
