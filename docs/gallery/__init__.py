"""The gallery: the experiments of the paper on synthetic images, repeated and measured by one command.

`outlines` makes shapes whose boundary is known exactly, `scenes` paints images from them (`silhouettes`, `pictures`),
`runs` starts particles in them and measures the result. `recovery`, `skeletons` and `studies` are the experiments.
`pages` holds the content of a figure, `plotting` draws it, and `figures` is the table of all of them.
"""
