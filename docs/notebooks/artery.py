# %% [markdown]
# # The width of an artery
#
# Where is the artery narrow, and how narrow? The skeleton is its middle line, with the distance to the walls at every
# place.

# %%
import matplotlib.pyplot as plt
import numpy as np

import cpm_core as cpm

image = cpm.load_image("assets/samples/artery.png")
bones = cpm.skeleton(image, of="dark")
bones

# %% [markdown]
# A vessel gets thinner from branch to branch. A place is narrow where it is thinner than what lies around it: its
# width, which is twice the radius, is compared with the median width within 25 px along the branch.


# %%
def along(branch):
    """Length along a branch up to each of its vertices."""
    steps = np.linalg.norm(np.diff(branch.points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


found = []
for branch, radii in zip(bones.contours, bones.radii, strict=True):
    place = along(branch)
    usual = np.array([np.median(radii[np.abs(place - at) < 25]) for at in place])
    inner = (place > 15) & (place < place[-1] - 15)  # branches begin within others
    if inner.any():
        share = np.where(inner, radii / usual, np.inf)
        found.append((share.min(), int(share.argmin()), branch, radii, usual))
share, at, branch, radii, usual = min(found, key=lambda one: one[0])
print(f"{2 * radii[at]:.1f} px wide where {2 * usual[at]:.1f} px are usual")
print(f"narrowed by {100 * (1 - share):.0f} % at (row, col) {branch.points[at].round()}")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
bones.plot(image.plot(left, scale_bar=False), scale_bar=False)
left.plot(*branch.points[at][::-1], "o", color="#f0e442", markersize=8)
right.plot(along(branch), 2 * radii, label="width")
right.plot(along(branch), 2 * usual, ":", label="usual width")
right.set(xlabel="along the branch [px]", ylabel="[px]")
legend = right.legend()
