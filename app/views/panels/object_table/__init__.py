"""The panel of the objects: a table with their classes and measures."""

from app.views.panels.object_table.panel import ObjectPanel

__all__ = ["ObjectPanel"]
