"""Settings that every test shares."""

import os

# No window of a test shall flash on a person's screen unless asked for by naming a platform.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
