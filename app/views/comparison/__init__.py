"""The comparison of runs: with other parameters, or of other methods, next to one another."""
