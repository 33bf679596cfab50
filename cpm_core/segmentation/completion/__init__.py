"""Completion of a scale: what is added before it ends, and which particles remain; `plane` and `space`."""
