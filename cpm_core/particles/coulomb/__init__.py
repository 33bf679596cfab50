"""The Coulomb force between the free particles, eq. (9).

`coulomb_force` is the force itself, of particles anywhere: pair by pair (`direct_sum`), or by a fast multipole method
(`fast_multipole`), which sorts the particles into a tree (`kd_tree`) and replaces groups that are far from one another
by series (`expansions`); in space, the same two ways (`space`, `space_tree`). In a run, all particles lie in one image
and hardly move from step to step: near pairs are summed (`pair_force`), and a mesh carries the rest (`mesh_force`).

Why there are two methods. The mesh of a run is used for several steps and may have errors that friction hides;
`coulomb_force` keeps any tolerance, for particles anywhere. One mesh for both has been tried, with a pitch of an eighth
of a reach chosen for the least time. Where particles fill an image along curves it is the faster of the two: 64,000 of
them take 18 ms against 38 to 62 ms by the tree, with an error of 3e-5 against 2e-4. But a mesh is uniform, and
particles may not be. Of 64,000 in a cluster with 80 outliers 200 times as far away most are near pairs for any mesh
that memory holds: 590 ms at best, against 57 ms, and growing with the square of their number. On a slanting line of as
many, where the forces on each nearly cancel, single precision and the mesh leave an error of 7 % after 72 ms; the tree
leaves 4e-5 in 32 ms. And no mesh in single precision keeps tolerances below about 1e-5, which the tree keeps down to
1e-12.
"""
