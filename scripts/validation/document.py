"""The document: the template's text with the sections' tables, all of one revision and one form."""

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
# Lines of the template that only one form shows: `<!-- long -->` and `<!-- short -->` at their beginning.
ONLY = re.compile(r"^<!-- (short|long) -->", re.MULTILINE)


def references():
    """The pinned references, `numpy 2.4.6, …`."""
    lines = (ROOT / "scripts/requirements/validation.txt").read_text().splitlines()
    return ", ".join(line.replace("==", " ") for line in lines if "==" in line)


def machine():
    """`8 × model of the processor`."""
    try:
        lines = open("/proc/cpuinfo", encoding="utf-8").read().splitlines()
        model = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.processor() or platform.machine()
    return f"{os.cpu_count()} × {model}"


def given(options):
    """Places that are no sections."""
    return {"version": revision(), "form": options.form, "references": references(), "machine": machine()}


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
        "seconds": round(seconds),
        "text": "\n".join(table.markdown() for table in tables),
        "missed": [f"{name}: {what}" for table in tables for what in table.missed()],
    }
    path.write_text(json.dumps(measured, indent=1))
    print(f"measured {name} in {seconds:.0f} s", file=sys.stderr)


def write(options):
    """Measures the sections that are due, writes the document; 1 if anything is missed, else 0."""
    template = ONLY.sub("", "\n".join(line for line in TEMPLATE.read_text().splitlines() if is_shown(line, options)) + "\n")
    known = given(options)
    sections = [name for name in PLACE.findall(template) if name not in known]
    if unknown := set(options.only) - set(sections):
        sys.exit(f"expected sections ({', '.join(sections)}), found {', '.join(sorted(unknown))}")
    FILES.mkdir(parents=True, exist_ok=True)
    paths = {name: FILES / f"{name}.json" for name in sections}
    for name in sections:
        if name in options.only or not options.only and not is_measured(paths[name], options):
            measure(name, options, paths[name])

    measured = {name: json.loads(path.read_text()) for name, path in paths.items() if path.exists()}
    stale = [
        name
        for name in sections
        if name not in measured or (measured[name]["revision"], measured[name]["form"]) != (revision(), options.form)
    ]
    if stale:
        print(f"not written: other revision or form, or never measured: {', '.join(stale)}", file=sys.stderr)
        for name in set(options.only) & measured.keys():
            print(measured[name]["text"])
    else:
        text = PLACE.sub(lambda place: known.get(place[1]) or measured[place[1]]["text"], template)
        options.out.write_text(text)
        print(f"written: {options.out}, {sum(each['seconds'] for each in measured.values())} s", file=sys.stderr)
    missed = [what for each in measured.values() for what in each["missed"]]
    for what in missed:
        print(f"missed   {what}", file=sys.stderr)
    return int(bool(missed or stale and not options.only))


def is_shown(line, options):
    only = ONLY.match(line)
    return not only or only[1] == options.form
