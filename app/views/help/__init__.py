"""Tour, guide and cheat sheet."""
