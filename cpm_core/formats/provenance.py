"""Provenance: the version of the program, which its files tell."""

from __future__ import annotations

VERSION = "0.1.0"
"""Version of CPM; the package is built with it."""
