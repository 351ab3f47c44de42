"""Statistics of simulated explorations against those of the MuJoCo logs."""

from .commands import test
from .report import Row, Table, number

COMMAND = "`cargo test -p touchcal --test simulation_statistics -- --nocapture`"
REASONS = {
    1.25: "both explore the same hole for ten seconds, each with its own command",
    1.75: "the clearance bounds all but z; stiffness and press are a choice",
    1.5: "the test's limit",
}


def tables(_options):
    rows = []
    for what, found in test("--test", "simulation_statistics")[0].items():
        ratio = found["simulated"] / found["mujoco"]
        limit = found["limit"]
        figures = {"MuJoCo": number(found["mujoco"]), "simulated": number(found["simulated"]), "ratio": f"{ratio:.2f}"}
        rows.append(
            Row(
                what,
                figures,
                "the MuJoCo logs",
                f"ratio within {limit} either way",
                REASONS[limit],
                COMMAND,
                not 1 / limit < ratio < limit,
            )
        )
    return [Table(rows)]
