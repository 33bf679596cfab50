"""The table of contours: columns, model, view, thresholds, and the panel that holds them together."""

from app.views.panels.contour_table.panel import ContourPanel

__all__ = ["ContourPanel"]
