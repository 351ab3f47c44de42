#!/usr/bin/env python3
"""The cases of network.rs in PyTorch, each repetition beside one of touchcal's: same shapes, threads, single precision, fused Adam.

    pip install torch==2.15.0 numpy==2.4.6
    cargo bench -p touchcal --bench network --no-run     # names the binary
    crates/touchcal/benches/network_pytorch.py BINARY [ROUNDS [THREADS [DEVICE]]]

DEVICE is cpu (the default), or cuda for the training cases on a GPU: both programs, with BINARY built with `--features cuda`.

Prints for each case the medians and the ratio of times, PyTorch's to touchcal's: its median over the rounds and the middle half. Above 1 touchcal is faster.
"""
import os
import statistics
import subprocess
import sys
import time

ROUNDS = int(sys.argv[2]) if len(sys.argv) > 2 else 15
THREADS = int(sys.argv[3]) if len(sys.argv) > 3 else 2
DEVICE = sys.argv[4] if len(sys.argv) > 4 else "cpu"
os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = os.environ["RAYON_NUM_THREADS"] = str(THREADS)

import torch  # noqa: E402

CASES = {
    "train 4x512 batch 1024": (512, 1024, 10),
    "train 4x4096 batch 256": (4096, 256, 1),
    "project 3000 with gradient 4x512": (512, None, 5),
    "project 3000 with gradient 4x4096": (4096, None, 1),
}


def network(width: int) -> torch.nn.Sequential:
    widths = [6, width, width, width, width, 6]
    layers = [part for a, b in zip(widths, widths[1:]) for part in (torch.nn.Linear(a, b), torch.nn.ReLU())]
    return torch.nn.Sequential(*layers[:-1])


def case(width: int, batch: int | None):
    """A function that does one repetition."""
    model = network(width).to(DEVICE)
    if batch is None:
        model.requires_grad_(False)
        poses = torch.randn(3000, 6)

        def project():
            x = poses.clone().requires_grad_(True)
            model(x).abs().sum().backward()
            return x.grad

        return project
    inputs, targets = torch.randn(16, batch, 6, device=DEVICE), torch.randn(16, batch, 6, device=DEVICE)
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-4, fused=True)
    step = 0

    def train():
        nonlocal step
        optimizer.zero_grad(set_to_none=True)
        loss = torch.nn.functional.mse_loss(model(inputs[step % 16]), targets[step % 16])
        loss.backward()
        optimizer.step()
        step += 1
        return loss.item()

    return train


def seconds(repetition, count: int) -> float:
    start = time.perf_counter()
    for _ in range(count):
        repetition()
    return (time.perf_counter() - start) / count


def main(binary: str) -> None:
    torch.set_num_threads(THREADS)
    print(f"PyTorch {torch.__version__}, {DEVICE}, {THREADS} threads, {ROUNDS} rounds")
    for name, (width, batch, count) in CASES.items():
        if DEVICE != "cpu":
            if batch is None:
                continue
            count *= 20
        with subprocess.Popen([binary, "--serve", DEVICE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:

            def own() -> float:
                print(name, file=server.stdin, flush=True)
                return float(server.stdout.readline())

            repetition = case(width, batch)
            own(), seconds(repetition, count)
            pairs = [(own(), seconds(repetition, count)) for _ in range(ROUNDS)]
            server.stdin.close()
        a, b = (statistics.median(side) for side in zip(*pairs))
        ratios = [theirs / ours for ours, theirs in pairs]
        low, middle, high = statistics.quantiles(ratios, n=4)
        print(f"{name}: touchcal {1e3 * a:.1f} ms, PyTorch {1e3 * b:.1f} ms, ratio {middle:.2f} ({low:.2f} to {high:.2f})", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
