"""Examples of each command, which its help ends with."""

from __future__ import annotations

EXAMPLES: dict[str, tuple[tuple[str, str], ...]] = {
    "run": (
        ("from a circle, with the contours as a drawing", "cpm run cell.png --circle 120,80,30 --export cell.svg"),
        ("each page of a stack, from everywhere", "cpm run stack.tif --pages all --auto grid --export stack.csv"),
        ("from the contours of another program", "cpm run cell.png --start cell.roi --save-session cell.cpm"),
    ),
    "batch": (
        ("a folder, as a session says", "cpm batch images --session cell.cpm --output found"),
        ("some files, on two processors", 'cpm batch "images/*.png" --session cell.cpm --output found --workers 2'),
    ),
    "export": (
        ("what a session shows, for ImageJ and QuPath", "cpm export cell.cpm --to cell.zip cell.geojson"),
        ("a figure for a publication", "cpm export cell.cpm --to cell.figure.pdf"),
        ("from one format to another", "cpm export cell.svg --image cell.png --to cell.coco.json"),
        ("a surface of a volume as labels", "cpm export tree.ply --image angio.nii --to tree.nii.gz"),
    ),
    "skeleton": (
        ("the middle lines of dark vessels", "cpm skeleton retina.png --of dark --export vessels.svg"),
        ("center lines in a volume", "cpm skeleton angio.nii --volume --export tree.swc"),
    ),
    "compare": (
        ("all methods from one circle", "cpm compare cell.png --circle 120,80,30 --truth cell_mask.png"),
        ("two of them, as a table", "cpm compare cell.png --circle 120,80,30 --methods cpm gvf --export table.csv"),
        ("surfaces in a volume", "cpm compare angio.nii --sphere 20,64,64,4 --truth vessels.nii --export angio.ply"),
    ),
    "info": (
        ("what a file holds", "cpm info stack.tif"),
        ("all images of a folder, for a script", "cpm info images --json"),
    ),
    "bench": (
        ("how fast it is here", "cpm bench"),
        ("the same in a few seconds, for a script", "cpm bench --quick --json"),
    ),
    "completion": (
        ("for bash, in the file that it reads at its start", 'eval "$(cpm completion bash)"'),
        ("for fish, once", "cpm completion fish > ~/.config/fish/completions/cpm.fish"),
    ),
}
"""Command -> what an example does, and its line."""

_HEAD = "Examples:"


def text_of(command: str) -> str:
    """The end of the help of a command."""
    lines = [f"  {line}\n      {what}" for what, line in EXAMPLES[command]]
    return "\n".join([_HEAD, *lines])


def is_examples(text: str) -> bool:
    """Whether a text of the help keeps its lines as they are."""
    return text.startswith(_HEAD)
