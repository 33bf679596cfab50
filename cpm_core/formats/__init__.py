"""Formats: a module reads or writes one kind of file; `readers` and `writers` choose the module for a file."""

from cpm_core.formats.animation import ANIMATED as ANIMATED
from cpm_core.formats.animation import check_animation as check_animation
from cpm_core.formats.animation import check_encoder as check_encoder
from cpm_core.formats.animation import write_picture as write_picture
from cpm_core.formats.common.atomic import remove_abandoned as remove_abandoned
from cpm_core.formats.common.atomic import write_together as write_together
from cpm_core.formats.common.content import UnreadableError as UnreadableError
from cpm_core.formats.common.content import fingerprint as fingerprint
from cpm_core.formats.common.plain import NAMES as NAMES
from cpm_core.formats.common.plain import array_from_plain as array_from_plain
from cpm_core.formats.common.plain import array_to_plain as array_to_plain
from cpm_core.formats.common.plain import from_plain as from_plain
from cpm_core.formats.common.plain import items as items
from cpm_core.formats.common.plain import mapping as mapping
from cpm_core.formats.common.plain import number as number
from cpm_core.formats.common.plain import parameters_from_plain as parameters_from_plain
from cpm_core.formats.common.plain import regions_from_plain as regions_from_plain
from cpm_core.formats.common.plain import regions_to_plain as regions_to_plain
from cpm_core.formats.common.plain import shape_from_plain as shape_from_plain
from cpm_core.formats.common.plain import shape_to_plain as shape_to_plain
from cpm_core.formats.common.plain import to_plain as to_plain
from cpm_core.formats.common.printable import in_natural_order as in_natural_order
from cpm_core.formats.common.provenance import facts_on as facts_on
from cpm_core.formats.common.provenance import plain_shapes as plain_shapes
from cpm_core.formats.common.provenance import text_of as text_of
from cpm_core.formats.comparison import TABLE as TABLE
from cpm_core.formats.contour_file import CONTOURS_READABLE, load_contours
from cpm_core.formats.contour_file import ContourFile as ContourFile
from cpm_core.formats.contour_file import decode_contours as decode_contours
from cpm_core.formats.contour_file import plane_of as plane_of
from cpm_core.formats.contour_file import read_contours as read_contours
from cpm_core.formats.contours.contents import Plane as Plane
from cpm_core.formats.contours.contents import color_of as color_of
from cpm_core.formats.contours.contour_json import page_from_plain as page_from_plain
from cpm_core.formats.contours.contour_json import page_to_plain as page_to_plain
from cpm_core.formats.contours.curves import ellipse as ellipse
from cpm_core.formats.contours.labelme import located as located
from cpm_core.formats.contours.points_csv import load_points
from cpm_core.formats.images.dicom import dicom_files_beside as dicom_files_beside
from cpm_core.formats.images.readers import READABLE, holds_volume, load_image, load_pages, load_volume, open_stack
from cpm_core.formats.images.reading import Reading as Reading
from cpm_core.formats.images.stack import ONLY_THESE as ONLY_THESE
from cpm_core.formats.images.stack import Pages as Pages
from cpm_core.formats.images.stack import Stack as Stack
from cpm_core.formats.masks.labels import palette as palette
from cpm_core.formats.meshes.swc import load_centerlines
from cpm_core.formats.sessions.particle_state import state_from_plain as state_from_plain
from cpm_core.formats.sessions.particle_state import state_to_plain as state_to_plain
from cpm_core.formats.sessions.session_file import SUFFIX as SUFFIX
from cpm_core.formats.sessions.session_file import ImageFile as ImageFile
from cpm_core.formats.sessions.session_file import SessionFile as SessionFile
from cpm_core.formats.sessions.session_file import TruthFile as TruthFile
from cpm_core.formats.sessions.session_file import decode as decode
from cpm_core.formats.sessions.session_file import encode as encode
from cpm_core.formats.sessions.session_file import find_image as find_image
from cpm_core.formats.sessions.session_file import load_session as load_session
from cpm_core.formats.sessions.session_file import save_session as save_session
from cpm_core.formats.stack_files import FOR_STACKS as FOR_STACKS
from cpm_core.formats.stack_files import export_stack as export_stack
from cpm_core.formats.stack_files import stack_suffix_of as stack_suffix_of
from cpm_core.formats.surface_file import SURFACES_READABLE, load_surface
from cpm_core.formats.surface_file import read_surface as read_surface
from cpm_core.formats.writers import DRAWN as DRAWN
from cpm_core.formats.writers import (
    FOR_CENTERLINES,
    FOR_SKELETONS,
    FOR_VOLUMES,
    OUTLINABLE,
    WRITABLE,
    check_export,
    encoded,
    export,
    left_out,
    omission,
    suffix_of,
)
from cpm_core.formats.writers import IN_SPACE as IN_SPACE
from cpm_core.formats.writers import descriptions as descriptions

__all__ = [
    "CONTOURS_READABLE",
    "FOR_CENTERLINES",
    "FOR_SKELETONS",
    "FOR_VOLUMES",
    "OUTLINABLE",
    "READABLE",
    "SURFACES_READABLE",
    "WRITABLE",
    "check_export",
    "encoded",
    "export",
    "holds_volume",
    "left_out",
    "load_centerlines",
    "load_contours",
    "load_image",
    "load_pages",
    "load_points",
    "load_surface",
    "load_volume",
    "omission",
    "open_stack",
    "suffix_of",
]
