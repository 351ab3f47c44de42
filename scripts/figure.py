#!/usr/bin/env python3
"""Draws docs/real_arms.svg: real arms scored on placements that the fit never saw.

Usage: cargo build --release; scripts/figure.py
Each arm is calibrated without one placement by `touchcal calibrate` and scored on it by `touchcal evaluate`, placement by placement.
"""

import json
import subprocess
import tempfile
from pathlib import Path

import mukca
from environment import enter

enter("figure")

import matplotlib  # noqa: E402

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "touchcal"
import matplotlib.pyplot as plt  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
ARMS = {
    "KUKA iiwa 14": "kuka_14",
    "Franka Panda 1": "panda_1",
    "Franka Panda 3": "panda_3",
    "Kinova gen3 lite": "dinova_2",
}


def touchcal(*arguments):
    command = [ROOT / "target/release/touchcal", *map(str, arguments), "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def held_out(robot):
    """Mean distance (mm) by the nominal and by the calibrated arm, for each placement left out."""
    rows = []
    everything = mukca.placements(robot)
    for placement in everything:
        with tempfile.TemporaryDirectory() as folder:
            fitted, scored, out = (Path(folder, name) for name in ("fitted.toml", "scored.toml", "out"))
            fitted.write_text(mukca.problem(robot, [name for name in everything if name != placement]))
            scored.write_text(mukca.problem(robot, [placement]))
            touchcal("calibrate", fitted, "--out", out)
            nominal, calibrated = touchcal("evaluate", scored), touchcal("evaluate", scored, "--urdf", out / "calibrated.urdf")
            rows.append((nominal["mean_mm"], calibrated["mean_mm"]))
    return rows


def main():
    figure, axes = plt.subplots(figsize=(7.2, 3.2))
    for index, robot in enumerate(ARMS.values()):
        rows = held_out(robot)
        before, after = (sum(column) / len(rows) for column in zip(*rows))
        print(f"{robot}: nominal {before:.3f} mm, held out {after:.4f} mm")
        for kind, (value, colour) in enumerate([(before, "#b0b7c3"), (after, "#1f6feb")]):
            x = index + 0.4 * kind - 0.2
            axes.bar(x, value, 0.38, color=colour, label=["nominal", "calibrated by touch"][kind] if index == 0 else None)
            axes.plot([x] * len(rows), [row[kind] for row in rows], ".", color="#24292f", markersize=3)
            axes.text(x, max(row[kind] for row in rows) * 1.15, f"{value:.2f}", ha="center", va="bottom", fontsize=8)
    axes.set_xticks(range(len(ARMS)), ARMS.keys())
    axes.set_yscale("log")
    axes.set_ylim(0.05, 60)
    axes.set_ylabel("mm from the socket's mean")
    axes.set_title("Real arms, placements the fit never saw (dots: each placement)", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure.tight_layout()
    (ROOT / "docs").mkdir(exist_ok=True)
    figure.savefig(ROOT / "docs/real_arms.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
