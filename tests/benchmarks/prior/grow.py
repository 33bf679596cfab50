"""Growing of the weights of the prior, in the time that it is given.

``python tests/benchmarks/prior/grow.py OUT.npz --outlined FOLDER... --drawn FOLDER [--minutes 86] [--ranks 2]
[--seed 1]`` makes up the pools of scenes, which takes a quarter of an hour and two gigabytes of memory, and then
lets the network learn; it writes the weights every now and then, and at the end. Each of the folders after
``--outlined`` is a kind of images, with labels ``NAME_labels.png`` of images ``NAME.png`` or ``NAME.jpg``; that after
``--drawn`` holds drawings on transparent ground, such as those of Debian's ``openclipart-png``. What the weights of
the program were grown from is in `cpm_core/objects/prior/weights.md`.

As the rate of learning follows the time, not the steps, no two runs give the same weights; the pools, the weights at
the beginning and the first examples of each rank are the same for the same seed.

It needs ``torch`` and ``opencv-python-headless`` besides what `cpm_core` needs.
"""

from __future__ import annotations

import argparse
import copy
import math
import multiprocessing
import random
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import Tensor, distributed, nn
from torch.nn import functional

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from tests.benchmarks.prior.network import UNet, weights
from tests.benchmarks.prior.pictures import Example, outlined
from tests.benchmarks.prior.pools import pools
from tests.benchmarks.prior.prompts import Chance, Prompt, View, first_prompt, view

SHARES = {"people": 0.34, "regions": 0.13, "made_up": 0.13, "drawn": 0.28, "nested": 0.12}
"""How often an example is one that people have outlined, or comes from one of the pools."""

BATCH = 16
CORRECTIONS = (0, 0, 1, 2, 3)
"""Numbers of corrections before the network is taught, each as likely as the others."""

FASTEST, WARM_UP = 2.5e-3, 150
"""The largest rate of learning, and the steps until it is reached."""

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
    minutes : float
        Time for learning.
    ranks : int
        Processes that learn together, each from examples of its own.
    seed : int
        What all random numbers but those of the pools depend on.
    """

    out: Path
    minutes: float
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
        """One of them; of the kinds that people have outlined the larger ones come more often."""
        source = plain.choices(list(SHARES), list(SHARES.values()))[0]
        if source != "people":
            return plain.choice(self.made[source])
        counts = [math.sqrt(len(examples)) for examples in self.people.values()]
        return plain.choice(self.people[plain.choices(list(self.people), counts)[0]])


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
    chance = Chance(growth.seed * 10 + rank)
    network = UNet().to(memory_format=torch.channels_last)
    mean = copy.deepcopy(network)
    optimizer = torch.optim.AdamW(network.parameters(), lr=FASTEST, weight_decay=1e-3)
    began, step, share, told = time.monotonic(), 0, 0.0, []
    while share < 1:
        for group in optimizer.param_groups:
            group["lr"] = _rate(step, share)
        loss, overlap = _loss(network, *_corrected_batch(network, examples, chance))
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
            _write(mean, growth.out)


def _rate(step: int, share: float) -> float:
    """Rate of learning at a step, after a share of the time: it rises at first, and falls as a cosine does."""
    return FASTEST * (0.02 + 0.98 * 0.5 * (1 + math.cos(math.pi * share))) * min(1, (step + 1) / WARM_UP)


def _corrected_batch(network: UNet, examples: Examples, chance: Chance) -> tuple[list[View], list[Prompt]]:
    """Views with prompts, after as many answers of the network have been corrected as a robot user likes."""
    views: list[View] = []
    prompts: list[Prompt] = []
    while len(views) < BATCH:
        seen = view(examples.pick(chance.plain), chance)
        if seen is not None:
            views.append(seen)
            prompts.append(first_prompt(seen, chance))
    as_mask = chance.plain.random() < 0.5
    network.eval()
    for _ in range(chance.plain.choice(CORRECTIONS)):
        with torch.no_grad():
            logits, _ = _answers(network, views, prompts)
        for seen, prompt, probability in zip(views, prompts, torch.sigmoid(logits).numpy(), strict=True):
            answer = probability > 0.5
            prompt.correct(answer, seen.mask, chance)
            prompt.former = answer.astype(np.float32) if as_mask else probability
    network.train()
    return views, prompts


def _answers(network: UNet, views: Sequence[View], prompts: Sequence[Prompt]) -> tuple[Tensor, Tensor]:
    """Logits of the pixels and of the overlaps."""
    maps = np.stack([prompt.maps(seen.values) for seen, prompt in zip(views, prompts, strict=True)])
    with torch.autocast("cpu", torch.bfloat16):
        logits, overlaps = network(torch.from_numpy(maps).to(memory_format=torch.channels_last))
    return logits.float(), overlaps.float()


def _loss(network: UNet, views: Sequence[View], prompts: Sequence[Prompt]) -> tuple[Tensor, Tensor]:
    """What is minimized, and the mean overlap of the answers with the objects."""
    logits, estimates = _answers(network, views, prompts)
    truth = torch.from_numpy(np.stack([seen.mask for seen in views]).astype(np.float32))
    areas = torch.tensor([float(seen.area) for seen in views])
    pixels = (1, 2)
    probability = torch.sigmoid(logits)
    common = (probability * truth).sum(pixels)
    soft_overlap = common / ((probability + truth - probability * truth).sum(pixels) + 1)
    answer = (logits > 0).float()
    # what the window cuts off counts as missing, so that a window that shows an object whole promises more
    union = torch.maximum(answer, truth).sum(pixels) + areas - truth.sum(pixels) + 1
    overlap = ((answer * truth).sum(pixels) / union).detach()
    off = ((torch.sigmoid(estimates) - overlap) ** 2).mean()
    entropy = functional.binary_cross_entropy_with_logits(logits, truth)
    return entropy + (1 - soft_overlap).mean() + OVERLAP_COUNTS * off, overlap.mean()


def _exchanged(parameters: Sequence[nn.Parameter], share: float, ranks: int) -> float:
    """Mean share of the time over all ranks, so that they end together; gradients become their means."""
    everything = torch.cat([*(parameter.grad.flatten() for parameter in parameters), torch.tensor([share])])
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


def _write(network: UNet, out: Path) -> None:
    """Write the weights; a run that ends meanwhile leaves the former ones as they are."""
    part = out.with_name(out.name + ".part")
    with part.open("wb") as file:
        np.savez_compressed(file, **weights(network))
    part.replace(out)


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the pools, and let all ranks learn."""
    parser = argparse.ArgumentParser(description="Grow the weights of the prior.")
    parser.add_argument("out", type=Path, metavar="OUT.npz", help="file of the weights")
    parser.add_argument("--outlined", type=Path, nargs="+", required=True, metavar="FOLDER", help="labeled images")
    parser.add_argument("--drawn", type=Path, required=True, metavar="FOLDER", help="drawings on transparent ground")
    parser.add_argument("--minutes", type=float, default=86.0, help="time for learning (default: %(default)s)")
    parser.add_argument("--ranks", type=int, default=2, help="processes that learn together (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the learning (default: %(default)s)")
    chosen = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    growth = Growth(chosen.out, chosen.minutes, chosen.ranks, chosen.seed)
    examples = Examples(outlined(chosen.outlined, random.Random(chosen.seed)), pools(chosen.outlined, chosen.drawn))
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
