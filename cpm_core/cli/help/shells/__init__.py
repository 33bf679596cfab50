"""Scripts for shells, a module for each."""
