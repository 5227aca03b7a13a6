#!/usr/bin/env python3
"""A data set of `tirtouch sweep run` in PyTorch: a small network that tells diameter and depth of an inclusion.

    tirtouch sweep run python/examples/dataset.toml -o out/dataset      # the data: about 10 minutes on 2 cores, 4 MB
    python python/examples/dataset.py out/dataset                       # learns and tells: 92 s of the processor

Needs numpy, matplotlib and torch (`pip install torch`); the class `Frames` reads every such data set whose images are
`png` or `npy`, of one or all loads. What it printed, of 195 phantoms (5 of 200 points do not fit into the phantom):

| 47 phantoms held out | rms error, mm | of always the mean, mm | ratio (95 %, bootstrap) | bias, mm |
|---|---|---|---|---|
| true_size_mm | 0.56 | 2.80 | 0.20 (0.14 to 0.26) | -0.05 ± 0.08 |
| true_depth_mm | 0.67 | 2.34 | 0.28 (0.22 to 0.37) | -0.09 ± 0.10 |

The middle column is the spread of the prior: an answer that looks at no frame is so far off. Of the phantoms that it
learnt from the network is 0.22 and 0.28 mm off, so it has learnt some of them by heart and would gain by more.
Phantoms all have an inclusion of 120 kPa on the axis, and one sensor: of another it says nothing. Its answers have no
intervals; `sbi_posterior.py` has. Figures depend a little on the build of torch.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import torch
from torch import nn

#: What is estimated, by its column of metadata.csv, mm.
WANTED = ("true_size_mm", "true_depth_mm")
#: Rows and columns of a block of pixels.
BLOCK = (3, 4)


class Frames(torch.utils.data.Dataset[tuple[torch.Tensor, torch.Tensor]]):
    """Frames of a part, ``train`` or ``test``, of a data set that ``tirtouch sweep run`` wrote.

    An item is one phantom: its frames, of all loads that the set keeps, as (loads, rows, columns), and its truth, as
    (columns of ``truth``). Frames of ``png`` are shares of full scale, those of ``npy`` radiance in W/(m^2 sr).
    """

    def __init__(self, folder: Path, part: str, truth: tuple[str, ...] = WANTED) -> None:
        self.folder = folder / part
        with open(self.folder / "metadata.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        phantoms: dict[str, list[dict[str, str]]] = {}
        for row in rows:
            phantoms.setdefault(row["row"], []).append(row)
        self.files = [
            [one["file_name"] for one in sorted(loads, key=lambda one: int(one["load"]))] for loads in phantoms.values()
        ]
        numbers = [[float(loads[0][column]) for column in truth] for loads in phantoms.values()]
        self.truth = torch.tensor(numbers, dtype=torch.float32)

    def __len__(self) -> int:
        return len(self.files)

    def __getitem__(self, number: int) -> tuple[torch.Tensor, torch.Tensor]:
        frames = np.stack([self._frame(self.folder / file) for file in self.files[number]])
        return torch.from_numpy(frames), self.truth[number]

    @staticmethod
    def _frame(file: Path) -> np.ndarray[Any, Any]:
        # matplotlib gives a PNG of 8 or 16 bits as shares of full scale.
        return np.load(file) if file.suffix == ".npy" else matplotlib.image.imread(file)


def all_of(data: Frames) -> tuple[torch.Tensor, torch.Tensor]:
    """A small set whole: frames (phantoms, loads, rows, columns), of blocks, and truth (phantoms, columns)."""
    frames, truth = zip(*(data[i] for i in range(len(data))), strict=True)
    # Means over blocks of pixels: light that tissue has spread has no finer detail, and training is ten times faster.
    return nn.functional.avg_pool2d(torch.stack(frames), BLOCK), torch.stack(truth)


def network(loads: int, outputs: int) -> nn.Module:
    """Two convolutions and a layer for the place of what they found: some twenty thousand weights."""
    layers: list[nn.Module] = []
    for before, after in ((loads, 16), (16, 32)):
        layers += [nn.Conv2d(before, after, 5, stride=2, padding=2), nn.BatchNorm2d(after), nn.ReLU()]
    layers += [nn.Flatten(), nn.Dropout(0.3), nn.LazyLinear(outputs)]
    return nn.Sequential(*layers)


def train(frames: torch.Tensor, truth: torch.Tensor, epochs: int) -> nn.Module:
    """A network that tells what is wanted, in units of its spread, from frames in units of theirs."""
    model = network(frames.shape[1], truth.shape[1])
    optimizer = torch.optim.AdamW(model.parameters(), lr=3e-3, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 3e-3, total_steps=epochs * (1 + (len(frames) - 1) // 32))
    model.train()
    for epoch in range(epochs):
        total = 0.0
        for batch in torch.randperm(len(frames)).split(32):
            # The sensor is the same when turned over, so each phantom may be too.
            turned = [axis for axis in (2, 3) if torch.rand(()) < 0.5]
            loss = nn.functional.mse_loss(model(frames[batch].flip(turned)), truth[batch])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total += loss.item() * len(batch)
        if (epoch + 1) % 50 == 0:
            print(f"epoch {epoch + 1}: {total / len(frames):.3f} of the mean square is left", flush=True)
    return model.eval()


def table(found: torch.Tensor, truth: torch.Tensor, guess: torch.Tensor, names: tuple[str, ...]) -> list[str]:
    """Errors on held-out phantoms against those of an answer that is always the mean of the training set."""
    random = np.random.default_rng(0)
    lines = ["| | rms error, mm | of always the mean, mm | ratio (95 %, bootstrap) | bias, mm |"]
    lines.append("|---|---|---|---|---|")
    for i, name in enumerate(names):
        ours, prior = (found[:, i] - truth[:, i]).numpy(), (guess[i] - truth[:, i]).numpy()
        picks = random.integers(0, len(ours), (2000, len(ours)))
        ratios = np.sqrt((ours[picks] ** 2).mean(1) / (prior[picks] ** 2).mean(1))
        low, high = np.quantile(ratios, [0.025, 0.975])
        ours_rms, prior_rms = np.sqrt((ours**2).mean()), np.sqrt((prior**2).mean())
        lines.append(
            f"| {name} | {ours_rms:.2f} | {prior_rms:.2f} | {ours_rms / prior_rms:.2f} ({low:.2f} to {high:.2f})"
            f" | {ours.mean():+.2f} ± {ours.std(ddof=1) / len(ours) ** 0.5:.2f} |"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="data set that `tirtouch sweep run` wrote")
    parser.add_argument("--epochs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0, help="of the network's weights and batches")
    arguments = parser.parse_args()
    torch.set_num_threads(min(2, torch.get_num_threads()))
    torch.manual_seed(arguments.seed)
    frames, truth = all_of(Frames(arguments.folder, "train"))
    test_frames, test_truth = all_of(Frames(arguments.folder, "test"))
    print(f"{len(frames)} phantoms to learn from, {len(test_frames)} held out, {tuple(frames.shape[1:])} each")
    middle, spread = truth.mean(0), truth.std(0)
    pixel, contrast = frames.mean(0), frames.std((0, 2, 3), keepdim=True)[0]
    model = train((frames - pixel) / contrast, (truth - middle) / spread, arguments.epochs)
    with torch.no_grad():
        found = model((test_frames - pixel) / contrast) * spread + middle
        seen = model((frames - pixel) / contrast) * spread + middle
    print("\n".join(table(found, test_truth, middle, WANTED)))
    print("of the phantoms it learnt from, rms mm:", ((seen - truth) ** 2).mean(0).sqrt().numpy().round(2))


if __name__ == "__main__":
    main()
