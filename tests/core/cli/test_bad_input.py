"""Bad input of every command is one line on standard error with exit status 2, and nothing is written."""

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.shapes import Circle, Sphere

CIRCLE, SPHERE = "--circle 40,50,12", "--sphere 9.5,9.5,9.5,3"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bad")
    row, col = np.mgrid[:80, :100]
    disk = (220 * np.clip(18.5 - np.hypot(row - 40, col - 50), 0, 1)).astype(np.uint8)
    ball = 200.0 * (np.linalg.norm(np.indices((20, 20, 20)) - 9.5, axis=0) < 6)
    PIL.Image.fromarray(disk).save(folder / "disk.png")
    PIL.Image.new("L", (40, 40), 9).save(folder / "flat.png")
    (folder / "text.png").write_text("no picture", encoding="utf-8")
    (folder / "link.png").symlink_to(folder / "disk.png")
    np.save(folder / "ball.npy", ball)
    tifffile.imwrite(
        folder / "stack.tif", np.stack([disk, np.full_like(disk, 7)]), imagej=True, metadata={"axes": "TYX"}
    )
    save_session(SessionFile(ImageFile("disk.png"), (Circle((40.0, 50.0), 12.0),)), folder / "own.cpm")
    save_session(SessionFile(ImageFile("gone.png"), (Circle((1.0, 1.0), 2.0),)), folder / "lost.cpm")
    save_session(SessionFile(shapes=(Sphere((8.0, 9.0, 9.0), 4.0),)), folder / "space.cpm")
    save_session(SessionFile(ImageFile("disk.png"), mode="skeleton"), folder / "bones.cpm")
    (folder / "line.svg").write_text('<svg viewBox="0 0 60 56"><polyline points="1,1 9,5 3,9"/></svg>')
    return folder


BAD = [
    ("fly disk.png", "fly"),
    ("run disk.png", "No start"),
    ("run text.png --circle 40,50,12", "of an unknown kind"),
    ("run disk.png --object 9,9,9", "add --volume"),
    (f"run disk.png {CIRCLE} --cicle 1,2,3", "cpm run has no option --cicle: did you mean --circle?"),
    (f"run disk.png {CIRCLE} --preset shpae", "did you mean shape?"),
    (f"run disk.png {CIRCLE} --edges vesels", "did you mean vessels?"),
    (f"run disk.png {CIRCLE} --export out.svgg", "did you mean .svg?"),
    (f"run disk.png {CIRCLE} --export -", "- alone names no format"),
    (f"run disk.png {CIRCLE} --export -.csv -.svg", "Standard output can take one file"),
    (f"run own.cpm --session lost.cpm {CIRCLE}", "own.cpm is a session, and --session names one as well"),
    (f"run disk.png other.png {CIRCLE}", '"other.png" is one argument too many'),
    ("run disk.png --xy --circle 1,2", "numbers between commas, X,Y,RADIUS"),
    (f"run disk.png {CIRCLE} --beta much", 'beta is "much"'),
    (f"run disk.png {CIRCLE} --beta 9", "from 0 to 4"),
    (f"run disk.png {CIRCLE} --max-steps 0", '"0" must be a whole number of at least 1'),
    ("run disk.png --circle 1,2", '--circle is "1,2" but must be numbers between commas, ROW,COL,RADIUS'),
    (f"run disk.png {CIRCLE} --region 900,900,990,990,900,990", "region of interest 1"),
    (f"run disk.png {CIRCLE} --export out.xyz", "out.xyz"),
    (f"run disk.png {CIRCLE} --save-session a.json", "must end in .cpm"),
    ("run disk.png --object 30,170", "lies outside the image, which has 80 x 100 px"),
    ("run disk.png --not 1,2 --auto grid", "--not or --and is given without --object"),
    ("run disk.png --object 40,50 --and --not 1,2", "--not or --and is given without --object"),
    ("run disk.png --object 40,50 --and --larger 1", "--larger is given before a place"),
    ("run disk.png --object 40,50 --larger 1.5", '--larger is "1.5" but must be a whole number of sizes'),
    ("run disk.png --pick 9", "--pick names object 9, but the run has 1 object"),
    (f"run disk.png {CIRCLE} --space RAS", "--space is for volumes"),
    ("run --session lost.cpm", "gone.png"),
    ("run --session bones.cpm", "cpm skeleton"),
    ("run disk.png --session space.cpm", "shape 1 (sphere) is for volumes"),
    (f"run stack.tif {CIRCLE} --pages 0", "--pages names page 0, but stack.tif has 2 pages"),
    (f"run stack.tif {CIRCLE} --pages 1,2,1", "lists a page twice"),
    ("run stack.tif --pages all --follow --objects --object 9,9", "--object is for one object"),
    (f"run stack.tif {CIRCLE} --pages all --export a.svg", "names no format for all pages of a stack"),
    (f"run ball.npy {SPHERE} {CIRCLE}", "--circle is for images"),
    (f"run ball.npy {SPHERE} --export a.svg", "a.svg is for contours"),
    (f"run ball.npy {SPHERE} --page 3", "a volume uses all pages"),
    (f"run ball.npy {SPHERE} --barrier 1,2,3,0,0,0", "the direction across barrier 1 is"),
    (f"run disk.png {SPHERE}", "has the shape (80, 100)"),
    ("info none.png --json", "does not exist"),
    ("info ball.npy --pixel-size 1..2mm", "must be one to three sizes"),
    ("info *.none", "No file is named like"),
    ("batch disk.png --session own.cpm --output out --export doc", '".doc"'),
    ("batch disk.png --session own.cpm --output disk.png", "--output"),
    ("batch disk.png --session bones.cpm --output out", "has no start"),
    ("skeleton ball.npy --volume --export a.svg", "which --volume and a .swc file ask for"),
    ("compare disk.png", "No start is given"),
    (f"compare disk.png {CIRCLE} --methods gfv", "random_walker: did you mean gvf?"),
    (
        f"compare disk.png {CIRCLE} --set geodesic.baloon=1",
        "a setting of geodesic must be one of balloon",
    ),
    ("compare disk.png --start line.svg", "has no closed contour"),
    ("export own.cpm --to a.json --page 1", "--page is for contours in a stack"),
    *(
        (line, "would overwrite a file that is read")
        for line in (
            f"run disk.png {CIRCLE} --export ../{{folder}}/disk.png",
            "run --session own.cpm --export disk.png",
            f"run stack.tif {CIRCLE} --pages all --export stack.tif",
            "skeleton disk.png --within flat.png --export flat.png",
        )
    ),
]


@pytest.mark.parametrize(("line", "words"), BAD)
def test_bad_input_is_one_line_on_standard_error_and_nothing_is_written(folder, command, monkeypatch, line, words):
    monkeypatch.chdir(folder)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    status, out, err = command(*line.format(folder=folder.name).split())
    assert (status, out) == (2, "")
    assert err.startswith("cpm: ")
    assert err.count("\n") == 1
    assert words in err
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
