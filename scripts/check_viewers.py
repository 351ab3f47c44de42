#!/usr/bin/env python3
"""Opens a calibration.mcap in Foxglove Studio, in headless Chromium, and has Rerun check it: every topic is there and nothing is complained about.

    scripts/check_viewers.py TOUCHCAL [--picture PNG]

TOUCHCAL is the program.
Chromium, npm and its registry must be there (180 MB, once, into target/foxglove).
"""

import argparse
import functools
import http.server
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from environment import enter

enter("viewers")

from PIL import Image, ImageChops  # noqa: E402

from browser import Browser  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
CONTACTS = 3000
# What a log of so many contacts holds: messages of each topic.
TOPICS = {
    "/contacts/calibrated": ("sensor_msgs/msg/PointCloud2", 1),
    "/contacts/nominal": ("sensor_msgs/msg/PointCloud2", 1),
    "/joint_states": ("sensor_msgs/msg/JointState", CONTACTS),
    "/parts": ("visualization_msgs/msg/MarkerArray", 1),
    "/tf": ("tf2_msgs/msg/TFMessage", CONTACTS),
}
# What Studio says of itself, whatever is opened; frames are missing until the first message is there.
OF_ITSELF = re.compile("Panel action resulted in identical config|Disposing renderer|^\\[general > followTf\\] ")
# The outlines of /parts: orange the fixture, blue the tool. So many pixels of either must be there.
ORANGE, BLUE = (240, 155, 50), (65, 130, 235)
LEAST_PIXELS, NEAR = 100, 50
STUDIO_S = 60


class Ranges(http.server.SimpleHTTPRequestHandler):
    """Serves parts of files too, which Studio asks for."""

    def do_GET(self):
        asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        path = Path(self.translate_path(self.path))
        if not asked or not path.is_file():
            return super().do_GET()
        content = path.read_bytes()
        first, last = int(asked[1]), int(asked[2] or len(content) - 1)
        self.send_response(206)
        self.send_header("Content-Range", f"bytes {first}-{last}/{len(content)}")
        self.send_header("Content-Length", str(last + 1 - first))
        self.end_headers()
        return self.wfile.write(content[first : last + 1])

    def end_headers(self):
        self.send_header("Accept-Ranges", "bytes")
        super().end_headers()

    def log_message(self, *_):
        pass


def check(holds, complaint):
    if not holds:
        sys.exit(f"check_viewers: {complaint}")


def in_rerun(log):
    rerun = Path(sys.prefix, "bin/rerun")
    done = subprocess.run([rerun, "mcap", "check", "--full", log], capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"Rerun: {done.stdout}{done.stderr}")
    print(f"Rerun: {(done.stdout + done.stderr).strip() or 'nothing wrong'}")


def in_foxglove(studio, picture_path):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Ranges, directory=studio))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    host = f"http://127.0.0.1:{server.server_port}"
    with Browser() as browser:
        page = browser.open(f"{host}/index.html?ds=remote-file&ds.url={host}/calibration.mcap", (1280, 800))
        until = time.monotonic() + STUDIO_S
        text = lambda: re.sub(r"\s+", " ", page.evaluate("document.body?.innerText ?? ''"))

        def wait_for(shown, what):
            while not re.search(shown, text()):
                check(time.monotonic() < until, f"Foxglove: no {what} within {STUDIO_S} s: {text()!r}")
                time.sleep(0.5)

        wait_for("/joint_states .* position ", "message of joint positions")
        page.keyboard.press("Space")
        wait_for(r" sec [2-9] ", "second two, playing")
        shown = text()
        for topic, (schema, messages) in TOPICS.items():
            check(f"{topic} {schema} {messages:,} " in shown, f"Foxglove: no {topic} of {messages} {schema} in {shown!r}")
        errors = [error for error in browser.errors if not OF_ITSELF.search(error)]
        check(not errors, f"Foxglove: errors on the console: {errors}")
        picture = browser.picture()
    if picture_path:
        picture.save(picture_path)
    for name, colour in (("fixture", ORANGE), ("tool", BLUE)):
        channels = ImageChops.difference(picture, Image.new("RGB", picture.size, colour)).split()
        greatest = ImageChops.lighter(ImageChops.lighter(*channels[:2]), channels[2])
        drawn = sum(greatest.histogram()[:NEAR])
        check(drawn >= LEAST_PIXELS, f"Foxglove: {drawn} pixels of the {name}'s outline")
    print(f"Foxglove: {', '.join(TOPICS)}; no complaint")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("touchcal", type=Path)
    parser.add_argument("--picture", type=Path)
    arguments = parser.parse_args()
    touchcal = arguments.touchcal.resolve()
    studio = ROOT / "target/foxglove"
    shutil.copytree(Path(__file__).parent / "foxglove", studio, dirs_exist_ok=True)
    subprocess.run(["npm", "ci", "--ignore-scripts", "--silent", "--no-audit", "--no-fund"], cwd=studio, check=True)
    with tempfile.TemporaryDirectory() as folder:
        run = lambda *command: subprocess.run([touchcal, *command], cwd=folder, stdout=subprocess.DEVNULL, check=True)
        run("demo", "--contacts", str(CONTACTS), "--out", "demo")
        run("calibrate", "demo/problem.toml", "--mcap", "--out", "out")
        log = Path(folder, "out/calibration.mcap")
        in_rerun(log)
        shutil.copy(log, studio)
    in_foxglove(studio, arguments.picture)


if __name__ == "__main__":
    main()
