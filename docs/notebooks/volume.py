# %% [markdown]
# # A surface in a volume
#
# The same particles find surfaces: from a small sphere they run along the wall, here of a ball of known size.

# %%
import numpy as np

import cpm_core as cpm

volume = cpm.example("ball")
result = cpm.segment(volume, cpm.sphere((15, 15, 15), radius=4, count=60), cpm.PRESETS["volume"])
result

# %%
surface = result.surface
true = 4 / 3 * np.pi * 9.0**3
print(f"closed: {surface.closed}, Euler characteristic {surface.euler}")
print(f"{surface.volume:.0f} {surface.unit}³ inside, {100 * (surface.volume / true - 1):+.1f} % of the true volume off")

# %% [markdown]
# Each object is a label of a label volume, and a row of the table.

# %%
table = result.table(in_units=True)
print(result.labels.shape, {name: round(float(column[0]), 2) for name, column in table.items() if name != "label"})

# %%
axes = surface.plot()
