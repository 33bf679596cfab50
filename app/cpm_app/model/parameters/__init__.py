"""Controls of the parameters, and presets."""
