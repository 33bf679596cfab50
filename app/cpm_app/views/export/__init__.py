"""The dialog of the export."""
