"""Particles, their colors and trails, and the forces on them."""
