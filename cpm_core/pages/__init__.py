"""Stacks whose pages are images of their own: one run a page, objects followed from page to page as tracks."""
