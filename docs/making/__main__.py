"""Bring the tables and figures of the pages up to date: ``python -m docs.making``."""

from docs.making.pages import update_pages

update_pages()
