"""The document: image, shapes, parameters and marks; frozen, edited by pure functions."""
