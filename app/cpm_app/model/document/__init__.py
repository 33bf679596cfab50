"""The document: image, shapes, parameters and objects; frozen, edited by pure functions."""
