"""Texts of the window, from the situation."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cpm_app.model.display.lengths import format_measured_length, format_scientific
from cpm_app.model.document.document import ImageReference
from cpm_app.model.document.modes import MODES, needs_start
from cpm_app.model.state.situation import RunStatus, Situation, has_volume, moves_particles
from cpm_app.model.state.surface_figures import SURFACE_LABEL, VOLUME_LABEL, format_surface_figures
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import localize_number, tr, translate_core_text
from cpm_core import Contour, Result, Skeleton
from cpm_core.numerics.types import frozen
from cpm_core.shapes import (
    Angle,
    Barrier,
    BoxGrid,
    BoxThreshold,
    Charge,
    EnclosedRegion,
    EnclosingWall,
    Everywhere,
    Grid,
    Measure,
    Points,
    Ruler,
    Shape,
    Stroke,
    Threshold,
)

FULL_SPEED = tr("full speed")
"""Text of the speed without a limit."""

RUN_PACES = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, None)
"""Steps per second of the speed control; None for no limit."""

INITIAL_PACE_INDEX = 6
"""Index of the speed with which the window opens."""

LEADING_LABELS = (
    tr("Particles"),
    tr("Contours"),
    tr("Branches"),
    tr("Length"),
    tr("Thickness"),
    tr("Skeleton of"),
    SURFACE_LABEL,
    VOLUME_LABEL,
)
"""Labels of the numbers that are always shown."""


@frozen
class WindowTexts:
    """Texts of the window in a situation.

    `run_text`, `undo_text` and `redo_text` are texts of actions. `state` is one sentence on the state of the run, and
    `hint` one on what to do next, or empty. `numbers` are label, value and explanation of each line of the status
    panel.
    """

    run_text: str
    undo_text: str
    redo_text: str
    state: str
    hint: str
    numbers: tuple[tuple[str, str, str], ...]


def resolve_texts(situation: Situation) -> WindowTexts:
    """Return the texts of the window; a pure function that can be tested without a window."""
    document, status = situation.document, situation.status
    return WindowTexts(
        run_text=_label_run_action(status),
        undo_text=_append_change_name(tr("Undo"), situation.undo_name),
        redo_text=_append_change_name(tr("Redo"), situation.redo_name),
        state=_describe_run_state(situation),
        hint=_suggest_next_action(situation),
        numbers=_format_run_numbers(status, document.image)
        if moves_particles(situation)
        else _format_skeleton_numbers(status, document.image),
    )


def _append_change_name(text: str, name: str) -> str:
    return tr("{undo} {change}", undo=text, change=name) if name else text


def format_pace(pace: float | None) -> str:
    """Format a speed."""
    if pace is None:
        return FULL_SPEED
    return tr("1 step/s") if pace == 1 else tr("{pace} steps/s", pace=localize_number(f"{pace:g}"))


def _label_run_action(status: RunStatus) -> str:
    if status.phase == "running":
        return tr("Pause")
    if (status.phase == "paused" or status.steered or status.unfinished) and not status.stale:
        return tr("Resume")
    return tr("Run again") if status.started else tr("Run")


def _describe_run_state(situation: Situation) -> str:
    document, status = situation.document, situation.status
    if status.busy:
        return status.busy
    match status.phase:
        case "empty":
            return tr("No image is open.")
        case "running":
            return tr("Running, step {step}", step=localize_number(f"{status.step:,}"))
        case "paused":
            return tr("Paused at step {step}", step=localize_number(f"{status.step:,}"))
        case "finished":
            message = tr("Finished: {reason}") if status.converged else tr("Stopped – {reason}")
            return message.format(reason=translate_core_text(status.stop_reason))
    if document.starts or not needs_start(document.mode):
        return tr("Ready")
    if items := document.objects.items:
        return tr("1 object") if len(items) == 1 else tr("{count} objects", count=len(items))
    return tr("No start yet")


def _suggest_next_action(situation: Situation) -> str:
    document, status, selected = situation.document, situation.status, situation.selected
    shape = document.shapes[selected] if selected is not None and selected < len(document.shapes) else None
    drawn = any(not isinstance(each, Measure) for each in document.shapes)
    in_volume, usual = has_volume(situation), MODES[document.mode].hint
    if status.phase == "empty":
        message = "" if status.busy else tr("Open an image ({key:open}) or drop one here.")
    elif status.started and status.method != MODES[document.mode].method:
        message = tr("What was found stays until Run ({key:run}) starts over in this mode.")
    elif status.started and status.stale and status.phase == "running":
        message = tr("The starts or scales have changed: they act from the next run on.")
    elif status.started and status.stale:
        startable = document.starts or not needs_start(document.mode)
        message = tr("The starts or scales have changed: Run starts over with them.") if startable else ""
    elif status.started and status.steered:
        message = tr(
            "The parameters have changed: Resume ({key:run}) continues with them, Reset ({key:reset}) starts over."
        )
    elif isinstance(shape, Charge):
        message = tr("Drag the {shape} of strength {strength}; [ and ] change its strength, {key:delete} removes it.")
        return insert_keys(
            message, shape=translate_core_text(shape.title), strength=localize_number(f"{abs(shape.strength):g}")
        )
    elif isinstance(shape, Measure):
        return _suggest_shape_actions(shape)
    elif status.started:
        message = ""
    elif not needs_start(document.mode):
        message = usual
    elif not drawn and in_volume:
        message = tr(
            "Drag to draw a sphere in or around an object; {key:previous_slice} and {key:next_slice} move "
            "through the slices."
        )
    elif not drawn:
        message = tr("Drag on the image to draw a circle in or around an object.")
    elif not document.starts and in_volume:
        message = tr("Now draw a start for the particles: a sphere, a box, a stroke or points.")
    elif not document.starts:
        message = tr(
            "Now draw a start for the particles: a circle, a stroke or points; or start everywhere ({key:start_grid})."
        )
    else:
        return insert_keys(usual or tr("Press {key:run} to run.")) if shape is None else _suggest_shape_actions(shape)
    return insert_keys(message)


def _suggest_shape_actions(shape: Shape) -> str:
    name = translate_core_text(shape.title)
    if isinstance(shape, Everywhere):
        return insert_keys(tr("Press {key:run} to run; {key:delete} removes the {shape}."), shape=name)
    spaced = tr(
        "Arrow keys or the select tool ({key:select}) move the {shape}, [ and ] change its spacing; "
        "{key:delete} removes it."
    )
    strong = tr(
        "[ and ] change how strong an edge must be for the {shape}, arrow keys move it; {key:delete} removes it."
    )
    moved = tr("Arrow keys or the select tool ({key:select}) move the {shape}; {key:delete} removes it.")
    message = {
        **dict.fromkeys((Grid, BoxGrid), spaced),
        **dict.fromkeys((Threshold, BoxThreshold), strong),
        **dict.fromkeys((Stroke, Points, Barrier, EnclosedRegion, EnclosingWall, Ruler, Angle), moved),
    }.get(
        type(shape),
        tr(
            "Arrow keys or the select tool ({key:select}) move the {shape}, [ and ] resize it; {key:delete} removes it."
        ),
    )
    return insert_keys(message, shape=name)


_Numbers = tuple[tuple[str, str, str], ...]
"""Label, value and explanation of each number."""


def _dash_unknown(known: bool, numbers: _Numbers) -> _Numbers:
    """Replace the values of numbers by dashes unless they are known."""
    return numbers if known else tuple((label, "–", tip) for label, _, tip in numbers)


def _format_run_numbers(status: RunStatus, image: ImageReference | None) -> _Numbers:
    small = status.epsilon < 1e-3
    epsilon = format_scientific(status.epsilon) if small else localize_number(f"{status.epsilon:.4f}")
    scale = tr("0 (full size)") if status.scale == 0 else f"{status.scale} (1:{2**status.scale})"
    speed = localize_number(f"{status.steps_per_second:.0f}") if status.phase == "running" else "–"
    numbers = (
        (tr("Step"), localize_number(f"{status.step:,}"), tr("Steps taken over all scales.")),
        (tr("Particles"), localize_number(f"{status.count:,}"), tr("Current number of free particles.")),
        (tr("Scale"), scale, tr("Level of the image pyramid; at 1:4 each pixel represents 4 by 4.")),
        ("ε", "–" if math.isnan(status.epsilon) else epsilon,
         tr("How much the particles still move, eq. (23); small at rest.")),
        (tr("Steps/s"), speed, tr("Speed of the run.")),
    )  # fmt: skip
    if image is not None and image.is_volume:
        return (*_dash_unknown(status.has_particles, numbers), *format_surface_figures(status.surface))
    closed = sum(contour.closed for contour in status.contours)
    found = tr("{closed} closed, {open} open", closed=closed, open=len(status.contours) - closed)
    bridges = status.found.bridges if isinstance(status.found, Result) else ()
    bridged = tr("no gap")
    if bridges:
        words = tr("1 gap of {length}") if len(bridges) == 1 else tr("{gaps} gaps, longest {length}")
        longest = _format_image_length(max(bridge.length for bridge in bridges), image)
        bridged = words.format(gaps=len(bridges), length=longest)
    contours = (
        (tr("Contours"), found, tr("Contours reconstructed so far.")),
        (tr("Bridged"), bridged, tr("Gaps that were closed along a faint edge; see the parameter Maximum gap.")),
    )
    return _dash_unknown(status.has_particles, (*numbers, *contours))


def describe_contours(contours: Sequence[Contour]) -> str:
    """Describe in a sentence how many contours a run has found."""
    closed = sum(contour.closed for contour in contours)
    if not contours:
        return tr("No contour was found.")
    words = tr("1 closed contour, {open} open.") if closed == 1 else tr("{closed} closed contours, {open} open.")
    return words.format(closed=closed, open=len(contours) - closed)


def describe_skeleton(found: Skeleton, image: ImageReference | None) -> str:
    """Describe a skeleton in a sentence: its branches, their length, and the thickness of what they lie in."""
    count = len(found.contours)
    if not count:
        return tr("No center line was found.")
    words = tr("1 branch, {length} long, up to {thickness} wide.")
    if count > 1:
        words = tr("{count} branches, together {length} long, up to {thickness} wide.")
    length, thickness = _format_image_length(found.length, image, 0), _format_image_length(found.thickness, image)
    return words.format(count=localize_number(f"{count:,}"), length=length, thickness=thickness)


_NOTHING_FOUND = Skeleton((), (), (1, 1), (1.0, 1.0), None, "")
"""Skeleton before a run has found one."""


def _format_skeleton_numbers(status: RunStatus, image: ImageReference | None) -> _Numbers:
    found = status.found if isinstance(status.found, Skeleton) else _NOTHING_FOUND
    thickness = _format_image_length(found.thickness, image)
    numbers = (
        (tr("Branches"), localize_number(f"{len(found.contours):,}"), tr("Center lines between tips and forks.")),
        (tr("Length"), _format_image_length(found.length, image, 0), tr("Length of all branches together.")),
        (tr("Thickness"), thickness, tr("95 % of the length is thinner than this.")),
        (
            tr("Skeleton of"),
            describe_skeleton_objects(found.polarity, found.width),
            tr("The objects whose skeleton is shown."),
        ),
    )
    return _dash_unknown(bool(found.contours), numbers)


def describe_skeleton_objects(polarity: int, width: float) -> str:
    """Describe what a skeleton of this polarity and largest width [px] is a skeleton of."""
    what = {-1: tr("what is dark"), 1: tr("what is light")}.get(polarity, tr("all objects"))
    return tr("{what}, up to {width} px wide", what=what, width=localize_number(f"{width:.0f}")) if width else what


def _format_image_length(pixels: float, image: ImageReference | None, decimals: int = 1) -> str:
    if image is None:
        return format_measured_length(pixels, (1.0,), None, decimals)
    sides = (
        (min(image.spacing),) if image.is_volume else image.spacing
    )  # whose lengths are in smallest sides of a voxel
    return format_measured_length(pixels, sides, image.unit, decimals)
