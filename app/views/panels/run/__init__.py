"""The panel of the run: figures and plots."""
