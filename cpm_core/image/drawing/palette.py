"""The colors of pictures: those of the window, hues of Okabe and Ito that color-blind people can tell apart."""

from __future__ import annotations

PARTICLE, CLOSED, OPEN, JUNCTION, FIELD = "#f0e442", "#56b4e9", "#ff9d1e", "#ff7ac6", "#ff9ad5"
HALO = "#101216"
"""What surrounds lines and dots, so that they can be seen on any gray."""

DARKEST, BRIGHTEST = 0.1, 0.86
"""Brightness of the extreme gray levels, on which lines and their halos must be visible."""

EXTREMES = (0.2, 99.8)
"""Percentiles of the gray levels that count as their extremes."""
