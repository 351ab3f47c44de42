#!/usr/bin/env python3
"""Compares a network that `touchcal train --onnx` exported, as onnxruntime runs it, with touchcal's own outputs on random poses.

    scripts/check_onnx.py DIR        # with weights.safetensors and weights.onnx; exits with 1 where they differ by more than rounding
"""
import io
import json
import subprocess
import sys
from pathlib import Path

from environment import ROOT, TARGET, enter

enter("onnx")

import numpy as np  # noqa: E402
import onnx  # noqa: E402
import onnxruntime  # noqa: E402

POSES = 20_000
# Single precision of values up to a metre or radian, summed a few thousand times.
TOLERANCE = 2e-6


def main(folder: Path) -> int:
    model = onnx.load(folder / "weights.onnx")
    onnx.checker.check_model(model, full_check=True)
    print(f"opset {model.opset_import[0].version}, " + ", ".join(f"{p.key}={p.value}" for p in model.metadata_props))

    with open(folder / "weights.safetensors", "rb") as file:
        header = json.loads(file.read(int.from_bytes(file.read(8), "little")))
    network = json.loads(header["__metadata__"]["touchcal_network"])["content"]["network"]
    low, high = np.array(network["teacher"]["bounds"]).T
    offsets = np.array(network["teacher"]["offsets"])
    # As far again outside as the network learned, rounded so that both read the same single-precision numbers.
    random = np.random.default_rng(1)
    poses = random.uniform(low - 2 * offsets, high + 2 * offsets, (POSES, 6)).astype(np.float32)

    text = io.StringIO()
    np.savetxt(text, poses.astype(np.float64), "%.17g", ",")
    subprocess.run(["cargo", "build", "-q", "--workspace", "--example", "project_poses"], cwd=ROOT, check=True)
    command = [TARGET / "debug/examples/project_poses", folder / "weights.safetensors"]
    own = subprocess.run(command, input=text.getvalue(), capture_output=True, text=True, check=True).stdout
    own = np.loadtxt(io.StringIO(own), delimiter=",")

    session = onnxruntime.InferenceSession(folder / "weights.onnx", providers=["CPUExecutionProvider"])
    (other,) = session.run(None, {"pose": poses})
    difference = np.abs(own - other).max(axis=0)
    print(f"{POSES} poses, greatest difference of each coordinate (m, rad): {np.array2string(difference, precision=2)}")
    print(f"greatest {difference.max():.2e}, outputs reach {np.abs(own).max():.3f}")
    return int(not difference.max() <= TOLERANCE * max(1.0, np.abs(own).max()))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
