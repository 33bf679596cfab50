"""The prior: which object places and drawn starts mean, learned from images that people have outlined."""
