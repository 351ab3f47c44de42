"""Statistics of simulated explorations against those of the MuJoCo logs."""

from .commands import test, test_command
from .report import Row, Table, number

TEST = ("--test", "consistency", "simulator")
COMMAND = test_command(*TEST)
REASONS = {
    1.25: "both explore the same hole for ten seconds, each with its own command",
    1.75: "the clearance bounds all but z; stiffness and press are a choice",
    1.5: "the test's limit",
}


def tables(_options):
    rows = []
    for what, found in test(*TEST)[0].items():
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
