"""Headless Chromium over its DevTools protocol, through two pipes; the standard library alone."""

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--no-first-run",
    "--disable-extensions",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--hide-scrollbars",
    "--force-color-profile=srgb",
    "--font-render-hinting=none",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--remote-debugging-pipe",
]
ANSWER_S = 60


class Chromium:
    """A browser with one page. `complaints` holds what it wrote to its console as errors or warnings, and what it wanted to load."""

    def __init__(self, program="chromium"):
        self.profile = tempfile.mkdtemp(prefix="touchcal-chromium-")
        to_browser, self._to = os.pipe()
        self._from, from_browser = os.pipe()
        command = f'exec "$0" "$@" 3<&{to_browser} 4>&{from_browser}'
        arguments = ["bash", "-c", command, program, *FLAGS, f"--user-data-dir={self.profile}", "about:blank"]
        self._process = subprocess.Popen(arguments, pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self._unread, self._number, self._events, self.complaints, self.loaded = b"", 0, [], [], []
        pages = [target for target in self.ask("Target.getTargets")["targetInfos"] if target["type"] == "page"]
        self._session = None
        self._session = self.ask("Target.attachToTarget", targetId=pages[0]["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.terminate()
        self._process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def ask(self, method, **params):
        """Sends a command, waits for its answer."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        if getattr(self, "_session", None):
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + ANSWER_S
        while True:
            answer = self._read(until, method)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self._note(answer)

    def wait_for(self, event):
        until = time.monotonic() + ANSWER_S
        while event not in self._events:
            self._note(self._read(until, event))

    def _read(self, until, what):
        while b"\0" not in self._unread:
            ready, _, _ = select.select([self._from], [], [], max(0.0, until - time.monotonic()))
            part = os.read(self._from, 1 << 20) if ready else b""
            if not part:
                raise RuntimeError(f"Chromium did not answer to {what} within {ANSWER_S} s, or left")
            self._unread += part
        message, self._unread = self._unread.split(b"\0", 1)
        return json.loads(message)

    def _note(self, event):
        method, params = event.get("method", ""), event.get("params", {})
        self._events.append(method)
        if method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.complaints.append(" ".join(str(value.get("value", value.get("description"))) for value in params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.complaints.append(params["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.loaded.append(params["request"]["url"])

    def open(self, path, width, height, dark=False, mobile=False):
        """Opens a file in a window of this size, waits until it rests."""
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)
        self.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self._events.clear()
        self.complaints.clear()
        self.loaded.clear()
        self.ask("Page.navigate", url=path.resolve().as_uri())
        self.wait_for("Page.loadEventFired")
        until = time.monotonic() + ANSWER_S
        while self.evaluate("document.documentElement.dataset.drawn") != "all" and time.monotonic() < until and not self.complaints:
            time.sleep(0.02)
        self.rest()

    def rest(self):
        """Waits until what was begun is drawn."""
        self.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 200))))")

    def evaluate(self, expression):
        answer = self.ask("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", "failed") + f" in {expression}")
        return answer["result"].get("value")

    def picture(self, clip=None, scale=1.0):
        """PNG of the page from top to bottom, or of `clip` (x, y, width, height)."""
        if clip is None:
            size = self.ask("Page.getLayoutMetrics")["cssContentSize"]
            clip = (0, 0, size["width"], size["height"])
        box = dict(zip(("x", "y", "width", "height"), clip), scale=scale)
        return base64.b64decode(self.ask("Page.captureScreenshot", format="png", clip=box, captureBeyondViewport=True)["data"])

    def drag(self, start, end):
        """With the left button."""
        event = lambda kind, place, **more: self.ask("Input.dispatchMouseEvent", type=kind, x=place[0], y=place[1], **more)
        event("mousePressed", start, button="left", buttons=1, clickCount=1)
        for k in range(1, 6):
            event("mouseMoved", [a + (b - a) * k / 5 for a, b in zip(start, end)], button="left", buttons=1)
        event("mouseReleased", end, button="left", buttons=0, clickCount=1)

    def key(self, name, times):
        """Pressed so often."""
        for _ in range(times):
            for kind in ("keyDown", "keyUp"):
                self.ask("Input.dispatchKeyEvent", type=kind, key=name, code=name)

    def pdf(self):
        return base64.b64decode(self.ask("Page.printToPDF", printBackground=True, preferCSSPageSize=False)["data"])
