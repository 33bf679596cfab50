"""The Coulomb force between the free particles, eq. (9).

`coulomb_force` is the force itself, of particles anywhere: pair by pair (`direct_sum`), or by a fast multipole method
(`fast_multipole`), which sorts the particles into a tree (`kd_tree`) and replaces groups that are far from one another
by series (`expansions`). A run, whose particles lie in one image and hardly move from step to step, sums near pairs
(`pair_force`) and has a mesh carry what comes from afar (`mesh_force`).

Why two sums. The mesh of a run serves for several steps and is allowed errors that friction hides; `coulomb_force`
keeps any tolerance, wherever particles are. One mesh for both has been tried, its pitch an eighth of a reach chosen
for the least time. Where particles fill an image along curves it is the faster of the two: 64,000 of them take 18 ms
against 38 to 62 ms by the tree, with an error of 3e-5 against 2e-4. But a mesh is even, and particles need not be. Of
64,000 in a cluster with 80 outliers 200 times as far away most are near pairs for any mesh that memory holds: 590 ms at
best, against 57 ms, and growing with the square of their number. On a slanting line of as many, where what acts on each
nearly cancels, single precision and the mesh leave an error of 7 % after 72 ms; the tree, in 32 ms, leaves 4e-5. And no
mesh in single precision keeps tolerances below about 1e-5, which the tree keeps down to 1e-12.
"""
