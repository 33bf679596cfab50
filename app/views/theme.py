"""Colours: a light and a dark palette for the window, and colours on the canvas that colour-blind people tell apart."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication

# The canvas is dark in either theme, so that the image is the brightest thing on it. Hues after Okabe and Ito.
CANVAS = "#14161a"
MOVING = "#f0e442"
RESTING = "#2bd4a4"
CLOSED = "#56b4e9"
OPEN = "#ff9d1e"
JUNCTION = "#ff7ac6"
DRAWING = "#c9ced6"
CHOSEN = "#ffffff"
BRIDGE = "#ffffff"
REJECTED = "#a9b0ba"
HOVERED = "#90ffffff"
TRUTH = "#d79bd0"
MISSING = "#ff5a36"
WRONG = "#ffe14d"
REGION = "#b48cff"
BARRIER = "#f0533a"
ATTRACTING = "#0072b2"
REPELLING = "#d55e00"
DIMMED = "#88101216"
HALO = "#101216"
FIELD = "#ff9ad5"
TRAIL = "#7fd0ff"
GHOST = "#c792ff"


@dataclass(frozen=True, slots=True)
class Theme:
    """Colours of the window."""

    dark: bool
    window: str
    panel: str
    base: str
    button: str
    text: str
    dim: str
    line: str
    accent: str
    accent_text: str
    trouble: str
    trouble_text: str
    news: str
    news_text: str


LIGHT = Theme(
    dark=False,
    window="#f3f4f6",
    panel="#fafbfc",
    base="#ffffff",
    button="#eceef1",
    text="#1b1f24",
    dim="#5a6470",
    line="#cfd4da",
    accent="#1f6fd6",
    accent_text="#ffffff",
    trouble="#fde3e1",
    trouble_text="#7d1a14",
    news="#dff0e6",
    news_text="#14532d",
)
DARK = Theme(
    dark=True,
    window="#1e2126",
    panel="#22262c",
    base="#343a43",
    button="#3a414b",
    text="#e7eaee",
    dim="#9aa4b0",
    line="#464d58",
    accent="#4d94ee",
    accent_text="#0c1016",
    trouble="#4d2320",
    trouble_text="#ffd9d5",
    news="#1e3d2c",
    news_text="#d4f3e0",
)


def system_theme() -> Theme:
    """The theme that the desktop asks for; the light one when it does not say."""
    dark = QGuiApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark
    return DARK if dark else LIGHT


def apply_theme(theme: Theme) -> None:
    """Give the whole application a theme."""
    application = QApplication.instance()
    if isinstance(application, QApplication):
        application.setPalette(_palette(theme))
        application.setStyleSheet(_style_sheet(theme))


def _palette(theme: Theme) -> QPalette:
    palette = QPalette()
    role = QPalette.ColorRole
    colours = {
        role.Window: theme.window,
        role.WindowText: theme.text,
        role.Base: theme.base,
        role.AlternateBase: theme.panel,
        role.Text: theme.text,
        role.Button: theme.button,
        role.ButtonText: theme.text,
        role.BrightText: theme.trouble_text,
        role.ToolTipBase: theme.base,
        role.ToolTipText: theme.text,
        role.PlaceholderText: theme.dim,
        role.Highlight: theme.accent,
        role.HighlightedText: theme.accent_text,
        role.Link: theme.accent,
        role.Mid: theme.line,
    }
    for key, colour in colours.items():
        palette.setColor(key, QColor(colour))
    faded = QColor(theme.dim)
    faded.setAlpha(140)
    for key in (role.WindowText, role.Text, role.ButtonText):
        palette.setColor(QPalette.ColorGroup.Disabled, key, faded)
    return palette


def _style_sheet(theme: Theme) -> str:
    return f"""
    QToolTip {{ color: {theme.text}; background: {theme.base}; border: 1px solid {theme.line}; padding: 4px; }}
    QToolBar {{ background: {theme.window}; border: none; border-bottom: 1px solid {theme.line};
                spacing: 3px; padding: 4px; }}
    QToolBar QToolButton {{ padding: 4px 7px; border: 1px solid transparent; border-radius: 5px; }}
    QToolBar QToolButton:hover {{ background: {theme.button}; border-color: {theme.line}; }}
    QToolBar QToolButton:focus {{ border-color: {theme.accent}; }}
    QToolBar QToolButton:checked {{ background: {theme.button}; border-color: {theme.accent}; }}
    QToolBar QToolButton::menu-indicator {{ subcontrol-origin: padding; subcontrol-position: right top; }}
    QToolBar QToolButton#primary {{ background: {theme.accent}; color: {theme.accent_text}; font-weight: 600; }}
    QToolBar QToolButton#primary:disabled {{ background: {theme.button}; color: {theme.dim}; }}
    QStatusBar {{ border-top: 1px solid {theme.line}; }}
    QStatusBar::item {{ border: none; }}
    QMainWindow::separator {{ width: 1px; background: {theme.line}; }}
    QWidget#side {{ background: {theme.panel}; }}
    QLabel#heading {{ color: {theme.dim}; font-weight: 600; }}
    QLabel#dim {{ color: {theme.dim}; }}
    QLabel#state {{ font-weight: 600; }}
    QLabel#explanation {{ color: {theme.dim}; }}
    QToolButton#fold {{ border: none; color: {theme.dim}; font-weight: 600; padding: 2px 0; }}
    QToolButton#fold:focus {{ color: {theme.accent}; }}
    QToolButton#chip {{ border: 1px solid {theme.line}; border-radius: 4px; padding: 1px 5px; color: {theme.dim}; }}
    QToolButton#chip:checked {{ background: {theme.button}; color: {theme.text}; }}
    QToolButton#chip:focus {{ border-color: {theme.accent}; }}
    QToolButton#restore {{ border: none; padding: 0; }}
    QToolButton#restore:focus {{ border: 1px solid {theme.accent}; border-radius: 3px; }}
    QFrame#trouble {{ background: {theme.trouble}; border: none; }}
    QFrame#trouble QLabel {{ color: {theme.trouble_text}; }}
    QFrame#news {{ background: {theme.news}; border: none; }}
    QFrame#news QLabel {{ color: {theme.news_text}; }}
    QLabel#hint {{ background: rgba(16, 18, 22, 205); color: #f2f4f7; border-radius: 6px; padding: 6px 12px; }}
    QScrollArea, QWidget#scrolled {{ background: transparent; border: none; }}
    QScrollBar:vertical {{ background: transparent; width: 9px; margin: 0; }}
    QScrollBar::handle:vertical {{ background: {theme.line}; border-radius: 4px; min-height: 28px; }}
    QScrollBar::handle:vertical:hover {{ background: {theme.dim}; }}
    QScrollBar::add-line:vertical, QScrollBar::sub-line:vertical {{ height: 0; }}
    QScrollBar::add-page:vertical, QScrollBar::sub-page:vertical {{ background: transparent; }}
    """
