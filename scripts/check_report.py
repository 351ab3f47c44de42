#!/usr/bin/env python3
"""Opens reports in headless Chromium: they draw without complaint, load nothing, fit the window and the paper, and look as they did.

    scripts/check_report.py TOUCHCAL [--keep FOLDER]

TOUCHCAL is the program.
Chromium and the font DejaVu Sans must be there (Debian: chromium, fonts-dejavu-core).
TOUCHCAL_UPDATE=1 writes the pictures to compare with; look at them before you commit them.
With --keep the reports and full pictures stay in FOLDER.
"""

import argparse
import csv
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import mukca
from environment import enter

enter("browser")

from PIL import Image, ImageChops  # noqa: E402

import report_layout  # noqa: E402
from browser import Browser  # noqa: E402

GOLDEN = Path(__file__).resolve().parent / "report_golden"
FONT = "DejaVu Sans"
DESKTOP, PHONE, TABLET, WIDE = (1280, 800), (390, 844), (768, 1024), (1920, 1080)
# What is between the margins of a sheet of A4 (px), and most sheets of the report of an arm with seven joints.
PAPER, MOST_SHEETS = (718, 1047), 8
# Pictures are compared at this share of their size; of their pixels so many may differ, by more than so much in a channel of 255.
SCALE = {DESKTOP: 0.16, PHONE: 0.23}
ARM_SCALE = 0.3
MOST_DIFFERENT, NOTICEABLE = 0.02, 40
MOST_BYTES = 6_000_000
FIRST_PAINT_MS = 1000
# Share of the picture in space that must not be background.
LEAST_DRAWN = 0.01
# How far the page's own kinematics may be from the library's (m): joint positions travel as 32-bit numbers.
KINEMATICS_M = 1e-6
# A formula to a spreadsheet, and markup.
HOSTILE = '=1+1</script><script>document.title = "taken over"</script><img src=x onerror="alert(1)">'


def reports(touchcal, folder):
    """Writes what is to be looked at; the path of each report."""

    def run(*arguments, code=0):
        # Inside the folder: reports name files as they were given.
        done = subprocess.run([touchcal, *map(str, arguments)], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        check(done.returncode == code, f"touchcal {arguments[0]} ended with {done.returncode}: {done.stderr}")

    run("demo", "--out", "demo")
    run("demo", "--contacts", 10_000, "--out", "demo_10000")
    problem = (folder / "demo/problem.toml").read_text()
    variants = {
        "not_usable": (problem.replace("outline_offset_mm = 0.5", "outline_offset_mm = 1.0"), 3),
        "free": (problem.replace("exact = true\n\n[[contacts]]", 'free = true\nexact = ["clearance", "depth"]\n\n[[contacts]]', 1), 0),
        "contradicted": (problem.replace("base_from_fixture = { xyz_mm = [600, 100, 150]", "base_from_fixture = { xyz_mm = [600.4, 99.6, 150.4]"), 3),
        "assumed": (problem.replace("exact = true\n", ""), 0),
        "hostile": (problem.replace('"hole"\nkind', f"'''{HOSTILE}'''\nkind").replace('fixture = "hole"', f"fixture = '''{HOSTILE}'''"), 0),
    }
    for name, (text, code) in variants.items():
        (folder / "demo" / f"{name}.toml").write_text(text)
        run("calibrate", f"demo/{name}.toml", "--out", name, code=code)
    (folder / "sockets.toml").write_text(mukca.problem("panda_1"))
    run("calibrate", "sockets.toml", "--out", "sockets")
    paths = {name: folder / name / "report.html" for name in ("demo", "demo_10000", "sockets", *variants)}
    for name, problem, truth in (("demo", "demo/problem.toml", ["--truth", "demo/truth.json"]), ("sockets", "sockets.toml", [])):
        of_calibration = ["--urdf", f"{name}/calibrated.urdf", "--estimate", f"{name}/estimate.json"]
        paths[f"evaluation_{name}"] = folder / f"evaluation_{name}" / "page.html"
        paths[f"evaluation_{name}"].parent.mkdir()
        run("evaluate", problem, *of_calibration, *truth, "--report", paths[f"evaluation_{name}"])
    return paths


def check(holds, complaint):
    if not holds:
        sys.exit(f"check_report: {complaint}")


def open_report(browser, path, window, dark=False):
    page = browser.open_report(path, window, dark=dark, mobile=window == PHONE)
    where = f"{path.parent.name} at {window[0]} px, {'dark' if dark else 'light'}"
    check(not browser.errors, f"{where}: errors on the console: {browser.errors}")
    loaded = [url for url in browser.loaded if not url.startswith(("data:", "blob:"))]
    check(loaded == [path.resolve().as_uri()], f"{where}: it loaded {loaded}")
    width = page.evaluate("document.documentElement.scrollWidth")
    check(width <= window[0], f"{where}: it is {width} px wide")
    empty = page.evaluate("[...document.querySelectorAll('figure:not([hidden]) .chart')].filter((host) => !host.querySelector('svg')).map((host) => host.id)")
    check(not empty, f"{where}: nothing is drawn in {empty}")
    return page


def arm(browser):
    """The picture in space."""
    box = browser.page.evaluate("(() => { const b = document.querySelector('#arm canvas').getBoundingClientRect(); return [b.x + scrollX, b.y + scrollY, b.width, b.height]; })()")
    return scaled(browser.picture(box), ARM_SCALE)


def scaled(picture, share):
    return picture.resize([round(share * size) for size in picture.size], Image.Resampling.BOX)


def different(one, other):
    """Share of pixels that differ noticeably."""
    greatest = ImageChops.difference(one, other).split()
    greatest = ImageChops.lighter(ImageChops.lighter(*greatest[:2]), greatest[2])
    return sum(greatest.histogram()[NOTICEABLE + 1 :]) / (one.width * one.height)


def arm_is_drawn_and_turns(browser, name):
    page, before = browser.page, arm(browser)
    drawn = different(before, Image.new("RGB", before.size, before.getpixel((0, 0))))
    check(drawn > LEAST_DRAWN, f"{name}: the picture in space is empty, {drawn:.3f} of it is drawn")
    page.evaluate("document.querySelector('#arm').scrollIntoView({ block: 'center' })")
    x, y = page.evaluate("(() => { const b = document.querySelector('#arm canvas').getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 120, y + 20, steps=5)
    page.mouse.up()
    dragged = arm(browser)
    check(different(before, dragged) > 0.01, f"{name}: dragging does not turn the arm")
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
    keyed = arm(browser)
    check(different(dragged, keyed) > 0.005, f"{name}: the arrow keys do not turn the arm")
    moves_by_keys_alone(page, name)
    off = page.evaluate(
        "Math.max(...data.scene.q.map((q, k) => origin(frames(data.scene.calibrated, q).tool).distanceTo(new three.Vector3(...data.scene.after[k]))))"
    )
    check(off < KINEMATICS_M, f"{name}: the arm is drawn {off} m beside its contacts")
    print(f"{name}: {100 * drawn:.0f} % of the picture in space is drawn, it turns, its tool is within {1e6 * off:.2f} µm of the contacts")


def moves_by_keys_alone(page, name):
    """From the control before it, Tab reaches the view in space, whose keys its label names; each moves the camera."""
    page.locator("#arm-controls input[type=range]").focus()
    page.keyboard.press("Tab")
    label = page.evaluate("document.activeElement.matches('#arm canvas') ? document.activeElement.ariaLabel : ''")
    check(all(word in label for word in ("Arrow keys", "plus", "minus", "0")), f"{name}: Tab leads to no view that names its keys, but to {label!r}")
    page.evaluate("(() => { window.rendered = []; const { render } = ArmView.prototype; ArmView.prototype.render = function () { rendered.push(1); render.call(this); }; })()")
    for key in ("ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "+", "-", "0"):
        page.evaluate("rendered.length = 0")
        page.keyboard.press(key)
        check(page.evaluate("rendered.length") > 0, f"{name}: the key {key} does not move the view")


def is_laid_out(browser, path, is_audited):
    """At each width, light and dark, and on paper, labels lie apart and whole; axe-core finds nothing, if the page `is_audited`."""
    name, page = path.parent.name, browser.open_report(path, DESKTOP)

    def at(window, media="null", scheme="light"):
        page.set_viewport_size({"width": window[0], "height": window[1]})
        page.emulate_media(media=media, color_scheme=scheme)
        browser.settle()
        return f"{name} at {window[0]} px, {'on paper' if media == 'print' else scheme}"

    for window in (PHONE, TABLET, DESKTOP, WIDE):
        for scheme in ("light", "dark"):
            where = at(window, scheme=scheme)
            none_of(report_layout.complaints(page), where)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    where = at(PAPER, media="print")
    none_of(report_layout.complaints(page), where)
    for scheme in ("dark", "light"):
        where = at(DESKTOP, scheme=scheme)
        sheets = len(re.findall(rb"/Type\s*/Page\b", page.pdf(print_background=True)))
        check(0 < sheets <= MOST_SHEETS, f"{where}: it prints on {sheets} sheets")
    for window in (PHONE, DESKTOP) if is_audited else ():
        for scheme in ("light", "dark"):
            where = at(window, scheme=scheme)
            none_of(report_layout.violations(page), where)
    print(f"{name}: no label overlaps or is cut at any width, {sheets} sheets of paper{', axe-core finds nothing' if is_audited else ''}")


def none_of(complaints, where):
    check(not complaints, f"{where}: {'; '.join(complaints)}")


def saved_tables(page):
    """What the buttons save, by the name of the file."""
    tables = {}
    for button in page.locator("button.csv").all():
        # Some are in what is folded.
        with page.expect_download() as download:
            button.dispatch_event("click")
        text = Path(download.value.path()).read_text(encoding="utf-8-sig")
        tables[download.value.suggested_filename] = list(csv.DictReader(text.splitlines()))
    return tables


def saves_tables(browser, path):
    """The saved tables have the page's numbers."""
    page = open_report(browser, path, DESKTOP)
    tables = saved_tables(page)
    expected = page.evaluate("[data.parameters.each.length, data.contacts.drawn.index.length, data.fixtures.length]")
    found = [len(tables.get(name, [])) for name in ("parameters.csv", "contacts.csv", "fixtures.csv")]
    check(found == expected, f"tables of {expected} rows are saved as {found}")
    value = page.evaluate("180 / Math.PI * data.parameters.each.find(({ name }) => name === 'joint_offset.joint_a2').value")
    saved = next(row for row in tables["parameters.csv"] if row["parameter"] == "joint_offset.joint_a2")
    check(abs(float(saved["value"]) - value) < 1e-9 and saved["unit"] == "deg", f"joint_a2 is saved as {saved}, not {value} deg")
    for row in tables["contacts.csv"]:
        gap = abs(float(row["residual_1_mm"]))
        is_gap = row["residual"] == "gap" and row["residual_2_mm"] == row["residual_3_mm"] == ""
        check(is_gap and abs(gap - float(row["after_mm"])) < 1e-9, f"a contact with a hole is saved as {row}")


def looks_as_before(browser, path, window, dark, keep):
    open_report(browser, path, window, dark).evaluate(f"document.head.append(el('style', {{}}, '* {{ font-family: \"{FONT}\" !important; }}'))")
    browser.settle()
    name = f"{path.parent.name}_{window[0]}_{'dark' if dark else 'light'}.png"
    picture = browser.picture()
    if keep:
        picture.save(keep / name)
    found, golden = scaled(picture, SCALE[window]), GOLDEN / name
    if os.environ.get("TOUCHCAL_UPDATE"):
        GOLDEN.mkdir(exist_ok=True)
        found.save(golden, optimize=True)
    expected = Image.open(golden).convert("RGB")
    check(expected.size == found.size, f"{name}: expected {expected.size} pixels, found {found.size}; TOUCHCAL_UPDATE=1 takes the new look over")
    share = different(expected, found)
    check(share < MOST_DIFFERENT, f"{name}: {100 * share:.1f} % of it looks otherwise; TOUCHCAL_UPDATE=1 takes the new look over")
    print(f"{name}: {100 * share:.2f} % of its pixels differ")


def first_paint(browser, path):
    size = path.stat().st_size
    check(size < MOST_BYTES, f"{path}: {size} bytes")
    times = []
    for _ in range(5):
        page = open_report(browser, path, DESKTOP)
        times.append(page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime"))
    median = statistics.median(times)
    print(f"{path.parent.name}: {size / 1e6:.2f} MB, first paint {median:.0f} ms (median of {', '.join(f'{time:.0f}' for time in times)})")
    check(median < FIRST_PAINT_MS, f"first paint takes {median:.0f} ms")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("touchcal")
    parser.add_argument("--keep", type=Path)
    arguments = parser.parse_args()
    fonts = subprocess.run(["fc-list", FONT], capture_output=True, text=True, check=False).stdout
    check(fonts, f"expected the font {FONT}")
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(exist_ok=True)
        paths = reports(Path(arguments.touchcal).resolve(), folder)
        with Browser() as browser:
            first_paint(browser, paths["demo_10000"])
            for name in ("not_usable", "free", "sockets"):
                for window, dark in ((DESKTOP, False), (PHONE, True)):
                    open_report(browser, paths[name], window, dark)
            for name, effects, assumptions in (("demo", False, False), ("contradicted", True, False), ("assumed", False, True)):
                for window in (DESKTOP, PHONE):
                    page = open_report(browser, paths[name], window)
                    shown = page.evaluate("['#effect-table tbody tr', '#assumptions li'].map((each) => document.querySelectorAll(each).length)")
                    check([count > 0 for count in shown] == [effects, assumptions], f"{name}: it shows {shown[0]} effects and {shown[1]} assumptions")
            page = open_report(browser, paths["hostile"], DESKTOP)
            shown = page.evaluate("[document.title, document.querySelector('#fixture-table td').textContent, document.images.length]")
            check(shown == ["touchcal: iiwa14", HOSTILE, 0], f"a hostile name does something: {shown}")
            saved = saved_tables(page)["fixtures.csv"][0]["fixture"]
            check(saved == "'" + HOSTILE, f"a hostile name is saved as {saved}")
            for name in ("demo", "sockets"):
                open_report(browser, paths[name], DESKTOP)
                arm_is_drawn_and_turns(browser, name)
            for window in (DESKTOP, PHONE):
                for dark in (False, True):
                    looks_as_before(browser, paths["demo"], window, dark, arguments.keep)
            saves_tables(browser, paths["demo"])
            for name in ("demo", "sockets", "contradicted", "evaluation_demo", "evaluation_sockets"):
                is_laid_out(browser, paths[name], is_audited=name != "evaluation_demo")


if __name__ == "__main__":
    main()
