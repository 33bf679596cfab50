"""Going along the timeline, and comparing its branches."""
