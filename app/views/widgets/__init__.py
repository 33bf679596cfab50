"""Small widgets for panels, and specifications of actions."""
