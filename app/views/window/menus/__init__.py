"""The menu bar, and the menus of what lies under the pointer."""
