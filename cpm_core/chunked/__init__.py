"""Images larger than memory: run chunk by chunk with overlap, with results joined across the seams."""
