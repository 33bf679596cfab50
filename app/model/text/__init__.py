"""Words: translation, names of parameters and shapes, and the files that come with the program."""
