"""The image: its pixels and their size, the pyramid, the border, regions of interest and barriers, and denoising."""
