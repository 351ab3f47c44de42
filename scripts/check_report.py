#!/usr/bin/env python3
"""Opens reports in headless Chromium: they draw without complaint, load nothing, fit the window, and look as they did.

Usage: scripts/check_report.py TOUCHCAL, the program; needs chromium and the font DejaVu Sans (Debian: chromium, fonts-dejavu-core), and contact logs in TOUCHCAL_DATA.
With TOUCHCAL_UPDATE=1 it writes the pictures to compare with anew; then look at them. With --keep FOLDER the reports and full pictures stay there.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from chromium import Chromium
from png import decode

GOLDEN = Path(__file__).resolve().parent / "report_golden"
FONT = "DejaVu Sans"
DESKTOP, PHONE = (1280, 800), (390, 844)
# Pictures are compared at this share of their size; of their pixels so many may differ, by more than so much in a channel of 255.
SCALE = {DESKTOP: 0.16, PHONE: 0.23}
MOST_DIFFERENT, NOTICEABLE = 0.02, 40
MOST_BYTES = 6_000_000
FIRST_PAINT_MS = 1000
# Share of the picture in space that must not be background.
LEAST_DRAWN = 0.01
# How far the page's own kinematics may be from the library's (m): joint positions travel as 32-bit numbers.
KINEMATICS_M = 1e-6
HOSTILE = '</script><script>document.title = "taken over"</script><img src=x onerror="alert(1)">'


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
        "free": (problem.replace("[[contacts]]", "free = true\n[[contacts]]", 1), 0),
        "hostile": (problem.replace('"hole"\nkind', f"'''{HOSTILE}'''\nkind").replace('fixture = "hole"', f"fixture = '''{HOSTILE}'''"), 0),
    }
    for name, (text, code) in variants.items():
        (folder / "demo" / f"{name}.toml").write_text(text)
        run("calibrate", f"demo/{name}.toml", "--out", name, code=code)
    mukca = Path(os.environ.get("TOUCHCAL_DATA", Path(__file__).parents[1] / "../shared/data")).resolve() / "mukca"
    run("calibrate", "--mukca", mukca / "panda_1", "--urdf", mukca / "panda.urdf", "--out", "sockets")
    return {name: folder / name / "report.html" for name in ("demo", "demo_10000", "sockets", *variants)}


def check(holds, complaint):
    if not holds:
        sys.exit(f"check_report: {complaint}")


def open_report(browser, path, window, dark=False):
    browser.open(path, *window, dark=dark, mobile=window == PHONE)
    where = f"{path.parent.name} at {window[0]} px, {'dark' if dark else 'light'}"
    check(not browser.complaints, f"{where}: the console says {browser.complaints}")
    loaded = [url for url in browser.loaded if not url.startswith(("data:", "blob:"))]
    check(loaded == [path.resolve().as_uri()], f"{where}: it loaded {loaded}")
    width = browser.evaluate("document.documentElement.scrollWidth")
    check(width <= window[0], f"{where}: it is {width} px wide")
    empty = browser.evaluate("[...document.querySelectorAll('figure:not([hidden]) .chart')].filter((host) => !host.querySelector('svg')).map((host) => host.id)")
    check(not empty, f"{where}: nothing is drawn in {empty}")


def arm(browser):
    """The picture in space, small."""
    box = browser.evaluate("(() => { const b = document.querySelector('#arm canvas').getBoundingClientRect(); return [b.x + scrollX, b.y + scrollY, b.width, b.height]; })()")
    return decode(browser.picture(box, scale=0.3)), box


def different(one, other, noticeable=NOTICEABLE):
    """Share of pixels that differ noticeably."""
    pairs = zip(zip(*[iter(one.pixels)] * 3), zip(*[iter(other.pixels)] * 3))
    return sum(max(abs(a - b) for a, b in zip(*pair)) > noticeable for pair in pairs) / (one.width * one.height)


def arm_is_drawn_and_turns(browser, name):
    before, box = arm(browser)
    background = before.pixels[:3]
    pixels = list(zip(*[iter(before.pixels)] * 3))
    drawn = sum(max(abs(a - b) for a, b in zip(pixel, background)) > NOTICEABLE for pixel in pixels) / len(pixels)
    check(drawn > LEAST_DRAWN, f"{name}: the picture in space is empty, {drawn:.3f} of it is drawn")
    browser.evaluate("document.querySelector('#arm').scrollIntoView({ block: 'center' })")
    x, y = browser.evaluate("(() => { const b = document.querySelector('#arm canvas').getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()")
    browser.drag((x, y), (x + 120, y + 20))
    dragged, _ = arm(browser)
    check(different(before, dragged) > 0.01, f"{name}: dragging does not turn the arm")
    browser.key("ArrowLeft", 5)
    keyed, _ = arm(browser)
    check(different(dragged, keyed) > 0.005, f"{name}: the arrow keys do not turn the arm")
    off = browser.evaluate(
        "Math.max(...data.scene.q.map((q, k) => origin(frames(data.scene.calibrated, q).tool).distanceTo(new three.Vector3(...data.scene.after[k]))))"
    )
    check(off < KINEMATICS_M, f"{name}: the arm is drawn {off} m beside its contacts")
    print(f"{name}: {100 * drawn:.0f} % of the picture in space is drawn, it turns, its tool is within {1e6 * off:.2f} µm of the contacts")


def looks_as_before(browser, path, window, dark, keep):
    open_report(browser, path, window, dark)
    browser.evaluate(f"document.head.append(el('style', {{}}, '* {{ font-family: \"{FONT}\" !important; }}'))")
    browser.rest()
    name = f"{path.parent.name}_{window[0]}_{'dark' if dark else 'light'}.png"
    if keep:
        (keep / name).write_bytes(browser.picture())
    picture = browser.picture(scale=SCALE[window])
    golden = GOLDEN / name
    if os.environ.get("TOUCHCAL_UPDATE"):
        GOLDEN.mkdir(exist_ok=True)
        golden.write_bytes(picture)
    expected, found = decode(golden.read_bytes()), decode(picture)
    size = lambda of: (of.width, of.height)
    check(size(expected) == size(found), f"{name}: expected {size(expected)} pixels, found {size(found)}; TOUCHCAL_UPDATE=1 takes the new look over")
    share = different(expected, found)
    check(share < MOST_DIFFERENT, f"{name}: {100 * share:.1f} % of it looks otherwise; TOUCHCAL_UPDATE=1 takes the new look over")
    print(f"{name}: {100 * share:.2f} % of its pixels differ")


def first_paint(browser, path):
    size = path.stat().st_size
    check(size < MOST_BYTES, f"{path}: {size} bytes")
    times = []
    for _ in range(5):
        open_report(browser, path, DESKTOP)
        times.append(browser.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime"))
    median = statistics.median(times)
    print(f"{path.parent.name}: {size / 1e6:.2f} MB, first paint {median:.0f} ms (median of {', '.join(f'{time:.0f}' for time in times)})")
    check(median < FIRST_PAINT_MS, f"first paint takes {median:.0f} ms")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("touchcal")
    parser.add_argument("--keep", type=Path)
    arguments = parser.parse_args()
    fonts = subprocess.run(["fc-list", FONT], capture_output=True, text=True, check=False).stdout
    check(fonts, f"expected the font {FONT}")
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(exist_ok=True)
        paths = reports(Path(arguments.touchcal).resolve(), folder)
        with Chromium() as browser:
            first_paint(browser, paths["demo_10000"])
            for name in ("not_usable", "free", "sockets"):
                for window, dark in ((DESKTOP, False), (PHONE, True)):
                    open_report(browser, paths[name], window, dark)
            open_report(browser, paths["hostile"], DESKTOP)
            said = browser.evaluate("[document.title, document.querySelector('#fixture-table td').textContent, document.images.length]")
            check(said == ["touchcal: iiwa14", HOSTILE, 0], f"a hostile name does something: {said}")
            for name in ("demo", "sockets"):
                open_report(browser, paths[name], DESKTOP)
                arm_is_drawn_and_turns(browser, name)
            for window in (DESKTOP, PHONE):
                for dark in (False, True):
                    looks_as_before(browser, paths["demo"], window, dark, arguments.keep)
            open_report(browser, paths["demo"], DESKTOP, dark=True)
            pdf = browser.pdf()
            check(pdf.startswith(b"%PDF"), "it does not print")
            if arguments.keep:
                (folder / "demo.pdf").write_bytes(pdf)


if __name__ == "__main__":
    main()
