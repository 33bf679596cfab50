"""The law of a run on an image: repulsion, motion, births and deletions, and the step that they make."""
