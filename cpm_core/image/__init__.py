"""The image: its pixels and their size, the pyramid, the image border, regions of interest, barriers, and denoising."""
