"""The Coulomb force between the free particles, eq. (9).

`force` chooses how the sum is carried out: pair by pair (`pairs`), or by a fast multipole method (`multipole`), which
sorts the particles into a tree (`tree`) and replaces groups that are far from one another by series (`series`). Within
a run the particles lie in one image and hardly move from step to step, and a mesh carries what comes from afar
(`far_force`).
"""
