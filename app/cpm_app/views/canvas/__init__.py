"""The canvas, with cross-hair, legend, messages, and side views of a volume."""
