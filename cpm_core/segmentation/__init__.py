"""A whole run: the engine that composes a step, the schedule of scales, its completion, and interventions."""
