"""Growing of the weights of the prior, in the time that it is given.

``python tests/benchmarks/prior/grow.py OUT.npz --outlined FOLDER... --drawn FOLDER... [--start WEIGHTS.npz]
[--keep 0.3] [--minutes 86] [--fastest 0.0025] [--ranks 2] [--seed 1]`` makes up the pools of scenes, which takes up to
half an hour and four gigabytes of memory, and then lets the network learn, on a GPU where there is one, from random
weights or on from those of a file. Each of the folders after ``--outlined`` is a kind of images, with labels
``NAME_labels.png`` of images ``NAME.png`` or ``NAME.jpg``; those after ``--drawn`` hold drawings on transparent ground,
such as those of Debian's ``openclipart-png``. What the weights of the program were grown from is in
`cpm_core/objects/prior/weights.md`.

It writes the weights every now and then, with all that it needs to go on in ``OUT.checkpoint``, and the pools in
``OUT.pools``: the same command goes on after an interruption, and begins anew once these files are gone.

As the rate of learning follows the time, not the steps, no two runs give the same weights; the pools, the weights at
the beginning and the first examples of each rank are the same for the same seed.

It needs ``torch`` and ``opencv-python-headless`` besides what `cpm_core` needs.
"""

from __future__ import annotations

import argparse
import copy
import math
import multiprocessing
import pickle
import random
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, distributed, nn
from torch.nn import functional

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from tests.benchmarks.prior.network import UNet, restore, weights
from tests.benchmarks.prior.pictures import Example, outlined
from tests.benchmarks.prior.pools import pools
from tests.benchmarks.prior.prompts import Chance, Prompt, View, close_correction, first_prompt, view

SHARES = {
    "people": 0.43,
    "regions": 0.05,
    "made_up": 0.06,
    "drawn": 0.12,
    "nested": 0.06,
    "thin": 0.045,
    "tiled": 0.045,
    "tissue": 0.04,
    "radiographs": 0.07,
    "micrographs": 0.05,
    "sonograms": 0.03,
}
"""How often an example is one that people have outlined, or comes from one of the pools."""

CLOSE_SHARE = 0.25
"""How often a detail of the example is corrected in a window of its own, if it has any."""

BATCH = 16
CORRECTIONS = (0, 0, 0, 1, 2, 3)
"""Numbers of corrections before the network is taught, each as likely as the others."""

WARM_UP = 150
"""Steps until the largest rate of learning is reached."""

SEEN_BEFORE = 8
"""Batches by which stored weights are made ready to learn on."""

DEVICE = torch.device("cuda" if torch.cuda.is_available() else "cpu")

HALF_IS_FASTER = DEVICE.type == "cuda" or torch.cpu._is_avx512_bf16_supported()
"""Whether products of half precision take less time here: an eighth on a GPU, half on a processor that has them."""

LONGEST_GRADIENT = 2.0
OVERLAP_COUNTS = 0.3
"""Share of the estimate of the overlap in what is minimized."""

SLOWNESS = 0.998
"""How much of the mean of the weights, which is what is written, stays at each step."""

TOLD_EVERY, WRITTEN_EVERY = 100, 250


@dataclass(frozen=True)
class Growth:
    """What a run is asked for.

    Attributes
    ----------
    out : Path
        File of the weights.
    start : Path, optional
        File of the weights to learn on from; random ones if None.
    keep : float
        Share of those weights in what is written: a mean of before and after serves kinds that are new better than
        either (Wortsman et al. 2022, arXiv:2109.01903).
    minutes : float
        Time for learning.
    fastest : float
        Largest rate of learning.
    ranks : int
        Processes that learn together, each from examples of its own.
    seed : int
        What all random numbers but those of the pools depend on.
    """

    out: Path
    start: Path | None
    keep: float
    minutes: float
    fastest: float
    ranks: int
    seed: int


@dataclass(frozen=True, eq=False)
class Examples:
    """What is learned from.

    Attributes
    ----------
    people : dict of str to list of Example
        Objects that people have outlined, by kind.
    made : dict of str to list of Example
        Pools of scenes.
    """

    people: dict[str, list[Example]]
    made: dict[str, list[Example]]

    def pick(self, plain: random.Random) -> Example:
        """One of them; all kinds that people have outlined come equally often."""
        source = plain.choices(list(SHARES), list(SHARES.values()))[0]
        if source != "people":
            return plain.choice(self.made[source])
        return plain.choice(self.people[plain.choice(list(self.people))])


def grow(rank: int, growth: Growth, examples: Examples, meeting: Path | None = None) -> None:
    """Let one rank learn; the first one tells how it goes and writes the weights.

    Parameters
    ----------
    rank : int
        Its number.
    growth : Growth
        What is asked for.
    examples : Examples
        What is learned from.
    meeting : Path, optional
        File by which several ranks find one another.
    """
    if meeting is not None:
        store = distributed.FileStore(str(meeting), growth.ranks)
        distributed.init_process_group("gloo", store=store, rank=rank, world_size=growth.ranks)
    torch.set_num_threads(1)
    torch.manual_seed(growth.seed)
    network = UNet().to(DEVICE, memory_format=torch.channels_last)
    optimizer = torch.optim.AdamW(network.parameters(), lr=growth.fastest, weight_decay=1e-3)
    checkpoint = growth.out.with_suffix(".checkpoint")
    step, share = 0, 0.0
    if checkpoint.exists():
        stored = torch.load(checkpoint, map_location=DEVICE)
        step, share = stored["step"], stored["share"]
        network.load_state_dict(stored["network"])
        optimizer.load_state_dict(stored["optimizer"])
    chance = Chance(growth.seed * 10 + rank + 1000 * step)
    if growth.start is not None and step == 0:
        batches = [_corrected_batch(network, examples, chance, 0) for _ in range(SEEN_BEFORE)]
        with np.load(growth.start) as file:
            restore(network, file, [_maps(*batch) for batch in batches])
    mean = copy.deepcopy(network)
    if step:
        mean.load_state_dict(stored["mean"])
    began, told = time.monotonic() - share * growth.minutes * 60, []
    while share < 1:
        for group in optimizer.param_groups:
            group["lr"] = growth.fastest * _rate(step, share)
        corrections = chance.plain.choice(CORRECTIONS)
        loss, overlap = _loss(network, *_corrected_batch(network, examples, chance, corrections))
        optimizer.zero_grad()
        loss.backward()
        share = (time.monotonic() - began) / (growth.minutes * 60)
        if growth.ranks > 1:
            share = _exchanged(list(network.parameters()), share, growth.ranks)
        nn.utils.clip_grad_norm_(network.parameters(), LONGEST_GRADIENT)
        optimizer.step()
        step += 1
        _follow(mean, network, step)
        told.append((loss.item(), overlap.item()))
        if rank == 0 and step % TOLD_EVERY == 0:
            figures = np.mean(told[-TOLD_EVERY:], axis=0)
            print(f"{step} steps, {share:.0%} of the time: loss {figures[0]:.3f}, overlap {figures[1]:.3f}", flush=True)
        if rank == 0 and (step % WRITTEN_EVERY == 0 or share >= 1):
            with _replacing(growth.out) as file:
                np.savez_compressed(file, **_kept(weights(mean), growth))
            parts = {"network": network, "mean": mean, "optimizer": optimizer}
            states = {name: part.state_dict() for name, part in parts.items()}
            with _replacing(checkpoint) as file:
                torch.save(states | {"step": step, "share": share}, file)


def _rate(step: int, share: float) -> float:
    """Share of the largest rate of learning: it rises with the first steps, and falls as a cosine of the time."""
    return (0.02 + 0.98 * 0.5 * (1 + math.cos(math.pi * share))) * min(1, (step + 1) / WARM_UP)


def _corrected_batch(
    network: UNet, examples: Examples, chance: Chance, corrections: int
) -> tuple[list[View], list[Prompt]]:
    """Views with prompts, after a robot user has corrected so many answers of the network."""
    views: list[View] = []
    prompts: list[Prompt] = []
    while len(views) < BATCH:
        example = examples.pick(chance.plain)
        corrected = close_correction(example, chance) if chance.plain.random() < CLOSE_SHARE else None
        seen, prompt = corrected or (view(example, chance), None)
        if seen is not None:
            views.append(seen)
            prompts.append(prompt or first_prompt(seen, chance))
    as_mask = chance.plain.random() < 0.5
    network.eval()
    for _ in range(corrections):
        with torch.no_grad():
            logits, _ = _answers(network, views, prompts)
        for seen, prompt, probability in zip(views, prompts, torch.sigmoid(logits[:, 0]).cpu().numpy(), strict=True):
            answer = probability > 0.5
            prompt.correct(answer, seen.mask, chance)
            prompt.former = answer.astype(np.float32) if as_mask else probability
    network.train()
    return views, prompts


def _answers(network: UNet, views: Sequence[View], prompts: Sequence[Prompt]) -> tuple[Tensor, Tensor]:
    """Logits of the pixels and of the overlaps."""
    with torch.autocast(DEVICE.type, torch.bfloat16, enabled=HALF_IS_FASTER):
        logits, overlaps = network(_maps(views, prompts))
    return logits.float(), overlaps.float()


def _maps(views: Sequence[View], prompts: Sequence[Prompt]) -> Tensor:
    """What the network sees."""
    maps = np.stack([prompt.maps(seen.values) for seen, prompt in zip(views, prompts, strict=True)])
    return torch.from_numpy(maps).to(DEVICE, memory_format=torch.channels_last)


def _loss(network: UNet, views: Sequence[View], prompts: Sequence[Prompt]) -> tuple[Tensor, Tensor]:
    """What is minimized, and the mean overlap of the answers with the objects."""
    logits, estimates = _answers(network, views, prompts)
    truth = torch.from_numpy(np.stack([seen.mask for seen in views]).astype(np.float32)).to(DEVICE)[:, None]
    areas = torch.tensor([[float(seen.area)] for seen in views], device=DEVICE)
    pixels = (2, 3)
    probability = torch.sigmoid(logits)
    common = (probability * truth).sum(pixels)
    soft_overlap = common / ((probability + truth - probability * truth).sum(pixels) + 1)
    answer = (logits > 0).float()
    # what the window cuts off counts as missing, so that a window that shows an object whole promises more
    union = torch.maximum(answer, truth).sum(pixels) + areas - truth.sum(pixels) + 1
    overlap = ((answer * truth).sum(pixels) / union).detach()
    entropy = functional.binary_cross_entropy_with_logits(logits, truth.expand_as(logits), reduction="none")
    shape = entropy.mean(pixels) + 1 - soft_overlap
    off = (torch.sigmoid(estimates) - overlap) ** 2
    loss = (shape + OVERLAP_COUNTS * off)[:, 0].mean()
    is_first = torch.tensor([not prompt.former.any() for prompt in prompts], device=DEVICE)
    if is_first.any():
        # of answers to what means several objects only the best one learns its shape (Guzman-Rivera et al. 2012)
        several = shape[is_first, 1:].min(1).values.mean()
        several = several + OVERLAP_COUNTS * off[is_first, 1:].mean()
        loss = loss + is_first.float().mean() * several
    return loss, overlap[:, 0].mean()


def _exchanged(parameters: Sequence[nn.Parameter], share: float, ranks: int) -> float:
    """Mean share of the time over all ranks, so that they end together; gradients become their means."""
    everything = torch.cat([*(parameter.grad.flatten().cpu() for parameter in parameters), torch.tensor([share])])
    distributed.all_reduce(everything)
    everything /= ranks
    parts = everything[:-1].split([parameter.numel() for parameter in parameters])
    for parameter, part in zip(parameters, parts, strict=True):
        parameter.grad.copy_(part.view_as(parameter))
    return float(everything[-1])


def _follow(mean: UNet, network: UNet, step: int) -> None:
    """Bring the mean of the weights nearer to those of a step; the first steps count as much as in a plain mean."""
    stays = min(SLOWNESS, 1 - 1 / (step + 1))
    for average, value in zip(mean.state_dict().values(), network.state_dict().values(), strict=True):
        if value.dtype.is_floating_point:
            average.mul_(stays).add_(value, alpha=1 - stays)


def _kept(grown: dict[str, NDArray[np.float16]], growth: Growth) -> dict[str, NDArray[np.float16]]:
    """Weights with the share of those before that is kept."""
    if growth.start is None:
        return grown
    with np.load(growth.start) as former:
        return {name: np.float16(growth.keep * former[name] + (1 - growth.keep) * each) for name, each in grown.items()}


@contextmanager
def _replacing(path: Path) -> Iterator[IO[bytes]]:
    """A file for writing that takes its place once it is whole: a run that ends meanwhile leaves the former one."""
    part = path.with_name(path.name + ".part")
    with part.open("wb") as file:
        yield file
    part.replace(path)


def _pools(growth: Growth, outlined: Sequence[Path], drawn: Sequence[Path]) -> dict[str, list[Example]]:
    """The pools, from a file if they were made before."""
    path = growth.out.with_suffix(".pools")
    if not path.exists():
        with _replacing(path) as file:
            pickle.dump(pools(outlined, drawn), file)
    with path.open("rb") as file:
        return pickle.load(file)


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the pools, and let all ranks learn."""
    parser = argparse.ArgumentParser(description="Grow the weights of the prior.")
    parser.add_argument("out", type=Path, metavar="OUT.npz", help="file of the weights")
    parser.add_argument("--outlined", type=Path, nargs="+", required=True, metavar="FOLDER", help="labeled images")
    parser.add_argument("--drawn", type=Path, nargs="+", required=True, metavar="FOLDER", help="transparent drawings")
    parser.add_argument("--start", type=Path, metavar="WEIGHTS.npz", help="weights to learn on from")
    parser.add_argument("--keep", type=float, default=0.3, help="their share in what is written (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=86.0, help="time for learning (default: %(default)s)")
    parser.add_argument("--fastest", type=float, default=2.5e-3, help="rate of learning (default: %(default)s)")
    parser.add_argument("--ranks", type=int, default=2, help="processes that learn together (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the learning (default: %(default)s)")
    chosen = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    growth = Growth(chosen.out, chosen.start, chosen.keep, chosen.minutes, chosen.fastest, chosen.ranks, chosen.seed)
    people = outlined(chosen.outlined, random.Random(chosen.seed))
    examples = Examples(people, _pools(growth, chosen.outlined, chosen.drawn))
    counts = {name: len(found) for name, found in (examples.people | examples.made).items()}
    print(", ".join(f"{count} {name}" for name, count in counts.items()), flush=True)
    if growth.ranks == 1:
        grow(0, growth, examples)
        return
    context = multiprocessing.get_context("fork")  # the ranks share the memory of the pools
    with tempfile.TemporaryDirectory() as folder:
        meeting = Path(folder) / "meeting"
        ranks = [context.Process(target=grow, args=(rank, growth, examples, meeting)) for rank in range(growth.ranks)]
        for process in ranks:
            process.start()
        for process in ranks:
            process.join()
    if any(process.exitcode for process in ranks):
        sys.exit("A rank has failed; what it said is above.")


if __name__ == "__main__":
    main()
