"""Files of animations, and strips of snapshots."""
