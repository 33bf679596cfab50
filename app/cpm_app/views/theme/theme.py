"""Colors: a light and a dark theme for the window, and the style of the canvas, which color-blind people can read.

Items of the canvas read the style when they paint, so that layers need not know it; all canvases share it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from string import Template
from typing import Literal

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication, QWidget

from cpm_app.model.preferences.table import INK_PREFERENCES
from cpm_core.numerics.types import frozen

LineKind = Literal["contours", "shapes", "fixed"]
"""Kind of a line; the width of fixed lines cannot be changed."""


class Ink(str):
    """A color that the user can change, known by its name; its text is the default."""

    __slots__ = ("name",)

    def __new__(cls, name: str, default: str) -> Ink:
        """Create the color from its name and default."""
        made = super().__new__(cls, default)
        made.name = name
        return made

    name: str


@frozen
class CanvasStyle:
    """Factors for the widths of lines and the size of points, and the colors that the user has changed, by name."""

    contours: float = 1.0
    shapes: float = 1.0
    points: float = 1.0
    colors: Mapping[str, str] = field(default_factory=dict)

    def width_factor(self, kind: LineKind) -> float:
        """Return the factor for the width of lines."""
        return {"contours": self.contours, "shapes": self.shapes, "fixed": 1.0}[kind]

    def resolve_color(self, color: str) -> str:
        """Return the color that the user has selected for an ink; any other color is unchanged."""
        return self.colors.get(color.name, str(color)) if isinstance(color, Ink) else color


_canvas_style = CanvasStyle()
"""Style in use, one for all canvases."""


def get_canvas_style() -> CanvasStyle:
    """Return the style in use."""
    return _canvas_style


def set_canvas_style(style: CanvasStyle) -> None:
    """Set the style; canvases must be repainted afterwards."""
    global _canvas_style  # noqa: PLW0603  # shared by all canvases, as the style sheet is shared by all widgets
    _canvas_style = style


# The canvas is dark in both themes, so that the image is the brightest object. Hues after Okabe and Ito.
CANVAS_COLOR = "#14161a"
"""Background of the canvas."""

# The preferences can change the inks. Items of the canvas and swatches resolve them; elsewhere use `get_canvas_style`.
MOVING_COLOR = Ink("moving", INK_PREFERENCES["moving"].default)
"""Moving particles."""

RESTING_COLOR = Ink("resting", INK_PREFERENCES["resting"].default)
"""Particles at rest."""

CONTOUR_COLOR = Ink("contour", INK_PREFERENCES["contour"].default)
"""Contours."""

PROPOSAL_COLOR = Ink("proposal", INK_PREFERENCES["proposal"].default)
"""Proposed objects."""

BY_HAND_COLOR = Ink("by_hand", INK_PREFERENCES["by_hand"].default)
"""Lines that are being drawn by hand."""

UNKNOWN_COLOR = "#ff7ac6"
"""Particles whose quantity is not known yet, in no color map; and friction."""

DRAWING_COLOR = "#c9ced6"
"""Shapes that the user draws."""

SELECTED_COLOR = "#ffffff"
"""Selected items."""

REMOVED_COLOR = "#ff5a36"
"""What an edit removes."""

HOVERED_COLOR = "#90ffffff"
"""Items under the pointer."""

TRUTH_COLOR = "#d79bd0"
"""Ground truth."""

MISSING_COLOR = "#ff5a36"
"""Parts of the reference that were not found."""

WRONG_COLOR = "#ffe14d"
"""Parts that are not in the reference."""

AREA_COLOR = "#9ccc65"
"""Area of a start."""

MEASURE_COLOR = "#ffd166"
"""Rulers, angles and measuring ellipses."""

REGION_COLOR = "#b48cff"
"""Regions of interest."""

BARRIER_COLOR = "#f0533a"
"""Barriers."""

ATTRACTING_COLOR = "#0072b2"
"""Charges that attract particles."""

REPELLING_COLOR = "#d55e00"
"""Charges that repel particles."""

DIMMED_COLOR = "#88101216"
"""Veil over the rest of the image."""

CANVAS_HALO_COLOR = "#101216"
"""Dark rim around lines and points."""

FIELD_COLOR = "#ff9ad5"
"""Electric field."""

THICKNESS_COLORS = ("#6a7fd1", "#3f9fd0", "#35bcab", "#8ccf5e", "#f3e04b")
"""Colors from thin to thick: of increasing lightness, so that they can be told apart without red and green."""

DISK_COLOR = "#70ffffff"
"""Largest disks inside an object."""

COULOMB_COLOR = "#ff9d1e"
"""Coulomb force."""

LORENTZ_COLOR = "#56b4e9"
"""Lorentz force."""

DAMPING_COLOR = "#2bd4a4"
"""Damping force."""


Theme = Mapping[str, str]
"""Colors of the window by their roles."""

_THEME_COLORS = {
    "window": ("#f3f4f6", "#1e2126"),
    "panel": ("#fafbfc", "#22262c"),
    "base": ("#ffffff", "#343a43"),
    "button": ("#eceef1", "#3a414b"),
    "text": ("#1b1f24", "#e7eaee"),
    "dim": ("#5a6470", "#a8b2bd"),
    "line": ("#cfd4da", "#464d58"),
    "accent": ("#1c69cd", "#4d94ee"),
    "accent_text": ("#ffffff", "#0c1016"),
    "accent_hover": ("#185fbb", "#6ba8f5"),
    "chosen": ("#dbe8fa", "#2c425f"),
    "faded": ("#858d97", "#757f8b"),
    "error": ("#fde3e1", "#4d2320"),
    "error_text": ("#7d1a14", "#ffd9d5"),
    "message": ("#dff0e6", "#1e3d2c"),
    "message_text": ("#14532d", "#d4f3e0"),
}
"""Light and dark color of each role."""

LIGHT_THEME: Theme = {role: light for role, (light, _) in _THEME_COLORS.items()}
"""The light theme."""

DARK_THEME: Theme = {role: dark for role, (_, dark) in _THEME_COLORS.items()}
"""The dark theme."""


def system_theme() -> Theme:
    """Return the theme of the desktop, or the light one if it is unknown."""
    dark = QGuiApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark
    return DARK_THEME if dark else LIGHT_THEME


_PALETTE_ROLES = {
    "window": ("Window",),
    "panel": ("AlternateBase",),
    "base": ("Base", "ToolTipBase"),
    "button": ("Button",),
    "text": ("Text", "WindowText", "ButtonText", "ToolTipText"),
    "dim": ("PlaceholderText",),
    "line": ("Mid",),
    "accent": ("Highlight",),
    "accent_text": ("HighlightedText",),
    "accent_hover": ("Link",),
}
"""Palette roles of Qt that have each color."""

_DISABLED_PALETTE_ROLES = {"faded": ("WindowText", "Text", "ButtonText"), "window": ("Base", "Button")}
"""The same for disabled widgets."""


def apply_theme(theme: Theme, window: QWidget) -> None:
    """Set the theme of the application.

    The style sheet belongs to the window and its dialogs: Qt would apply a style sheet of the application to each
    widget once per ancestor.
    """
    palette = QPalette()
    groups = (QPalette.ColorGroup.All, _PALETTE_ROLES), (QPalette.ColorGroup.Disabled, _DISABLED_PALETTE_ROLES)
    for group, roles in groups:
        for color, names in roles.items():
            for name in names:
                palette.setColor(group, QPalette.ColorRole[name], QColor(theme[color]))
    QApplication.setPalette(palette)
    window.setStyleSheet(_STYLE_SHEET.substitute(theme))


_STYLE_SHEET = Template("""
/* Menus, tool bars, status bar */
QToolTip { color: $text; background: $base; border: 1px solid $line; padding: 4px; }
QMenuBar { background: $window; }
QToolBar { background: $window; border: none; border-bottom: 1px solid $line;
            spacing: 2px; padding: 3px 4px; }
QToolBar#palette { border-bottom: none; border-right: 1px solid $line; }
QToolBar::separator { background: $line; width: 1px; height: 1px; margin: 5px; }
QToolBar QToolButton { padding: 4px 6px; border: 1px solid transparent; border-radius: 5px; }
QToolBar QToolButton:hover { background: $button; border-color: $line; }
QToolBar QToolButton:focus { border-color: $accent; }
QToolBar QToolButton:checked { background: $button; border-color: $accent; }
QToolBar QToolButton:disabled { color: $faded; }
QToolBar QToolButton::menu-indicator { subcontrol-origin: padding; subcontrol-position: right center;
                                        right: 3px; }
QToolBar QToolButton#tools { padding: 3px 14px 2px 2px; }
QToolBar QToolButton#tools[start="true"]:checked { background: transparent; border-color: transparent; }
QToolBar QToolButton#tools::menu-button { border: none; width: 14px; }
QToolBar QToolButton#qt_toolbar_ext_button { padding: 0; background: $button; border-color: $line; }
QToolBar QToolButton#primary { background: $accent; color: $accent_text; font-weight: 600; }
QToolBar QToolButton#primary:hover { background: $accent_hover; }
QToolBar QToolButton#primary:focus { border: 2px solid $text; padding: 3px 5px; }
QToolBar QToolButton#primary:disabled { background: $button; color: $faded; }
QWidget#segments QToolButton { background: $base; border: 1px solid $line; border-radius: 0;
                                padding: 4px 9px; }
QWidget#segments QToolButton[segment="first"] { border-right: none; border-top-left-radius: 6px;
                                                 border-bottom-left-radius: 6px; }
QWidget#segments QToolButton[segment="last"] { border-left: none; border-top-right-radius: 6px;
                                                border-bottom-right-radius: 6px; }
QWidget#segments QToolButton:hover { background: $button; }
QWidget#segments QToolButton:checked { background: $chosen; color: $text; font-weight: 600;
                                        border: 1px solid $accent; }
QWidget#segments QToolButton:focus { border: 1px solid $accent; }
QStatusBar { border-top: 1px solid $line; }
QStatusBar::item { border: none; }

/* Docks with their headings and tabs.
   The line between docks is one pixel wide, the separator that is dragged three: for one of a single pixel Qt makes a
   hidden widget whenever docks are shown, and keeps it until the window is closed. */
QMainWindow::separator { width: 1px; height: 1px; margin: 1px; background: $line; }
QMainWindow::separator:hover { background: $accent; }
QDockWidget { color: $dim; font-weight: 600; }
QToolButton#quiet { border: 1px solid transparent; border-radius: 4px; padding: 1px; }
QToolButton#quiet:hover { background: $button; }
QToolButton#quiet:focus { border-color: $accent; }
QTabBar::tab { color: $dim; padding: 5px 4px 4px 4px; border: none; border-bottom: 2px solid transparent;
                background: $window; }
QTabBar::tab:hover { color: $text; background: $button; }
QTabBar::tab:selected { color: $text; border-bottom-color: $accent; }
QTabBar::tab:focus { color: $text; }
QTabBar QToolButton { background: $button; border: 1px solid $line; }
QListWidget#contents::item { padding: 6px; }
QFrame#popup { background: $panel; border: 1px solid $line; }
QLabel#heading { color: $dim; font-weight: 600; }
QLabel#dim { color: $dim; }
QLabel#state { font-weight: 600; }
QToolButton#fold { border: none; color: $dim; font-weight: 600; padding: 2px 0; }
QToolButton#fold:hover { color: $text; }
QToolButton#fold:focus { color: $accent; }
QToolButton#chip { border: 1px solid $line; border-radius: 4px; padding: 1px 5px; color: $dim; }
QToolButton#chip:checked { background: $button; color: $text; }
QToolButton#chip:focus { border-color: $accent; }
QToolButton#restore { border: 1px solid transparent; border-radius: 3px; padding: 0; }
QToolButton#restore:focus { border-color: $accent; }
QScrollArea, QWidget#scrolled { background: transparent; border: none; }
QScrollBar:vertical { background: transparent; width: 9px; margin: 0; }
QScrollBar::handle:vertical { background: $line; border-radius: 4px; min-height: 28px; }
QScrollBar::handle:vertical:hover { background: $dim; }
QScrollBar:horizontal { background: transparent; height: 9px; margin: 0; }
QScrollBar::handle:horizontal { background: $line; border-radius: 4px; min-width: 28px; }
QScrollBar::add-line, QScrollBar::sub-line { width: 0; height: 0; }
QScrollBar::add-page, QScrollBar::sub-page { background: transparent; }
QHeaderView::section { color: $dim; background: $window; border: none; padding: 4px 3px;
                        border-bottom: 1px solid $line; }
QTableView, QTreeView, QListView { background: $base; alternate-background-color: $panel;
                                    border: 1px solid $line; gridline-color: $line; }

/* Sliders, fields and buttons in the panels */
QSlider::groove:horizontal { height: 4px; border-radius: 2px; background: $line; }
QSlider::sub-page:horizontal { height: 4px; border-radius: 2px; background: $accent; }
QSlider::handle:horizontal { width: 12px; height: 12px; margin: -5px 0; border-radius: 7px;
                              background: $base; border: 1px solid $dim; }
QSlider::handle:horizontal:hover { border-color: $accent; }
QSlider::handle:horizontal:focus { border: 2px solid $accent; width: 10px; height: 10px; }
QSlider::sub-page:horizontal:disabled { background: $line; }
QSlider::handle:horizontal:disabled { background: $window; border-color: $line; }
QPushButton { background: $button; color: $text; border: 1px solid $line; border-radius: 5px;
               padding: 4px 12px; }
QPushButton:hover, QPushButton:focus { border-color: $accent; }
QPushButton:pressed, QPushButton:checked { background: $chosen; }
QPushButton:default { border-color: $accent; }
QPushButton:disabled { color: $faded; border-color: $line; }
QFrame#popup QToolButton { background: $button; color: $text; border: 1px solid $line; border-radius: 5px;
                            padding: 4px 8px; }
QFrame#popup QToolButton:hover, QFrame#popup QToolButton:focus { border-color: $accent; }
QFrame#popup QToolButton:disabled { color: $faded; }
QPushButton:disabled, QFrame#popup QToolButton:disabled { background: $window; color: $faded; }
QDialogButtonBox, QMessageBox { dialogbuttonbox-buttons-have-icons: 0; }
QMessageBox QLabel#qt_msgbox_label { font-weight: 600; }
QMessageBox QLabel#qt_msgbox_informativelabel { min-width: 320px; }

/* The line below the canvas */
QFrame#slices { background: $window; border: none; border-top: 1px solid $line; }
QFrame#slices QToolButton { padding: 2px 8px; border-radius: 5px; border: 1px solid transparent; }
QFrame#slices QToolButton:checked { background: $chosen; }
QFrame#slices QToolButton:focus { border-color: $accent; }
QFrame#strip { background: $window; border: none; border-top: 1px solid $line; }
QLabel#over_image { background: rgba(16, 18, 22, 205); color: #f2f4f7; border-radius: 6px; padding: 3px 9px; }
QFrame#error { background: $error; border: none; }
QFrame#error QLabel, QFrame#error QToolButton { color: $error_text; }
QFrame#message { background: $message; border: none; }
QFrame#message QLabel, QFrame#message QToolButton { color: $message_text; }
QFrame#offer { background: $panel; border: none; border-bottom: 1px solid $line; }

/* The start screen in place of the image */
QWidget#start { background: $window; }
QWidget#start QListView { background: transparent; border: none; color: $text; }
QWidget#start QListView::item { border: 2px solid transparent; border-radius: 6px; padding: 4px; }
QWidget#start QListView::item:hover { background: $button; }
QWidget#start QListView::item:selected { background: $button; color: $text; }
QWidget#start QListView::item:selected:focus { background: $chosen; color: $text; border-color: $accent; }
""")
