"""Files of the bodies found in a volume chunk by chunk: a label volume, one surface, and a table."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from cpm_core.chunked.grid import Chunk
from cpm_core.chunked.results import build_label_image, build_provenance, write_table_parts
from cpm_core.chunked.run import Compute
from cpm_core.chunked.volume_objects import load_split_objects
from cpm_core.chunked.volume_surface import ChunkedBodies
from cpm_core.formats.common.provenance import PROGRAM_NAME, describe_image_provenance, dump_provenance
from cpm_core.formats.images.ome_zarr import write_window
from cpm_core.formats.images.resolution import ascii_unit, name_column
from cpm_core.formats.meshes import ply
from cpm_core.formats.meshes.coordinates import to_file_coordinates
from cpm_core.numerics.grids import expand_window
from cpm_core.numerics.types import Index


def write_label_volume(bodies: ChunkedBodies, _: Path, draft: Path, compute: Compute) -> None:
    """Write a label volume in levels of resolution."""
    build_label_image(
        bodies.volume.task.source, bodies.grid, draft, partial(_paint_body_labels, bodies, draft), compute
    )


def _paint_body_labels(bodies: ChunkedBodies, path: Path, chunk: Chunk) -> None:
    """Write the numbers of the bodies in the core of a chunk."""
    of_part = bodies.body_of_part[bodies.first_part[chunk.number] : bodies.first_part[chunk.number + 1]].astype(
        np.uint32
    )
    labels = of_part[bodies.regions.read_window(chunk.core)]
    if bodies.object_numbers:
        around = expand_window(chunk.core, bodies.grid.side + bodies.grid.overlap, bodies.grid.shape)
        for near in bodies.grid.find_chunks_in(around):
            for number, region in load_split_objects(bodies, bodies.grid.chunks[near]):
                labels[region.cut_out(chunk.core)] = number
    if labels.any():
        write_window(path, chunk.core, labels)


def write_body_surfaces(bodies: ChunkedBodies, path: Path, draft: Path, _: Compute) -> None:
    """Write the surfaces of all bodies, chunk by chunk; triangles of neighboring chunks have the same corners."""
    task, grid = bodies.volume.task, bodies.grid
    levels = task.source.levels
    facts = describe_image_provenance(levels.name, build_provenance(task))
    notes = (PROGRAM_NAME, "SPACE=LPS", f"UNIT={ascii_unit(levels.unit, 'voxel')}", dump_provenance(facts))
    names, faces = [], 0
    shells: list[tuple[Index, int, int]] = []
    with draft.with_suffix(".vertices").open("w+b") as vertices, draft.open("wb") as file:
        for chunk in grid.chunks:
            own, places, corners, _bodies = bodies.load_triangles(chunk.number)
            vertices.write(to_file_coordinates(places.astype(float), levels.spacing, None).astype("<f4").tobytes())
            names.append(own)
            faces += len(corners)
        firsts = np.cumsum([0, *map(len, names)])
        count = int(firsts[-1])
        for chunk in grid.chunks:
            for number, region in load_split_objects(bodies, chunk):
                shell = region.find_surface()
                vertices.write(to_file_coordinates(shell.vertices, levels.spacing, None).astype("<f4").tobytes())
                shells.append((shell.faces, count, number))
                count, faces = count + len(shell.vertices), faces + len(shell.faces)
        file.write(ply.format_ply_header(notes, count, faces, numbered=True))
        vertices.seek(0)
        while some := vertices.read(2**24):
            file.write(some)
        for chunk in grid.chunks:
            near = [at for at in grid.find_neighbors(chunk) if at >= chunk.number]
            known = np.concatenate([names[at] for at in near])
            index = np.concatenate([firsts[at] + np.arange(len(names[at])) for at in near])
            order = np.argsort(known)
            _own, _places, corners, numbers = bodies.load_triangles(chunk.number)
            found = index[order][np.searchsorted(known, corners, sorter=order)]
            file.write(ply.encode_ply_triangles(found[:, ::-1], numbers))  # reversing the axes mirrors them
        for corners, first, number in shells:
            file.write(ply.encode_ply_triangles(corners[:, ::-1] + first, np.full(len(corners), number)))
    draft.with_suffix(".vertices").unlink()


def write_body_table(bodies: ChunkedBodies, path: Path, draft: Path, _: Compute) -> None:
    """Write a table, with a row for each body, lengths in the unit of the volume where it has one."""
    levels = bodies.volume.task.source.levels
    unit = levels.unit or ""
    columns = {
        "label": bodies.table["label"],
        name_column("volume", unit and f"{unit}³"): bodies.table["volume"],
        name_column("area", unit and f"{unit}²"): bodies.table["area"],
    }
    if "confidence" in bodies.table:
        columns["confidence"] = bodies.table["confidence"]
    for name, place, side in zip(("plane", "row", "col"), bodies.table["center"].T, levels.spacing, strict=True):
        columns[name_column(f"center_{name}", unit)] = place * side
    write_table_parts(path, draft, [columns])


WRITERS = {
    ".zarr": write_label_volume,
    ".ply": write_body_surfaces,
    **dict.fromkeys((".csv", ".parquet"), write_body_table),
}
"""Writers by suffix, with the interface of the writers of images."""
