"""Notebooks: an image in which clicks select objects."""

from cpm_core.notebook.view import NotebookView, notebook_view

__all__ = ["NotebookView", "notebook_view"]
