"""The dialog of the preferences, its fields and the page of the shortcuts."""
