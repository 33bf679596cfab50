"""Notebooks: an image in which clicks select objects."""

from cpm_core.notebook.view import NotebookView as NotebookView
from cpm_core.notebook.view import notebook_view as notebook_view
