"""What differs between the plane and space in a run: `plane` and `space` have the same functions.

An engine chooses one of the two by its image and calls nothing else that depends on the dimension.
"""
