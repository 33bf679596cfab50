"""The command ``cpm batch``: its jobs, the processes that do them, and the table of what has been done."""
