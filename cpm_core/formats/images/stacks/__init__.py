"""Files that hold several planes: what they have in common, and stacks of pictures."""
