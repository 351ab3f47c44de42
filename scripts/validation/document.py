"""The document: the template's text with the sections' tables."""

import importlib
import json
import re
import sys

from .commands import ROOT, revision

TEMPLATE = ROOT / "scripts/validation/template.md"
PLACE = re.compile(r"\{\{(\w+)\}\}")


def references():
    """The pinned references, `numpy 2.4.6, …`."""
    lines = (ROOT / "scripts/validation/requirements.txt").read_text().splitlines()
    return ", ".join(line.replace("==", " ") for line in lines if "==" in line)


# Places that are no sections.
GIVEN = {"version": revision, "references": references}


def write(options, kept):
    """Measures the wanted sections, writes the document; 1 if anything is missed, else 0."""
    template = TEMPLATE.read_text()
    sections = [name for name in PLACE.findall(template) if name not in GIVEN]
    if unknown := set(options.only) - set(sections):
        sys.exit(f"expected sections ({', '.join(sections)}), found {', '.join(sorted(unknown))}")
    kept.mkdir(parents=True, exist_ok=True)
    for name in options.only or sections:
        print(f"measuring: {name}", file=sys.stderr)
        tables = importlib.import_module(f".{name}", __package__).tables(options)
        measured = {
            "revision": revision(),
            "text": "\n".join(table.markdown() for table in tables),
            "missed": [f"{name}: {row.what}" for table in tables for row in table.rows if row.missed],
        }
        (kept / f"{name}.json").write_text(json.dumps(measured, indent=1))

    missed = []

    def fill(place):
        name = place[1]
        if name in GIVEN:
            return GIVEN[name]()
        path = kept / f"{name}.json"
        if not path.exists():
            missed.append(f"{name}: never measured")
            return "**not measured**\n"
        measured = json.loads(path.read_text())
        missed.extend(measured["missed"])
        stale = measured["revision"] != revision()
        return (f"Measured with touchcal {measured['revision']}.\n\n" if stale else "") + measured["text"]

    options.out.write_text(PLACE.sub(fill, template))
    print(f"written: {options.out.name}; missed: {len(missed)}", file=sys.stderr)
    for row in missed:
        print(f"missed   {row}", file=sys.stderr)
    return int(bool(missed))
