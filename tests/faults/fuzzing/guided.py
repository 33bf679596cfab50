"""Files again, guided by coverage: Atheris keeps damaged files that reach new lines of the readers, and damages those.

It takes over its process, so it runs in one of its own: ``python -m tests.faults.fuzzing.guided FOLDER SECONDS SEED``.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
import warnings
from pathlib import Path
from random import Random

from ..report import Budget, Report, asked_to_stop
from .inputs.mutations import WORDS, mutated
from .inputs.samples import samples
from .limits import failure_of, limit_memory

_SUFFIXES = (
    *(".png", ".tif", ".npy", ".csv", ".json", ".geojson", ".npz"),
    *(".nii", ".nii.gz", ".nrrd", ".mha", ".dcm", ".dat", ".roi", ".zip", ".svg", ".dxf"),
    *(".ply", ".stl", ".obj", ".vtk", ".swc"),
)
"""The first byte of an input chooses the name of the file; the others are its content."""

_PACKAGES = ("cpm_core.formats", "tifffile", "PIL", "nibabel")
_MEMORY = 12 * 2**30
_SLOW = 60
_LONGEST = 20_000
_ROUND = 600.0
"""Time after which a new process goes on: what decoders lose of memory is lost with the old one [s]."""


def part(budget: Budget) -> Report:
    """Run Atheris until the time is up; a process that dies is one failure, and another goes on from what it kept."""
    deadline, rounds, inputs = time.monotonic() + budget.seconds, 0, 0
    failures: dict[str, str] = {}
    _write_corpus(budget.folder)
    while (left := deadline - time.monotonic()) > 1.0 and not asked_to_stop():
        command = [sys.executable, "-m", __spec__.name, str(budget.folder), str(int(min(left, _ROUND)))]
        status, said = _ended([*command, str(budget.seed + rounds)])
        rounds += 1
        told = budget.folder / "told.json"
        if not told.exists():
            failures["start"] = f"Atheris did not start: {said.strip().splitlines()[-1:]}"
            break
        count, sentences = json.loads(told.read_text())
        told.unlink()
        inputs += count
        for place, sentence in sentences.items():
            failures.setdefault(place, sentence)
        if status and not asked_to_stop():
            failures.setdefault("end", f"the process ended with status {status}: {said[-800:]!r}")
    return Report(inputs, failures=tuple(failures.values()))


def _ended(command: list[str]) -> tuple[int, str]:
    """The status with which a process ends, which is told when this one is to stop, and what it said of errors."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as child:
        while True:
            try:
                said = child.communicate(timeout=1.0)[1]
                return child.returncode, said
            except subprocess.TimeoutExpired:
                if asked_to_stop():
                    child.terminate()


def _write_corpus(folder: Path) -> None:
    (folder / "corpus").mkdir(exist_ok=True)
    for number, (suffix, content) in enumerate(samples()):
        kind = _SUFFIXES.index(suffix) if suffix in _SUFFIXES else len(_SUFFIXES) - 1
        (folder / "corpus" / str(number)).write_bytes(bytes([kind]) + content)
    lines = ('"' + "".join(f"\\x{byte:02x}" for byte in word) + '"' for word in WORDS)
    (folder / "words").write_text("\n".join(lines) + "\n")


def _run(folder: Path, seconds: int, seed: int) -> None:
    """Fuzz in this process, which Atheris ends."""
    import atheris  # noqa: PLC0415  # an extra, which only this process needs

    with atheris.instrument_imports(include=list(_PACKAGES)):
        from .files import read  # noqa: PLC0415

    warnings.simplefilter("error")
    limit_memory(_MEMORY)
    count, told, random = 0, dict[str, str](), Random(seed)

    def tell() -> None:
        draft = folder / "draft.json"
        draft.write_text(json.dumps([count, told]))
        draft.replace(folder / "told.json")

    def attempt(data: bytes) -> None:
        nonlocal count
        count += 1
        if not count % 500:
            tell()
        if not data:
            return
        path = folder / f"file{_SUFFIXES[data[0] % len(_SUFFIXES)]}"
        path.write_bytes(data[1:])
        try:
            read(path)
        except BaseException as error:
            failure = failure_of(error)
            place = type(error).__name__ + failure.rpartition("[")[2]
            if place not in told:
                kept = folder.parent / f"cpm-failed-{seed}-{len(told)}{path.suffix}"
                kept.write_bytes(data[1:])
                told[place] = f"{failure}, by {kept}"
                tell()

    def change(data: bytes, most: int, _seed: int) -> bytes:
        if not data or random.random() < 0.3:
            return bytes(atheris.Mutate(data, most))
        return (data[:1] + mutated(data[1:], random))[:most]

    tell()
    options = ["-print_final_stats=0", "-verbosity=0", f"-max_total_time={seconds}", f"-seed={seed + 1}"]
    options += [f"-timeout={_SLOW}", "-rss_limit_mb=0", f"-max_len={_LONGEST}", f"-artifact_prefix={folder}/"]
    atheris.Setup(
        ["guided", *options, f"-dict={folder / 'words'}", str(folder / "corpus")], attempt, custom_mutator=change
    )
    with contextlib.suppress(SystemExit):
        atheris.Fuzz()
    tell()
    os._exit(0)


if __name__ == "__main__":
    _run(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
