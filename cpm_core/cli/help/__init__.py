"""Help on the command line: examples, what may have been meant, and completion in shells."""
