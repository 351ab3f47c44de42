"""Rows of measured against expected, and their tables."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Row:
    """One quantity against its reference."""

    what: str
    figures: dict[str, str]
    reference: str
    tolerance: str
    why: str
    command: str
    missed: bool = False


@dataclass
class Table:
    """Rows with the same figures. What all rows share is said once, above."""

    rows: list[Row]
    title: str = ""

    def markdown(self):
        shared, columns = [], []
        for key in ("reference", "tolerance", "why", "command"):
            values = {getattr(row, key) for row in self.rows}
            if len(values) > 1:
                columns.append(key)
            elif value := values.pop():
                shared.append(f"{key.capitalize()}: {value}.")
        before = [key for key in columns if key != "command"]
        head = ["", *before, *self.rows[0].figures, *(key for key in columns if key == "command")]
        lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
        for row in self.rows:
            assert list(row.figures) == list(self.rows[0].figures), row.what
            what = row.what + (" **missed**" if row.missed else "")
            cells = [what, *(getattr(row, key) for key in before), *row.figures.values()]
            cells += [row.command] if "command" in columns else []
            lines.append(f"| {' | '.join(cells)} |")
        above = " ".join([f"**{self.title}**"] * bool(self.title) + shared)
        return "\n".join([*([above, ""] if above else []), *lines, ""])


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
