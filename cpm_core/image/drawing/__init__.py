"""Pictures of images and of what was found in them, and a few drawn images to try things on.

`raster` draws small pictures for notebooks by Pillow, which is always there; `axes` draws on axes of matplotlib, which
is imported only then. Both take arrays and curves, so that all rooms above can use them. `palette` has the colors,
`scale_bar` the bar of round length, and `examples` the drawn images.
"""
