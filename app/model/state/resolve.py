"""From the situation to the texts of the window."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.model.display.lengths import measured, scientific_text
from app.model.document.document import Document, ImageReference
from app.model.document.modes import MODES, needs_start
from app.model.state.situation import RunStatus, Situation, has_volume
from app.model.state.surface_figures import SURFACE, VOLUME, figure_texts
from app.model.text.keys import with_keys
from app.model.text.language import from_core, tr, written
from cpm_core.shapes import (
    Barrier,
    BoxGrid,
    BoxThreshold,
    Charge,
    EnclosedRegion,
    EnclosingWall,
    Everywhere,
    Grid,
    Points,
    Shape,
    Stroke,
    Threshold,
)

FULL_SPEED = tr("full speed")
PACES: tuple[float | None, ...] = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, None)
"""Steps per second of the speed control; None for no limit."""
FIRST_PACE = 6

_LEADING = (
    tr("Step"),
    tr("Particles"),
    tr("Contours"),
    tr("Branches"),
    tr("Length"),
    tr("Thickness"),
    tr("Skeleton of"),
    SURFACE,
    VOLUME,
)
"""Labels of the numbers that are always shown."""


@dataclass(frozen=True, slots=True)
class Resolved:
    """Texts of the window in a situation.

    `run_text`, `undo_text` and `redo_text` are texts of actions; `running` is whether Run is shown as Pause. `state` is
    one sentence on the state of the run, `hint` one on the next thing to do, or empty. `numbers` are label, value and
    explanation of each line of the status panel, `leading` the labels of those that are always shown. `particles` is
    whether the mode has particles that move.
    """

    title: str
    run_text: str
    undo_text: str
    redo_text: str
    running: bool
    state: str
    hint: str
    numbers: tuple[tuple[str, str, str], ...]
    leading: tuple[str, ...]
    particles: bool


def resolve(situation: Situation) -> Resolved:
    """Texts of the window; a pure function that can be tested without a window."""
    document, status = situation.document, situation.status
    particles = needs_start(document.mode)
    return Resolved(
        title=f"{document.image.name} – CPM" if document.image else "CPM",
        run_text=_run_text(document, status),
        undo_text=_named(tr("Undo"), situation.undo_name),
        redo_text=_named(tr("Redo"), situation.redo_name),
        running=status.phase == "running",
        state=_state(situation),
        hint=_hint(situation),
        numbers=_numbers(status, document.image) if particles else _numbers_of_skeleton(status, document.image),
        leading=_LEADING,
        particles=particles,
    )


def _named(text: str, name: str) -> str:
    return tr("{undo} {change}").format(undo=text, change=name) if name else text


def pace_text(pace: float | None) -> str:
    """A speed as text."""
    if pace is None:
        return FULL_SPEED
    return tr("1 step/s") if pace == 1 else tr("{pace} steps/s").format(pace=written(f"{pace:g}"))


def _run_text(document: Document, status: RunStatus) -> str:
    if status.phase == "running":
        return tr("Pause")
    if (status.phase == "paused" or status.steered) and not status.stale:
        return tr("Resume")
    return tr("Run again") if status.started else tr("Run")


def _state(situation: Situation) -> str:
    document, status = situation.document, situation.status
    if status.busy:
        return status.busy
    match status.phase:
        case "empty":
            return tr("No image is open.")
        case "running":
            return tr("Running")
        case "paused":
            return tr("Paused")
        case "finished":
            message = tr("Done – {reason}") if status.converged else tr("Stopped – {reason}")
            return _sentence(message.format(reason=from_core(status.stop_reason)))
    if document.starts or not needs_start(document.mode):
        return tr("Ready")
    return tr("Nothing to start from yet") if document.shapes else tr("Nothing drawn yet")


def _hint(situation: Situation) -> str:
    document, status, selected = situation.document, situation.status, situation.selected
    if status.phase == "empty":
        return with_keys(tr("Open an image ({key:open}) or drop one here."))
    shape = document.shapes[selected] if selected is not None and selected < len(document.shapes) else None
    if status.started:
        return _hint_on_run(status) or (_what_a_charge_does(shape) if isinstance(shape, Charge) else "")
    if isinstance(shape, Charge):
        return _what_a_charge_does(shape)
    if not needs_start(document.mode):
        return with_keys(MODES[document.mode].hint)
    if not document.shapes:
        return _first_hint(situation)
    if not document.starts:
        return _hint_on_starts(situation)
    if shape is not None:
        return _what_can_be_done_to(shape)
    return with_keys(MODES[document.mode].hint or tr("Press {key:run} to run."))


def _first_hint(situation: Situation) -> str:
    if has_volume(situation):
        return with_keys(
            tr(
                "Drag to draw a sphere in or around an object; {key:previous_slice} and {key:next_slice} go through "
                "the slices."
            )
        )
    return tr("Drag on the image to draw a circle in or around an object.")


def _hint_on_starts(situation: Situation) -> str:
    if has_volume(situation):
        return tr("Now draw where particles start: a sphere, a box, a stroke or points.")
    return with_keys(
        tr("Now draw where particles start: a circle, a stroke or points; or start everywhere ({key:start_grid}).")
    )


def _hint_on_run(status: RunStatus) -> str:
    if status.stale:
        if status.phase == "running":
            return with_keys(tr("A start or the scales have changed: Reset ({key:reset}) to begin from them."))
        return tr("A start or the scales have changed: Run starts again from them.")
    if status.steered:
        return with_keys(
            tr("The parameters have changed: Resume ({key:run}) goes on with them, Reset ({key:reset}) starts over.")
        )
    return ""


def _what_can_be_done_to(shape: Shape) -> str:
    name = from_core(shape.title)
    if isinstance(shape, Everywhere):
        return with_keys(tr("Press {key:run} to run; {key:delete} removes the {shape}."), shape=name)
    spaced = tr(
        "Arrow keys or the select tool ({key:select}) move the {shape}, < and > change its spacing; "
        "{key:delete} removes it."
    )
    strong = tr(
        "< and > change how strong an edge must be for the {shape}, arrow keys move it; {key:delete} removes it."
    )
    moved = tr("Arrow keys or the select tool ({key:select}) move the {shape}; {key:delete} removes it.")
    message = {
        **dict.fromkeys((Grid, BoxGrid), spaced),
        **dict.fromkeys((Threshold, BoxThreshold), strong),
        **dict.fromkeys((Stroke, Points, Barrier, EnclosedRegion, EnclosingWall), moved),
    }.get(
        type(shape),
        tr(
            "Arrow keys or the select tool ({key:select}) move the {shape}, < and > resize it; {key:delete} removes it."
        ),
    )
    return with_keys(message, shape=name)


def _what_a_charge_does(charge: Charge) -> str:
    message = tr(
        "Drag the {shape} of strength {strength} or move it with arrow keys; < and > make it weaker and stronger; "
        "{key:delete} removes it."
    )
    return with_keys(message, shape=from_core(charge.title), strength=written(f"{abs(charge.strength):g}"))


def _sentence(text: str) -> str:
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _numbers(status: RunStatus, image: ImageReference | None) -> tuple[tuple[str, str, str], ...]:
    def shown(value: str) -> str:
        return value if status.has_particles else "–"

    epsilon = (
        "–"
        if math.isnan(status.epsilon)
        else scientific_text(status.epsilon)
        if status.epsilon < 1e-3
        else written(f"{status.epsilon:.4f}")
    )
    scale = tr("0 (full size)") if status.scale == 0 else f"{status.scale} (1:{2**status.scale})"
    speed = written(f"{status.steps_per_second:.0f}") if status.phase == "running" else "–"
    return (
        (tr("Step"), shown(written(f"{status.step:,}")), tr("Steps taken over all scales.")),
        (tr("Particles"), shown(written(f"{status.count:,}")), tr("Free particles there are now.")),
        (
            tr("Scale"),
            shown(scale),
            tr("Level of the image pyramid; at 1:4 a pixel stands for 4 by 4."),
        ),
        (
            "ε",
            shown(epsilon),
            tr("How much the particles still move, eq. (23); small at rest."),
        ),
        (tr("Steps/s"), speed, tr("Speed of the run.")),
        *(figure_texts(status.surface) if image is not None and image.is_volume else _of_contours(status, image)),
    )


def _of_contours(status: RunStatus, image: ImageReference | None) -> tuple[tuple[str, str, str], ...]:
    found, bridged = "–", "–"
    if status.has_particles:
        found = tr("{closed} closed, {open} open").format(closed=status.closed, open=status.open)
        bridged = _bridged(status, image)
    return (
        (tr("Contours"), found, tr("Contours reconstructed so far.")),
        (tr("Bridged"), bridged, tr("Gaps that were closed along a faint edge; see the parameter Maximum gap.")),
    )


def _numbers_of_skeleton(status: RunStatus, image: ImageReference | None) -> tuple[tuple[str, str, str], ...]:
    found = status.method == "skeleton" and status.closed + status.open > 0

    def shown(value: str) -> str:
        return value if found else "–"

    branches, length = written(f"{status.closed + status.open:,}"), _length(status.length, image, 0)
    return (
        (tr("Branches"), shown(branches), tr("Center lines between tips and forks.")),
        (tr("Length"), shown(length), tr("Length of all branches together.")),
        (
            tr("Thickness"),
            shown(_length(status.thickness, image)),
            tr("Thickness that 95 % of the length stays below."),
        ),
        (tr("Skeleton of"), shown(skeleton_of(status.polarity, status.width)), tr("What has a skeleton in the image.")),
    )


def skeleton_of(polarity: int, width: float) -> str:
    """What a skeleton of this polarity and largest width [px] is of, in words."""
    what = {-1: tr("what is dark"), 1: tr("what is light")}.get(polarity, tr("all objects"))
    return tr("{what}, up to {width} px wide").format(what=what, width=written(f"{width:.0f}")) if width else what


def _length(pixels: float, image: ImageReference | None, decimals: int = 1) -> str:
    if image is None:
        return measured(pixels, (1.0,), None, decimals)
    sides = (min(image.spacing),) if image.is_volume else image.spacing  # lengths are in smallest sides there
    return measured(pixels, sides, image.unit, decimals)


def _bridged(status: RunStatus, image: ImageReference | None) -> str:
    if not status.bridges:
        return tr("no gap")
    if status.bridges == 1:
        return tr("1 gap of {length}").format(length=_length(status.longest_bridge, image))
    message = tr("{gaps} gaps, longest {length}")
    return message.format(gaps=status.bridges, length=_length(status.longest_bridge, image))
