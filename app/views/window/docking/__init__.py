"""Panels in docks: their places, heights and headings."""
