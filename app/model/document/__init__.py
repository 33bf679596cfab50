"""The document: what a person has opened, drawn, set and said; frozen, edited by pure functions."""
