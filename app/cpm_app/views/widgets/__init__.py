"""Small widgets for panels, and actions."""
