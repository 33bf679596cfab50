"""The command ``cpm run``: images, the pages of a stack, volumes, and objects that places name."""
