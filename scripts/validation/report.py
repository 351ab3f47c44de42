"""What a section shows: tables of measured against expected figures, and what programs print."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Row:
    """One quantity against its reference."""

    what: str
    figures: dict[str, str]
    reference: str = ""
    tolerance: str = ""
    why: str = ""
    command: str = ""
    missed: bool = False


@dataclass
class Table:
    """Rows with the same figures. What all rows share is above the table."""

    rows: list[Row]
    title: str = ""

    def markdown(self):
        above, columns = [f"**{self.title}**"] * bool(self.title), []
        for key in ("reference", "tolerance", "why", "command"):
            values = {getattr(row, key) for row in self.rows}
            if len(values) > 1:
                columns.append(key)
            elif value := values.pop():
                above.append(f"{key.capitalize()}: {value}.")
        before = [key for key in columns if key != "command"]
        head = ["", *before, *self.rows[0].figures, *(key for key in columns if key == "command")]
        lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
        for row in self.rows:
            assert list(row.figures) == list(self.rows[0].figures), row.what
            what = row.what + (" **missed**" if row.missed else "")
            cells = [what, *(getattr(row, key) for key in before), *row.figures.values()]
            cells += [row.command] if "command" in columns else []
            lines.append(f"| {' | '.join(cells)} |")
        return "\n".join([*above, *([""] if above else []), *lines, ""])

    def missed(self):
        return [row.what for row in self.rows if row.missed]


@dataclass
class Printed:
    """The figures that a program prints, as it prints them. `failed`: it found a limit exceeded."""

    text: str
    title: str
    command: str
    failed: bool = False

    def markdown(self):
        verdict = " **missed**" if self.failed else ""
        lines = [line.rstrip() for line in self.text.strip("\n").splitlines()]
        return "\n".join([f"**{self.title}**{verdict}", f"Command: {self.command}.", "", "```text", *lines, "```", ""])

    def missed(self):
        return [self.title] * self.failed


def number(value):
    """A figure as people read it: `0.0042`, `3.1e-9`."""
    if value == 0 or 1e-3 <= abs(value) < 1e3:
        return f"{value:.2g}"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def within(row, errors, limit):
    """A row of absolute errors, of which none may be beyond the limit; NaN is beyond every limit."""
    errors = np.abs(np.ravel(errors))
    return quantiles(row, [np.quantile(errors, share, method="higher") for share in (0.75, 0.99, 1)], limit)


def quantiles(row, values, limit):
    """The same, given q75, q99 and the greatest."""
    q75, q99, greatest = values
    figures = {"q75": number(q75), "q99": number(q99), "max": number(greatest)}
    return Row(**row, figures=figures, tolerance=number(limit), missed=not greatest <= limit)
