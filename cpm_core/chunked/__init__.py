"""An image larger than memory: chunk by chunk with overlap, and what is found joined across the seams."""
