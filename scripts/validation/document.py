"""The document: the template's text with the sections' tables, each with revision, form and machine of its measurement."""

import importlib
import json
import os
import platform
import re
import sys
import time

from .commands import FILES, ROOT, revision

TEMPLATE = ROOT / "scripts/validation/template.md"
PLACE = re.compile(r"\{\{(\w+)\}\}")
# A section of the document between its marks; with a pattern as text, the pattern that finds it.
SECTION = "<!-- {0} -->\n{1}<!-- /{0} -->\n"


def references():
    """The references that are asked for with the versions that are pinned, `numpy 2.4.6, …`."""
    asked, pinned = ((ROOT / f"scripts/requirements/validation.{kind}").read_text().splitlines() for kind in ("in", "txt"))
    names = [line.split("==")[0] for line in asked if "==" in line]
    versions = dict(line.split(" ")[0].split("==") for line in pinned if "==" in line)
    return ", ".join(f"{name} {versions[name]}" for name in names)


def machine():
    """`8 × model of the processor`."""
    try:
        lines = open("/proc/cpuinfo", encoding="utf-8").read().splitlines()
        model = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.processor() or platform.machine()
    return f"{os.cpu_count()} × {model}"


def given():
    """Places that are no sections."""
    return {"references": references()}


def is_measured(path, options):
    """Whether a section has been measured with these very sources."""
    if not path.exists() or revision().endswith("+"):
        return False
    measured = json.loads(path.read_text())
    return (measured["revision"], measured["form"]) == (revision(), options.form)


def measure(name, options, path):
    start = time.monotonic()
    tables = importlib.import_module(f".{name}", __package__).tables(options)
    seconds = time.monotonic() - start
    measured = {
        "revision": revision(),
        "form": options.form,
        "machine": machine(),
        "seconds": round(seconds),
        "text": "\n".join(table.markdown() for table in tables),
        "missed": [f"{name}: {what}" for table in tables for what in table.missed()],
    }
    path.write_text(json.dumps(measured, indent=1))
    print(f"measured {name} in {seconds:.0f} s", file=sys.stderr)


def stamped(measured):
    """The text of a section, below the revision, the form and the machine it was measured with."""
    stamp = f"Measured with touchcal {measured['revision']}, in the {measured['form']} form, on {measured['machine']}."
    return f"{stamp}\n\n{measured['text']}"


def written(name, document):
    """The text of a section that the document has already."""
    found = re.search(SECTION.format(name, "(.*?)"), document, re.DOTALL)
    return found and found[1]


def write(options):
    """Measures the sections that are due, writes the document; 1 if anything is missed, else 0."""
    template, known = TEMPLATE.read_text(), given()
    sections = [name for name in PLACE.findall(template) if name not in known]
    if unknown := set(options.only) - set(sections):
        sys.exit(f"expected sections ({', '.join(sections)}), found {', '.join(sorted(unknown))}")
    FILES.mkdir(parents=True, exist_ok=True)
    due = options.only or sections
    paths = {name: FILES / f"{name}.json" for name in due}
    for name in due:
        if name in options.only or not is_measured(paths[name], options):
            measure(name, options, paths[name])

    measured = {name: json.loads(path.read_text()) for name, path in paths.items()}
    document = options.out.read_text() if options.out.exists() else ""
    texts = {name: stamped(measured[name]) if name in measured else written(name, document) for name in sections}
    if lacking := [name for name, text in texts.items() if text is None]:
        print(f"not written, {options.out} lacks these sections: {', '.join(lacking)}", file=sys.stderr)
        for each in measured.values():
            print(each["text"])
    else:
        place = lambda found: known.get(found[1]) or SECTION.format(found[1], texts[found[1]])
        options.out.write_text(PLACE.sub(place, template))
        print(f"written: {options.out}, {sum(each['seconds'] for each in measured.values())} s", file=sys.stderr)
    missed = [what for each in measured.values() for what in each["missed"]]
    for what in missed:
        print(f"missed   {what}", file=sys.stderr)
    return int(bool(missed))
