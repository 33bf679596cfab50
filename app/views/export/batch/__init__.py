"""The dialog that applies a session to many images."""
