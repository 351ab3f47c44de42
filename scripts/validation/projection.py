"""The learned projection onto contact poses, and other projections."""

import math
import sys

from . import network
from .commands import ROOT, bench, bench_command, run
from .report import Printed, Row, Table

MM, DEG = 1e3, 180 / math.pi


def accuracy(folder, title, command):
    found = network.metrics(folder)
    rows = []
    for row in found["accuracy"]:
        both = lambda entry, key: f"{MM * entry['place_' + key]:.3g} mm, {DEG * entry['turn_' + key]:.3g}°"
        figures = {
            "pose to nearest sample": both(row["pose_to_nearest"], "mean"),
            "output to manifold, mean": both(row["output_to_manifold"], "mean"),
            "95 %": both(row["output_to_manifold"], "q95"),
            "output to the nearest sample, mean": both(row["output_to_nearest"], "mean"),
            "95 % of it": both(row["output_to_nearest"], "q95"),
        }
        offset = row["offset"]
        rows.append(Row(f"offsets up to {MM * offset[0]:.3g} mm, {DEG * offset[3]:.3g}°", figures, command=command))
    held_out = found["held_out_rms"]
    rms = f", {MM * held_out:.2f} mm root mean square on held-out pairs" if held_out else ""
    return Table(rows, f"{title}, {found['steps']} steps{rms}.")


def onnx(folder):
    text = run(sys.executable, ROOT / "scripts/check_onnx.py", folder)
    return Printed(text, "The exported network in onnxruntime.", "`scripts/check_onnx.py net`")


def tables(options):
    folder = network.trained(options)
    found = [accuracy(folder, "Learned within ±10 mm and ±10°", network.COMMAND)]
    if options.form == "long":
        for name, title, more in (
            ("network_wide", "Learned within ±100 mm and ±30°", ("--offset-mm", "100", "--offset-deg", "30")),
            ("network_correction", "The way to the projection learned instead of the pose", ("--correction",)),
        ):
            command = network.COMMAND.replace(" --onnx", f" {' '.join(more)}")
            found.append(accuracy(network.trained(options, name, *more), title, command))
    table = bench("projection_table", folder / "weights.safetensors")
    return [
        *found,
        onnx(folder),
        Printed(table, "Projections compared, one core.", bench_command("projection_table -- net/weights.safetensors")),
    ]
