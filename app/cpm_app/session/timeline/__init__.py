"""The timeline: every step of a run and its branches, recovered from kept states and recorded actions."""
