"""The keyboard of the window: who gets a key, and where the keyboard goes next."""
