"""Objects in the session: the partition that is kept up to date, selecting by clicks, and the list of objects."""
