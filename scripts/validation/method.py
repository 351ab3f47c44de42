"""The method that touchcal starts from (Negi, Manyar and Gupta 2025), and what each of its parts costs."""

import json

from . import network
from .commands import DATA, files, touchcal
from .report import Row, Table, number

DESCENT = ["--steps", 300, "--descent-contacts", 250]
RECORDED = {"short": DESCENT, "long": ["--steps", 5000]}
LOGS = {"short": ["extrusion/rich"], "long": ["extrusion/paper", "extrusion/rich"]}
SIMULATED = {"short": ["--trials", 1, *DESCENT], "long": ["--trials", 20, "--steps", 2000]}
# Greatest mean errors of the long form: strain, bias (°).
LIMITS = {
    ("extrusion/paper", "nearest_gd"): (4e-4, 0.05),
    ("extrusion/rich", "nearest_gd"): (None, 0.012),
    ("simulated", "learned_gd"): (0.019, 1.48),
}
COMMAND = "`touchcal experiment table1 --manifold m.safetensors --weights net/weights.safetensors --out DIR {}`"


def experiment(name, arguments, options):
    folder = files(options) / "table1" / name.replace("/", "_")
    manifold, net = network.manifold(options), network.trained(options)
    common = ["--manifold", manifold, "--weights", net / "weights.safetensors", "--out", folder]
    touchcal("experiment", "table1", *common, *arguments)
    found = json.loads((folder / "table1.json").read_text())
    published = found["published"]
    blank = dict.fromkeys(("hole", "elsewhere, mean", "elsewhere, 95 %", "not refused", "s"), "–")
    factor = lambda row: f"{row['strain_reduction']:.2g}, {row['bias_reduction']:.2g} times"
    rows = [
        Row(
            "published, real arm",
            {"strain": f"{published['strain_mae']}", "bias": f"{published['bias_mae_deg']}°", "smaller by": factor(published), **blank},
        )
    ]
    for summary in found["summary"]:
        strain, bias = summary["strain_mae"], summary["bias_mae_deg"]
        limits = LIMITS.get((name, summary["approach"])) if options.form == "long" else None
        hole, space = summary["hole"], summary["workspace"]
        figures = {
            "strain": number(strain),
            "bias": f"{number(bias)}°",
            "smaller by": factor(summary),
            "hole": f"{number(hole['mean_mm'])} mm, {number(hole['mean_deg'])}°",
            "elsewhere, mean": f"{number(space['mean_mm'])} mm, {number(space['mean_deg'])}°",
            "elsewhere, 95 %": f"{number(space['mm_95'])} mm, {number(space['deg_95'])}°",
            "not refused": f"{100 * summary['not_refused']:.0f} %",
            "s": f"{summary['seconds']:.1f}",
        }
        over = lambda value, limit: limit is not None and not value <= limit
        missed = bool(limits) and (over(strain, limits[0]) or over(bias, limits[1]))
        tolerance = ", ".join(t for t in (number(limits[0]) if limits[0] else "", f"{limits[1]}°") if t) if limits else "none"
        rows.append(Row(summary["label"], figures, tolerance=tolerance, missed=missed))
    if all(row.tolerance in ("none", "") for row in rows):
        for row in rows:
            row.tolerance = ""
    shown = " ".join(map(str, arguments)).replace(str(DATA.parent) + "/", "")
    for row in rows:
        row.command = COMMAND.format(shown)
    return Table(rows, f"{name}, {found['summary'][0]['trials']} trials.")


def tables(options):
    recorded = [
        experiment(name, ["--logs", DATA / "mujoco_iiwa14" / name, *RECORDED[options.form]], options)
        for name in LOGS[options.form]
    ]
    return [*recorded, experiment("simulated", SIMULATED[options.form], options)]
