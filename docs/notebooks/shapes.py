# %% [markdown]
# # Compare shapes
#
# A drawn outline, its measures, and how far another one lies from it: what a morphologist asks of every specimen.

# %%
import numpy as np

import cpm_core as cpm

image = cpm.load_image("assets/samples/u_shape.png")
result = cpm.segment(image, cpm.circle((100, 73), 38))
result

# %%
table = result.table()
for name in ("area", "perimeter", "solidity", "circularity", "axis_major_length", "orientation"):
    print(f"{name:18} {table[name][0]:9.3f} {table.units[name]}")

# %% [markdown]
# How sure is the outline? The same run under noise, with the smoothing that the noise asks for, gives another one; the
# distance between both is what the noise changes.

# %%
rng = np.random.default_rng(1)
noisy = cpm.Image(image.values + rng.normal(0.0, 20.0, image.shape), source="under noise")
again = cpm.segment(noisy, cpm.circle((100, 73), 38), cpm.PRESETS["noisy"])
truth = cpm.Truth(result.labels, result.contours, "without noise")
found = cpm.compare(again.contours, truth)
print(f"mean distance {found.mean_boundary_distance:.2f} px, largest {found.hausdorff:.1f} px, Dice {found.dice:.3f}")

# %%
axes = again.plot()

# %% [markdown]
# The skeleton represents the shape: the disks around its points rebuild it.

# %%
bones = cpm.skeleton(image)
rebuilt, mask = bones.rebuild_shape(), result.labels > 0
print(f"{len(bones.contours)} branches, {100 * (rebuilt & mask).sum() / mask.sum():.1f} % of the area rebuilt")
