"""Contours edited by hand: lines that follow the edges from place to place, and the edits made with them."""
