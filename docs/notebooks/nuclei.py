# %% [markdown]
# # Count and measure nuclei
#
# How many nuclei are there, how large and how round are they? Nothing has to be drawn: particles start in the middle of
# what lies between edges.

# %%
import cpm_core as cpm

image = cpm.load_image("assets/samples/nuclei.png", spacing=0.5, unit="µm")
result = cpm.segment(image, cpm.divergence_centers(image.values), cpm.PRESETS["automatic"])
result

# %% [markdown]
# `labels` is an array of the image's size, as other packages take it, and `table` measures what each contour encloses.

# %%
table = result.table(in_units=True)
closed = table.rows
print(f"{closed} closed contours, {result.labels.max()} labels")
print(f"area {table['area'].mean():.0f} ± {table['area'].std():.0f} {table.units['area']}")
print(f"circularity {table['circularity'].mean():.2f}")

# %% [markdown]
# Two nuclei that touch have one contour around both, with a neck: its solidity is lower than that of the others.

# %%
order = table["solidity"].argsort()
for row in order[:3]:
    solidity, area = table["solidity"][row], table["area"][row]
    print(f"label {table['label'][row]}: solidity {solidity:.2f}, area {area:.0f} µm²")

# %%
axes = result.plot(labels=True)

# %% [markdown]
# The objects that the run proposes tell them apart; clicks add others and correct them. In Jupyter, with anywidget
# installed, click two nuclei, and Shift-click what is wrong; each line here is the same as a click.

# %%
view = cpm.notebook_view(result)
view.click((97, 92))
view.click((97, 127))
view

# %% [markdown]
# What was proposed and clicked is in Python; here without what is doubtful, the background between nuclei.

# %%
nuclei = cpm.objects_result([one for one in view.objects if one.confidence > 0.5])
print(nuclei.table(in_units=True)["area"].round())

# %% [markdown]
# What was found goes into files that other programs open: a set for ImageJ, a label mask with the size of a pixel, and
# a table.

# %%
import tempfile
from pathlib import Path

with tempfile.TemporaryDirectory() as folder:
    cpm.export(result, f"{folder}/nuclei.zip", f"{folder}/nuclei.tif", f"{folder}/nuclei.measures.csv")
    cpm.write_figure(result, f"{folder}/nuclei.pdf", labels=True)
    print(*sorted(path.name for path in Path(folder).iterdir()), sep="\n")
