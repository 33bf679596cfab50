"""Snakes: closed curves that forces of an image move and forces of their own keep smooth."""
