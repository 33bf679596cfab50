"""The guide: pages that explain real tasks in a dialog beside the window."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, QUrl
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QListWidget,
    QMainWindow,
    QTextBrowser,
    QVBoxLayout,
)

from app.model.parameters.controls import controls
from app.model.text.assets import asset
from app.model.text.keys import key_of, with_keys
from app.model.text.language import tr
from app.views.widgets.actions import LAYER, ActionSpec, native
from app.views.window.docks import PanelAction
from app.views.window.menus import MENUS


@dataclass(frozen=True, slots=True)
class Step:
    """One step as rich text, with the file of its picture in the assets of the guide (empty for none)."""

    text: str
    picture: str = ""


@dataclass(frozen=True, slots=True)
class Page:
    """One page: name in links, heading, introduction, numbered steps, remarks, and the file of its sample if any."""

    name: str
    title: str
    opening: str
    steps: tuple[Step, ...] = ()
    remarks: tuple[str, ...] = ()
    sample: str = ""


_FIRST = Page(
    "first",
    tr("First steps"),
    tr("CPM finds contours by charged particles. The edges of the image attract the particles, and the particles repel "
       "each other along the edges and into every bay until they come to rest. You can watch and steer the run."),
    (
        Step(tr("<b>Open</b> an image: {open}, or drop a file on the window.")),
        Step(tr("<b>Draw</b> a start: drag a circle in or around an object, draw a stroke, or place points. "
                "Or choose {mode_automatic}, which needs no drawing.")),
        Step(tr("<b>Run</b>: {run}. Particles are yellow while they move and green at rest; closed contours are blue, "
                "open contours are orange.")),
        Step(tr("<b>Steer</b>: every slider acts at the next step.")),
        Step(tr("<b>Select</b> objects: {objects}, then click in one. Click to add, Shift-click to remove, and press "
                "Enter to accept. {object_table} lists them.")),
        Step(tr("<b>Export</b> the contours: {export}. A preview shows what the chosen format holds and what it leaves "
                "out.")),
    ),
    (tr("Four examples, step by step: <a href='page:artery'>an artery</a>, <a href='page:nuclei'>nuclei</a>, "
        "<a href='page:hand'>a hand</a>, <a href='page:vessels'>a vessel tree</a>."),),
)  # fmt: skip

_ARTERY = Page(
    "artery",
    tr("An artery"),
    tr("An angiogram shows an artery with its branches. One part is narrower than the rest. How narrow is it?"),
    (
        Step(tr("<a href='sample:artery.png'>Open the artery</a>. A short stroke along the vessel is the "
                "start: the particles begin there."), "artery_start.jpg"),
        Step(tr("{run}. The particles move along both walls and into every branch."), "artery_midway.jpg"),
        Step(tr("At rest the walls are found. Their contours are orange (open), because the vessel leaves the image."),
             "artery_end.jpg"),
        Step(tr("Choose {mode_skeleton} and run again: the centerline of the vessel is found, colored from thin (blue) "
                "to thick (yellow). The narrow part is visible below the second branch."), "artery_skeleton.jpg"),
        Step(tr("{export}, as a table (CSV): for each point of the centerline it lists the distance to the "
                "wall, which is half the width of the vessel.")),
    ),
    (tr("For your own image: choose the tool for strokes, draw a short line inside the vessel, and run. If faint "
        "branches are missing, lower {=smoothing}; if noise is found as well, raise it. In the mode Skeleton, set "
        "{=polarity} and {=max_width} if something else is found than vessels; {=pruning} leaves out side branches."),),
    "artery.png",
)  # fmt: skip

_NUCLEI = Page(
    "nuclei",
    tr("Nuclei"),
    tr("Stained nuclei under the microscope. How many are there, and how large are they? They differ in brightness, "
       "and some touch."),
    (
        Step(tr("<a href='sample:nuclei.png'>Open the nuclei</a>. No drawing is needed: the mode is automatic, and the "
                "particles start at the centers of regions enclosed by edges (menu Draw)."), "nuclei_start.jpg"),
        Step(tr("{run}. Each nucleus gets a closed contour, even the faint ones; two that touch share one. The panel "
                "Run shows the number of contours."), "nuclei_end.jpg"),
        Step(tr("To separate two that touch, draw a barrier between them: {barrier}. The run continues at once, and "
                "each nucleus gets its own contour, which may be open at the barrier.")),
        Step(tr("Raise {=min_length}: the smallest nuclei disappear at once, without another run; below the slider "
                "their number is counted. Lower it, and they are back.")),
        Step(tr("{export}, as a PNG mask: each nucleus has its own number, ready for measurements. The dialog "
                "counts open contours, as those at the barrier, and can close them.")),
    ),
    (tr("For your own image: choose {mode_automatic} and run. If texture inside the nuclei is found, raise "
        "{=smoothing} or {=edge_floor}."),),
    "nuclei.png",
)  # fmt: skip

_HAND = Page(
    "hand",
    tr("A hand"),
    tr("A radiograph of a hand. The outline of the hand is one shape with five long bays, and the bones lie inside."),
    (
        Step(tr("<a href='sample:hand.png'>Open the hand</a>. The start is one circle in the palm."),
             "hand_start.jpg"),
        Step(tr("{run}. Some particles find the outline and move up every finger; others stay at the bones."),
             "hand_midway.jpg"),
        Step(tr("At rest the outline and the bones are found. Bones that appear connected share one contour."),
             "hand_end.jpg"),
        Step(tr("Now segment only one finger: draw a region of interest around it (menu Draw), start everywhere in it "
                "({start_grid}), and run again. The image outside is dimmed and ignored."), "hand_finger.jpg"),
        Step(tr("Move {=sure_edge} under Advanced: contours of faint edges appear and disappear at once, without "
                "another run.")),
    ),
    (tr("For your own image: draw the circle so that it crosses the edges that you need. Lower {=beta} if the "
        "particles stop too early. {=reach} is at its largest here; lower it to find only what the circle lies in."),),
    "hand.png",
)  # fmt: skip

_VESSELS = Page(
    "vessels",
    tr("A vessel tree"),
    tr("A volume: vessels that branch in space, with noise. What is the surface of the whole tree?"),
    (
        Step(tr("<a href='sample:vessels.tif'>Open the vessels</a>. The canvas shows one slice; the slices across the "
                "other two axes are beside it, and the view in space shows the volume. A small sphere lies in the "
                "trunk."), "vessels_start.jpg"),
        Step(tr("Look around: {previous_slice} and {next_slice} go through the slices, the right button in a "
                "slice beside the canvas moves the cross, and a drag turns the view in space.")),
        Step(tr("{run}. The particles move along the wall of the trunk and into every branch."),
             "vessels_midway.jpg"),
        Step(tr("At rest the surface of the tree is found. The panel Run shows its volume and area, and that it is one "
                "piece. In the slices its section is drawn as a line."), "vessels_end.jpg"),
        Step(tr("Lower the opacity above the view in space, or cut the surface open with the list beside it, to look "
                "inside.")),
        Step(tr("Enter accepts the tree as an object, and {object_table} shows its volume. {objects} selects any other "
                "body by a click, in a slice or in space.")),
        Step(tr("{mode_skeleton} and {run} find the center lines of the vessels and how thick they are, in the whole "
                "volume or, with {object_skeleton}, in objects.")),
        Step(tr("{export}: the surface (PLY, STL) in the unit of the file, for a printer or another program. "
                "{export_turntable} makes a film of a full turn.")),
    ),
    (tr("For your own volume: choose the tool {circle}, draw a sphere inside the vessel in any slice, and run. If "
        "faint branches are missing, lower {=edge_floor}; if noise is found as well, raise it or {=smoothing}. Where "
        "the file does not tell the size of a voxel, set it first: {pixel_size}. A file with several channels or "
        "points in time opens any of them: {choose_part}."),),
    "vessels.tif",
)  # fmt: skip

_STACKS = Page(
    "stacks",
    tr("Stacks and series"),
    tr("A file with several images, or a folder with the slices of a DICOM series, is opened as one volume, or as "
       "pages that are images of their own, such as a cell through time. How large is the cell on each page?"),
    (
        Step(tr("<b>Open</b> the file, or drop the folder on the window. A line above the image says what there is and "
                "what is missing; {choose_part} opens another page, channel, point in time or series, and {open_stack} "
                "makes a volume of the pages.")),
        Step(tr("<b>Draw</b> a start on the first page, and run until its contours are right.")),
        Step(tr("{run_pages} does the same on every page, in the background. With {follow_pages} each page starts from "
                "the contours of the one before, and an object keeps its number on all pages.")),
        Step(tr("{key:previous_slice} and {key:next_slice} go from page to page. Each page has a drawing, a run and an "
                "undo history of its own: where a page went wrong, draw another start there, and run it again.")),
        Step(tr("The panel Pages (menu View) lists the contours of all pages, and says where an object begins, ends, "
                "splits or merges; a double click goes to a contour.")),
        Step(tr("{export_pages}: measures of all pages as one table, labels as a stack, contours as one file.")),
    ),
    (
        tr("A series with missing slices or with two distances opens its longest even part; the other parts are in the "
           "list of series. One slice of a series offers to open all of it: {open_series}."),
        tr("Where the file does not tell the size of a pixel, set it: {pixel_size}. Without a window: "
           "<code>cpm run FILE --pages all --follow</code>."),
    ),
)  # fmt: skip

_CANVAS = Page(
    "canvas",
    tr("On the canvas"),
    tr("Left button: the current tool. Middle or right button: drag to move the image; a right "
       "click opens a menu of what lies there; with Ctrl it changes the gray values that are shown, to the "
       "right softer, up darker. Wheel: zoom at the pointer."),
    (),
    (
        tr("{fit} shows the whole image, {actual_size} one pixel of it on one pixel of the screen, {zoom_to_selection} "
           "what is selected."),
        tr("The line below the image says what to do next, and shows messages. The legend beside it explains the lines "
           "and dots on the image."),
        tr("Arrow keys move the selected shape by 1 px, with Shift by 10 px; &lt; and &gt; make a selected circle "
           "smaller and larger."),
        tr("Strokes, regions of interest and barriers are drawn freehand by dragging, or corner by corner by clicking. "
           "Enter or a double-click ends the path, Backspace removes the last corner, {key:escape} cancels."),
        tr("Particles stay inside a region of interest and do not cross a barrier."),
        tr("Shapes that are drawn during a run act at once: new starts add their particles; regions of interest, "
           "barriers and placed charges act at the next step, and a run at rest goes on. A start that is moved or "
           "removed acts from the next run."),
        tr("Changed parameters act at once; a run at rest goes on with them after Resume."),
        tr("Enter on the image shows a cross-hair, which arrow keys move: every tool can be used by keys."),
        tr("The keyboard belongs to the image: Enter or Esc in a field gives it back, {key:run} runs and letters "
           "choose tools wherever no text is typed. {go_to_sliders} goes to the sliders, {next_area} to the next area "
           "of the window, {keys} shows all keys."),
        tr("All changes of shapes and parameters can be undone: {undo}."),
    ),
)  # fmt: skip

_FURTHER = Page(
    "further",
    tr("Going further"),
    tr("What to do if the first run has not found the contours that you need, and what to do with the result."),
    (),
    (
        tr("<b>Steer.</b> Place a charge that attracts or repels ({attract}, {repel}) and drag it: the field and the "
           "particles follow at once. {barrier} stops particles; {eraser} removes particles and shapes."),
        tr("<b>Go back.</b> Drag along the timeline, or use {timeline_back}. Change something there and run: this adds "
           "a branch. Runs from other starts and runs that were reset stay there, too. You can go back to all of "
           "them, name and compare them; {preferences} set the memory for them."),
        tr("<b>Understand.</b> The panel Layers shows the edge map, the potential, the field and more; {layer_forces} "
           "shows the forces on a particle."),
        tr("<b>Review.</b> {contour_table} lists the contours; {reject} excludes contours from exports, {keep} keeps "
           "them through all sliders and runs. The contour tool selects several by a frame or a stroke. {load_truth} "
           "measures the agreement with a ground truth, and shows the differences."),
        tr("<b>Mend by hand.</b> {edit_contours}: drag an end of a contour to another end to join them along the edge, "
           "drag a stretch to where it belongs, Shift-click to cut. {close_contours} closes the selected contours. "
           "{outline} draws a contour that follows the edges from click to click. All of this stays through further "
           "runs."),
        tr("<b>Paint.</b> {brush}: drag from an object to add to it, Shift-drag to erase it, drag elsewhere for a new "
           "one. It needs no edge."),
        tr("<b>Find values.</b> {mosaic} compares runs with several values of two parameters."),
        tr("<b>Compare.</b> {wipe} shows two branches, or a result and the ground truth, on both sides of a divider "
           "that you can drag. {keep_result} keeps a result to compare later ones with it. {compare_methods} runs "
           "snakes, level sets and others beside the particles, from the same start. Which of them is best depends on "
           "the image: where gray levels tell the object from its background, morphological Chan-Vese or grab cut may "
           "win."),
        tr("<b>Next image.</b> {next_image} opens the next image of the folder, with the session beside it; {start} "
           "shows recent work. Each image begins with fresh parameters; {former_parameters} takes those of the last "
           "one."),
        tr("<b>Save.</b> {save} stores all that you see in one file, also the runs and their branches. It runs without "
           "a window, too: "
           "<code>cpm run --session FILE</code> for one image, <code>cpm batch</code> for many."),
        tr("<b>Present.</b> {export_animation} shows how the contours were found."),
    ),
)  # fmt: skip

PAGES = (_FIRST, _ARTERY, _NUCLEI, _HAND, _VESSELS, _STACKS, _FURTHER, _CANVAS)
"""The pages in the order of the table of contents."""


_SIZE = QSize(780, 640)
_PICTURE = 300
"""Width of a picture [px]."""

_LABELS = {control.name: f"“{control.title}” ({control.rich_symbol})" for control in controls()}
"""Labels of parameters by their names."""

KEYS = "keys"
"""Name of the page that lists all keys, and of the action that opens and closes it."""

KeyTable = Sequence[tuple[tuple[str, ...], str]]
"""Rows of equivalent keys, which may be those of actions (see `with_keys`), and their effect."""

_POINTER: KeyTable = (
    ((tr("left"),), tr("current tool")),
    ((tr("right"),), tr("menu of what lies there")),
    ((tr("right drag, middle drag"),), tr("move the image")),
    ((tr("wheel"),), tr("zoom")),
    (("Shift",), tr("circle; eight directions")),
    (("Ctrl",), tr("ellipse from its center")),
    ((tr("Shift-click"),), tr("cut a contour; remove from the object")),
)
_IMAGE: KeyTable = (
    (("Enter",), tr("show the cross-hair")),
    (("←↑↓→",), tr("move the cross-hair, the selected shape or the image")),
    (("Shift+←↑↓→",), tr("the same by 10 px")),
    (("Enter",), tr("press and release at the cross-hair")),
    (("Enter", "Enter"), tr("end a path")),
    (("Backspace",), tr("remove the last corner")),
    (("{key:escape}",), tr("cancel")),
    (("Enter",), tr("accept the object that is offered; rename it")),
    (("1 … 9",), tr("class of the object")),
    (("<", ">"), tr("size of shape or ring, strength, spacing")),
)
_FIELDS: KeyTable = (
    (("Enter",), tr("enter the value, go back to the image; press the button")),
    (("Esc",), tr("restore the value, go back to the image")),
    (("↑↓",), tr("next slider; next row of a table")),
    (("←→",), tr("move the slider")),
    (("{key:run}",), tr("run or pause, unless a name is typed")),
)


class Guide(QDialog):
    """Shows the pages beside the window; links open samples and other pages.

    `specs` are all actions, whose names and keys the pages mention; `open_sample` opens a sample by its file name.
    """

    def __init__(self, parent: QMainWindow, specs: Sequence[ActionSpec], open_sample: Callable[[str], None]) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Guide"))
        self._specs: dict[str, ActionSpec] = {}
        self._window = parent
        self._open_sample = open_sample
        for key in next((spec.shortcuts for spec in specs if spec.name == KEYS), ()):
            QShortcut(QKeySequence(key), self, self.close)
        self.contents = QListWidget()
        self.contents.setObjectName("contents")
        self.contents.setAccessibleName(tr("Pages"))
        self._names = [*(page.name for page in PAGES), KEYS]
        self.contents.addItems([*(page.title for page in PAGES), tr("All keys")])
        self.contents.setFixedWidth(self.contents.sizeHintForColumn(0) + 28)
        self.text = QTextBrowser()
        self.text.setOpenLinks(False)
        self.text.document().setDocumentMargin(14)
        self.text.anchorClicked.connect(self._follow)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.close)
        beside = QHBoxLayout()
        beside.addWidget(self.contents)
        beside.addWidget(self.text, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(beside, 1)
        layout.addWidget(buttons)
        self.contents.currentRowChanged.connect(self._turn)
        self.resize(_SIZE.boundedTo(self.screen().availableSize()))
        self.use_actions(specs)
        self.turn_to(self._names[0])

    @property
    def page(self) -> str:
        """Name of the page that is open."""
        return self._names[self.contents.currentRow()]

    def use_actions(self, specs: Iterable[ActionSpec]) -> None:
        """Name actions and their keys as they are now."""
        self._specs = {spec.name: spec for spec in specs}
        if self.contents.currentRow() >= 0:
            self._turn(self.contents.currentRow())

    def turn_to(self, name: str) -> None:
        """Open a page by its name."""
        self.contents.setCurrentRow(self._names.index(name))

    def _turn(self, row: int) -> None:
        name = self._names[row]
        page = next((page for page in PAGES if page.name == name), None)
        self.text.setHtml(self._keys() if page is None else self._written(page))

    def _follow(self, link: QUrl) -> None:
        if link.scheme() == "page":
            self.turn_to(link.path())
        elif link.scheme() == "sample":
            self._open_sample(link.path())

    def _written(self, page: Page) -> str:
        steps = "".join(f"<li>{self._named(step.text)}{_picture(step.picture)}</li>" for step in page.steps)
        remarks = "".join(f"<p>{self._named(remark)}</p>" for remark in page.remarks)
        numbered = f"<ol>{steps}</ol>" if steps else ""
        return f"<h2>{page.title}</h2><p>{self._named(page.opening)}</p>{numbered}{remarks}"

    def _named(self, text: str) -> str:
        """A text with actions in braces replaced by name and key, and parameters (``{=beta}``) by label and symbol."""
        text = re.sub(r"\{=(\w+)\}", lambda found: _LABELS[found.group(1)], text)
        text = re.sub(r"\{key:(\w+)\}", lambda found: html.escape(key_of(found.group(1))), text)
        return re.sub(r"\{(\w+)\}", lambda found: self._action(found.group(1)), text)

    def _action(self, name: str) -> str:
        spec = self._specs[name]
        words = html.escape(spec.title)
        keys = f" ({html.escape(native(spec.shortcuts[0]))})" if spec.shortcuts else ""
        return f"<b>{words}</b>{keys}"

    def _keys(self) -> str:
        cell, text = "<td style='padding: 2px 14px 2px 0'>", f"<h2>{tr('All keys')}</h2>"
        for title, rows in groups(self._window, self._specs.values()):
            lines = "".join(
                f"<tr>{cell}<b>{' &nbsp;'.join(map(html.escape, keys))}</b></td>{cell}{html.escape(meaning)}</td></tr>"
                for keys, meaning in rows
            )
            text += f"<h3>{title}</h3><table>{lines}</table>"
        return text


def groups(window: QMainWindow, specs: Iterable[ActionSpec]) -> list[tuple[str, KeyTable]]:
    """All keys in groups: those of each menu, of the panels, and of the canvas."""
    tools, layers = tr("Tools"), tr("Layers")
    menus = {name: title.replace("&", "") for name, title in MENUS.items()}
    found: dict[str, list[tuple[tuple[str, ...], str]]] = {name: [] for name in (tools, layers, *menus.values())}
    for spec in specs:
        if spec.shortcuts:
            group = tools if spec.group == "tool" else layers if spec.name.startswith(LAYER) else ""
            rows = found[group or menus[spec.menu.partition(">")[0]]]
            rows.append((tuple(map(native, spec.shortcuts[:2])), spec.title))
    panels = [
        ((native(action.shortcut().toString()),), action.text())
        for action in window.findChildren(PanelAction)
        if not action.shortcut().isEmpty()
    ]
    sections = {
        tools: found.pop(tools),
        tr("Keys on the image"): [(tuple(map(with_keys, keys)), meaning) for keys, meaning in _IMAGE],
        tr("Mouse on the image"): _POINTER,
        tr("In fields and tables"): [(tuple(map(with_keys, keys)), meaning) for keys, meaning in _FIELDS],
        layers: found.pop(layers),
        tr("Panels"): panels,
        **found,
    }
    return [(title, rows) for title, rows in sections.items() if rows]


def _picture(file: str) -> str:
    if not file:
        return ""
    address = QUrl.fromLocalFile(str(asset(f"guide/{file}"))).toString()
    return f"<br><img src='{address}' width='{_PICTURE}'><br>"
