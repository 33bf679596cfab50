"""The prior: how the weights in `cpm_core/objects/prior` are grown from images with known objects.

`pictures` reads images that people have outlined, and drawings; `textures`, `shapes`, `scenes`, `drawn` and `nested`
make images up, of which `pools` keeps as many as are needed. `prompts` shows a part of an image, varied, with what a
user might do there, `network` is what learns, and `grow` is the program.

All of this runs once in a long while, in an environment of its own: besides what `cpm_core` needs, it needs
``torch`` and ``opencv-python-headless``, which nothing else here does.
"""
