"""Results: what a run or a selection found, and the objects in it."""

from cpm_core.results.found_objects import FoundObjects as FoundObjects
from cpm_core.results.found_objects import find_objects as find_objects
from cpm_core.results.found_objects import is_likely as is_likely
from cpm_core.results.objects_result import add_segmented_objects as add_segmented_objects
from cpm_core.results.objects_result import boundaries_in_image as boundaries_in_image
from cpm_core.results.objects_result import boundaries_result as boundaries_result
from cpm_core.results.objects_result import objects_result as objects_result
from cpm_core.results.objects_result import replace_by_objects as replace_by_objects
from cpm_core.results.result import Result as Result
