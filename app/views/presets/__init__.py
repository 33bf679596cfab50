"""The gallery of presets and their files."""
