"""Texts: translation, names of parameters, and the program's own files."""
