"""Samples of the T-slot hole and the network that learns the projection onto them, made once for all sections."""

import json

from .commands import DATA, files, touchcal

POSES = DATA / "mujoco_iiwa14/extrusion/offline/contact_poses.csv.gz"
STEPS = {"short": 1500, "long": 15_000}
COMMAND = "`touchcal train --manifold m.safetensors --out net --steps N --onnx`"


def manifold(options):
    path = files(options) / "m.safetensors"
    if not path.exists():
        touchcal("manifold", "--poses", POSES, "--out", path)
    return path


def trained(options, name="network", *more):
    """The folder of a network: weights.safetensors, weights.onnx, metrics.json."""
    folder = files(options) / name
    if not (folder / "metrics.json").exists():
        resume = ["--resume"] if (folder / "checkpoint.safetensors").exists() else ["--steps", STEPS[options.form], *more]
        touchcal("train", "--manifold", manifold(options), "--out", folder, "--onnx", *resume)
    return folder


def metrics(folder):
    return json.loads((folder / "metrics.json").read_text())
