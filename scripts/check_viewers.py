#!/usr/bin/env python3
"""Opens a calibration.mcap in Foxglove Studio, in headless Chromium, and has Rerun check it: every topic is there and nothing is complained about.

    pip install rerun-sdk==0.41.0
    scripts/check_viewers.py TOUCHCAL [--picture PNG]    # the program; needs chromium, npm and its registry (180 MB, once, into target/foxglove)
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

from chromium import Chromium
from png import decode

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
    done = subprocess.run(["rerun", "mcap", "check", "--full", log], capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"Rerun: {done.stdout}{done.stderr}")
    print(f"Rerun: {(done.stdout + done.stderr).strip() or 'nothing wrong'}")


def in_foxglove(studio, picture_path):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Ranges, directory=studio))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    host = f"http://127.0.0.1:{server.server_port}"
    with Chromium() as browser:
        browser.ask("Emulation.setDeviceMetricsOverride", width=1280, height=800, deviceScaleFactor=1, mobile=False)
        browser.ask("Page.navigate", url=f"{host}/index.html?ds=remote-file&ds.url={host}/calibration.mcap")
        until = time.monotonic() + STUDIO_S
        text = lambda: re.sub(r"\s+", " ", browser.evaluate("document.body?.innerText ?? ''"))

        def wait_for(shown, what):
            while not re.search(shown, text()):
                check(time.monotonic() < until, f"Foxglove: no {what} within {STUDIO_S} s: {text()!r}")
                time.sleep(0.5)

        wait_for("/joint_states .* position ", "message of joint positions")
        for kind in ("keyDown", "keyUp"):
            browser.ask("Input.dispatchKeyEvent", type=kind, key=" ", code="Space")
        wait_for(r" sec [2-9] ", "second two, playing")
        shown = text()
        for topic, (schema, messages) in TOPICS.items():
            check(f"{topic} {schema} {messages:,} " in shown, f"Foxglove: no {topic} of {messages} {schema} in {shown!r}")
        complaints = [said for said in browser.complaints if not OF_ITSELF.search(said)]
        check(not complaints, f"Foxglove says {complaints}")
        picture = browser.picture()
    if picture_path:
        picture_path.write_bytes(picture)
    pixels = decode(picture).pixels
    for name, colour in (("fixture", ORANGE), ("tool", BLUE)):
        drawn = sum(all(abs(pixels[k + c] - colour[c]) < NEAR for c in range(3)) for k in range(0, len(pixels), 3))
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
