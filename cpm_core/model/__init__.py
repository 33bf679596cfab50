"""The model of the paper: particles, the laws that move them, and one step of a run in the plane and in a volume."""
