"""The gallery: the experiments of the paper on images of our own, drawn and measured anew by one command.

`outlines` makes shapes whose boundary is known exactly, `scenes` paints images from them (`silhouettes`, `pictures`),
`runs` lets particles flow in them and measures what is found. `recovery`, `automatic`, `skeletons` and `studies` are
the experiments, one function for each figure. `pages` says what a figure shows, `drawing` draws it, and `figures` is
the table of all of them.
"""
