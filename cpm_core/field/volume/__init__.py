"""The fields of a volume (plane, row, col), which may have voxels of unequal sides.

Lengths are in units of the smallest side of a voxel; the `pitch` of a volume has the sides of a voxel in these units.
There is no force per voxel: some ten thousand particles need it in few places, where `surface_force` computes it from
the smoothed volume, the edge map and the far field of the fixed charges.
"""
