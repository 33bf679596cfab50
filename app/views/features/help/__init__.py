"""Menu Help: tour, guide and keys."""
