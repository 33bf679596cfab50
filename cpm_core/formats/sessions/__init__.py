"""Files of sessions: what a person has drawn, set and said, as readable JSON."""
