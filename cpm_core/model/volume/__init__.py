"""The law of a run in a volume: motion, births and deletions, and the step that they make."""
