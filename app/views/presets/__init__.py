"""The gallery of presets and what is done with them."""
