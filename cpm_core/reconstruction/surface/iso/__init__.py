"""The default surface: where a volume passes through a threshold that the particles tell from place to place."""
