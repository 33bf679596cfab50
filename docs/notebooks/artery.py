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
# The longest branch is the main vessel. Its width is twice the radius.

# %%
branch, radii = bones.contours[0], bones.radii[0]
along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(branch.points, axis=0), axis=1))])
narrowest = int(np.argmin(radii[10:-10])) + 10
print(f"{branch.length:.0f} px long, {2 * np.median(radii):.1f} px wide at the median")
print(f"{2 * radii[narrowest]:.1f} px wide at its narrowest place, {along[narrowest]:.0f} px along it")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
bones.plot(image.plot(left, scale_bar=False), scale_bar=False)
left.plot(*branch.points[narrowest][::-1], "o", color="#f0e442", markersize=8)
right.plot(along, 2 * radii)
labels = right.set(xlabel="along the branch [px]", ylabel="width [px]")
