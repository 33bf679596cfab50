"""The comparison of runs: with other parameters, or of other methods, next to one another."""

from app.views.comparison.dialog import CompareDialog

__all__ = ["CompareDialog"]
