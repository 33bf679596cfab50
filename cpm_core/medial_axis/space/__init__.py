"""Center lines of what is long and thin in a volume."""
