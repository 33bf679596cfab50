"""The texts of the guide: first steps, three real tasks on images that everybody has, and what works on the canvas.

A text may name an action in braces, as in ``{run}``; the guide puts its name in the menu and its key there.
"""

from __future__ import annotations

from dataclasses import dataclass

from app.model.text.language import tr


@dataclass(frozen=True, slots=True)
class Step:
    """One step as rich text, with the file of its picture in the assets of the guide (empty for none)."""

    text: str
    picture: str = ""


@dataclass(frozen=True, slots=True)
class Page:
    """One page: its name in links, heading, introduction, numbered steps, remarks, and the file of its sample if any."""

    name: str
    title: str
    opening: str
    steps: tuple[Step, ...] = ()
    remarks: tuple[str, ...] = ()
    sample: str = ""


_FIRST = Page(
    "first",
    tr("First steps"),
    tr("CPM finds contours: charged particles are pulled to the edges of an image and push each other along them, into "
       "every bay, until they rest. You see it happen and can steer it meanwhile."),
    (
        Step(tr("<b>Open</b> an image: {open}, or drop a file on the window.")),
        Step(tr("<b>Draw</b> where to start: drag a circle in or around an object, draw a stroke, or place points. Or "
                "choose {mode_automatic}, which starts everywhere.")),
        Step(tr("<b>Run</b>: {run}. The particles are yellow while they move and green once they rest; closed contours "
                "are blue, open ones orange.")),
        Step(tr("<b>Steer</b>: every slider acts at the very next step. What it does is drawn below the sliders.")),
        Step(tr("<b>Export</b> the contours: {export}. The ending of the name tells the format.")),
    ),
    (tr("Three tasks, step by step: <a href='page:artery'>an artery</a>, <a href='page:nuclei'>nuclei</a>, "
        "<a href='page:hand'>a hand</a>."),),
)  # fmt: skip

_ARTERY = Page(
    "artery",
    tr("An artery"),
    tr("An angiogram shows an artery and its branches. One place is narrower than the rest: how narrow is it?"),
    (
        Step(tr("<a href='sample:artery.png'>Open the artery</a>. A short stroke along the vessel is drawn already: "
                "that is where the particles start."), "artery_start.jpg"),
        Step(tr("{run}. The particles run along both walls and turn into every branch by themselves."),
             "artery_midway.jpg"),
        Step(tr("When they rest, the walls are found. They are orange, for the vessel leaves the image and its walls "
                "are open there."), "artery_end.jpg"),
        Step(tr("Choose {mode_skeleton} and run again: the middle of the vessel is found, colored from thin (blue) to "
                "thick (yellow). The narrow place stands out below the second branch."), "artery_skeleton.jpg"),
        Step(tr("{export_skeleton}, as a table (CSV): beside every place of the middle line stands its distance to the "
                "wall, which is half the width of the vessel.")),
    ),
    (tr("On an image of your own: take the tool for strokes, draw a short line inside the vessel, and run. If faint "
        "branches are missing, lower “Blur beforehand” (<i>σ</i>); if noise is found as well, raise it."),),
    "artery.png",
)  # fmt: skip

_NUCLEI = Page(
    "nuclei",
    tr("Nuclei"),
    tr("Stained nuclei under the microscope: how many are there, and how large? They differ in brightness, and "
       "some touch."),
    (
        Step(tr("<a href='sample:nuclei.png'>Open the nuclei</a>. Nothing need be drawn: the mode is automatic, and "
                "particles start in the middle of what edges enclose (menu Draw)."), "nuclei_start.jpg"),
        Step(tr("{run}. Each nucleus gets a closed contour, the faint ones, too. The panel above the sliders counts "
                "them."), "nuclei_end.jpg"),
        Step(tr("Nuclei that touch have one contour around both: where they meet there is no edge between them. A "
                "barrier drawn across gives each a contour of its own, one of which may be open there. Run anew.")),
        Step(tr("Raise “Drop short contours” (<i>l</i><sub>min</sub>, under Advanced): the smallest nuclei go at "
                "once, without another run. Lower it, and they are back.")),
        Step(tr("{export}, as a label mask (PNG): every nucleus has a number of its own, ready to be measured.")),
    ),
    (tr("On an image of your own: choose {mode_automatic} and run. If texture within the nuclei is found, raise "
        "“Blur beforehand” or “Ignore faint edges”."),),
    "nuclei.png",
)  # fmt: skip

_HAND = Page(
    "hand",
    tr("A hand"),
    tr("A radiograph of a hand: the outline of the hand is one shape with five long bays, and the bones lie within."),
    (
        Step(tr("<a href='sample:hand.png'>Open the hand</a>. One circle is drawn in the palm."), "hand_start.jpg"),
        Step(tr("{run}. Some particles find the outline and run up every finger; others stay with the bones."),
             "hand_midway.jpg"),
        Step(tr("At rest the outline and the bones are found. Bones that are seen as one piece have one contour."),
             "hand_end.jpg"),
        Step(tr("Now only one finger: draw a region of interest around it (menu Draw), and start everywhere in it "
                "({start_grid}). What lies outside is dimmed and left alone. Run anew."), "hand_finger.jpg"),
        Step(tr("Move “Weak only beside strong” (<i>f</i><sub>sure</sub>, under Advanced): contours of faint edges "
                "come and go at once, without another run.")),
    ),
    (tr("On an image of your own: draw the circle so that it crosses the edges that you want. Lower “Calm the "
        "particles” (<i>β</i>) if they stop too early."),),
    "hand.png",
)  # fmt: skip

_CANVAS = Page(
    "canvas",
    tr("On the canvas"),
    tr("Left button: the tool. Middle or right button: move the image. Wheel: zoom around the pointer."),
    (),
    (
        tr("Arrow keys move the selected shape by a pixel, with Shift by ten; &lt; and &gt; make a selected circle "
           "smaller and larger."),
        tr("Strokes, regions of interest and barriers are drawn freehand with a drag, or corner by corner with clicks; "
           "Enter or a double click ends them, Backspace takes the last corner back, Esc gives up."),
        tr("Particles stay in a region of interest and do not cross a barrier."),
        tr("What is drawn into a run acts at once: new starts bring their particles, regions of interest, barriers and "
           "placed charges hold at the next step, and a run that has come to rest goes on with them. A start that is "
           "moved or removed acts from the next start."),
        tr("Changed parameters act at once; a run that has come to rest goes on with them after Resume."),
        tr("Enter on the image shows a cross-hair, which arrow keys move: with it every tool can be used by keys."),
        tr("Everything that changes the drawing or the parameters can be undone: {undo}."),
    ),
)  # fmt: skip

_FURTHER = Page(
    "further",
    tr("Going further"),
    tr("What helps when the first run has not found what you were after, and what comes after the last one."),
    (),
    (
        tr("<b>Steer.</b> Drop a charge that attracts or repels ({attract}, {repel}) among the particles and drag it: "
           "the field follows at once, and the particles with it. {barrier} keeps them where they are; {eraser} takes "
           "particles and shapes away."),
        tr("<b>Go back.</b> Drag along the timeline, or {timeline_back}. Change something there and run: that is a "
           "branch of its own. Both are kept and can be compared; {preferences} say how much memory that may take."),
        tr("<b>See why.</b> The panel Layers shows the edge map, the potential, the field and much more; "
           "{layer_forces} names the forces on a particle."),
        tr("<b>Choose.</b> {contour_table} lists what was found; {reject} leaves contours out of what is exported. "
           "{load_truth} tells how far they are from contours known to be right, and where."),
        tr("<b>Find values.</b> {mosaic} runs the image with some values of two parameters side by side."),
        tr("<b>Keep.</b> {save} keeps everything but the particles in one file, which runs without a window as well: "
           "<code>cpm run --session FILE</code> for one image, <code>cpm batch</code> for many."),
        tr("<b>Show.</b> {export_animation} and {export_strip} show others how the contours were found."),
    ),
)  # fmt: skip

PAGES = (_FIRST, _ARTERY, _NUCLEI, _HAND, _FURTHER, _CANVAS)
"""In the order in which they stand."""
