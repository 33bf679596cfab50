"""Where compiled loops are kept between two starts of the program, and which of them are still valid.

Numba decides by the file of a loop alone whether its cached code is still valid. But a loop that calls another one
holds a copy of it, and it names the tuple classes that it takes: when these change in another file, the cached code is
out of date, or cannot be read and is not replaced. Here the loops of a module have a folder of their own, which is
named after the sources that they are made of (`versions`). It lies in a cache of the user (`folders`); a program that
is packaged for a system may bring folders that are filled, from which loops are read first (`shipped`).
"""
