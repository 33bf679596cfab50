"""The image and its scale."""
