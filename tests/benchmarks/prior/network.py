"""The network while it learns, and its weights as `cpm_core/objects/prior/network.py` reads them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from tests.benchmarks.prior.prompts import MAPS

WIDTHS = (16, 32, 64, 96, 128)
"""Maps at each resolution, the finest first."""

_HIDDEN = 32
"""Values between the coarsest maps and the estimates of the overlaps."""

ANSWERS = 4
"""Answers at once: the first one to all prompts, the others to what means several objects before any correction."""

_LOGITS_APART = 1.5
"""What the answers differ by at first, if weights of a single one are learned on: a smaller object to a larger one."""


class Block(nn.Sequential):
    """A convolution of 3 x 3 pixels, normalized over the batch and rectified."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__(
            nn.Conv2d(inputs, outputs, 3, padding=1, bias=False),
            nn.BatchNorm2d(outputs, momentum=0.03),
            nn.ReLU(inplace=True),
        )


class UNet(nn.Module):
    """The network; its parts have the names that they have in the file of the weights."""

    def __init__(self) -> None:
        super().__init__()
        coarsest = WIDTHS[-1]
        self.down = nn.ModuleList([nn.Sequential(Block(MAPS, WIDTHS[0]))])
        self.down.extend(nn.Sequential(Block(finer, width), Block(width, width)) for finer, width in pairwise(WIDTHS))
        self.context = nn.Conv2d(coarsest, coarsest, 1)
        self.overlap = nn.ModuleList([nn.Linear(2 * coarsest, _HIDDEN), nn.Linear(_HIDDEN, ANSWERS)])
        levels = range(len(WIDTHS) - 2, -1, -1)
        self.mix = nn.ModuleDict({str(level): nn.Conv2d(WIDTHS[level + 1], WIDTHS[level], 1) for level in levels})
        self.up = nn.ModuleDict({str(level): _joined(level) for level in levels})
        self.out = nn.Conv2d(WIDTHS[0], ANSWERS, 1)

    def forward(self, maps: Tensor) -> tuple[Tensor, Tensor]:
        """Logits of each pixel, (B, ANSWERS, H, W), and of the overlaps, (B, ANSWERS), for maps (B, C, H, W)."""
        finer: list[Tensor] = []
        for level, blocks in enumerate(self.down):
            if level:
                finer.append(maps)
                maps = functional.max_pool2d(maps, 2)
            maps = blocks(maps)
        maps = maps + functional.relu(self.context(maps.mean((2, 3), keepdim=True)))
        summary = torch.cat([maps.mean((2, 3)), maps.amax((2, 3))], 1)
        overlap = self.overlap[1](functional.relu(self.overlap[0](summary)))
        for level, blocks in self.up.items():
            mixed = self.mix[level](maps)
            doubled = functional.interpolate(mixed, scale_factor=2, mode="bilinear", align_corners=False)
            maps = blocks(torch.cat([doubled, finer[int(level)]], 1))
        return self.out(maps), overlap


def restore(network: UNet, stored: Mapping[str, NDArray[np.float16]], seen: Sequence[Tensor]) -> None:
    """Give a network stored weights, to learn on from them.

    The stored ones hold the normalization within the convolutions. It is taken out again, by the mean and variance of
    each layer over maps `seen`, each of shape (B, C, H, W), so that the answers stay the same. Weights of a single
    answer become those of all, the others a little smaller or larger.
    """
    normalizations = {}
    for name, layer in network.named_modules():
        key = _stored_name(name)
        if key not in stored:
            continue
        matrix, offset = (torch.from_numpy(stored[each].astype(np.float32)) for each in (key, key + ".offset"))
        if len(offset) == 1:
            matrix, offset = matrix.repeat(ANSWERS, 1), offset.repeat(ANSWERS)
            if layer is network.out:
                offset[1:] += torch.linspace(-_LOGITS_APART, _LOGITS_APART, ANSWERS - 1)
        if isinstance(layer, Block):
            convolution, normalization = layer[0], layer[1]
            inputs = convolution.weight.shape[1]
            convolution.weight.data.copy_(matrix.unflatten(1, (3, 3, inputs)).permute(0, 3, 1, 2))
            normalization.bias.data.copy_(offset)
            normalization.running_var.fill_(1 - normalization.eps)
            normalizations[normalization] = []
        else:
            layer.weight.data.copy_(matrix.view_as(layer.weight))
            layer.bias.data.copy_(offset)

    def watch(layer: nn.Module, given: tuple[Tensor]) -> None:
        normalizations[layer].append(torch.stack([given[0].mean((0, 2, 3)), (given[0] ** 2).mean((0, 2, 3))]))

    hooks = [layer.register_forward_pre_hook(watch) for layer in normalizations]
    network.eval()
    with torch.no_grad():
        for maps in seen:
            network(maps)
        for layer, moments in normalizations.items():
            mean, square = torch.stack(moments).mean(0)
            layer.running_mean.copy_(mean)
            layer.running_var.copy_(square - mean**2)
            layer.weight.copy_(torch.sqrt(layer.running_var + layer.eps))
            layer.bias.add_(mean)
    for hook in hooks:
        hook.remove()


def _joined(level: int) -> nn.Sequential:
    """What follows where finer maps join again: two convolutions, only one at the two finest resolutions."""
    width = WIDTHS[level]
    blocks = [Block(2 * width, width)]
    if level >= 2:
        blocks.append(Block(width, width))
    return nn.Sequential(*blocks)


def weights(network: UNet) -> dict[str, NDArray[np.float16]]:
    """Matrices and offsets of all layers, with the normalization as a part of the convolutions."""
    found = {}
    inner = {layer for block in network.modules() if isinstance(block, Block) for layer in block}
    for name, layer in network.named_modules():
        if isinstance(layer, Block):
            convolution, normalization = layer[0], layer[1]
            factor = normalization.weight / torch.sqrt(normalization.running_var + normalization.eps)
            # rows, columns, maps: the order in which the products of the program want them
            matrix = (convolution.weight * factor[:, None, None, None]).permute(0, 2, 3, 1).flatten(1)
            offset = normalization.bias - normalization.running_mean * factor
        elif isinstance(layer, nn.Conv2d | nn.Linear) and layer not in inner:
            matrix, offset = layer.weight.flatten(1), layer.bias
        else:
            continue
        stored = _stored_name(name)
        found[stored], found[stored + ".offset"] = (
            part.detach().cpu().numpy().astype(np.float16) for part in (matrix, offset)
        )
    return found


def _stored_name(layer: str) -> str:
    """Name of a layer in the file of the weights."""
    return re.sub(r"^(down|mix|up)\.", r"\1", layer)
