"""Headless Chromium through Playwright: one page, with what its console reports and what it loads.

The browser is the system's `chromium` where there is one, else the one that `playwright install chromium` fetched.
"""

import io
import shutil

from PIL import Image
from playwright.sync_api import sync_playwright

FLAGS = [
    "--disable-dev-shm-usage",
    "--font-render-hinting=none",
    "--force-color-profile=srgb",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
TIMEOUT_MS = 60_000
SETTLED = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 200))))"


class Browser:
    """`errors` holds errors and warnings of the console and uncaught exceptions, `loaded` the addresses requested."""

    def __enter__(self):
        self._playwright = sync_playwright().start()
        self._browser = self._playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        self._page, self.errors, self.loaded = None, [], []
        return self

    def __exit__(self, *_):
        self._browser.close()
        self._playwright.stop()

    @property
    def page(self):
        return self._page

    def open(self, address, window, dark=False, mobile=False):
        """A new page of `window` (width, height in px)."""
        if self._page:
            self._page.context.close()
        width, height = window
        self._page = self._browser.new_page(
            viewport={"width": width, "height": height}, color_scheme="dark" if dark else "light", is_mobile=mobile
        )
        self._page.set_default_timeout(TIMEOUT_MS)
        self.errors, self.loaded = [], []
        errors, loaded = self.errors, self.loaded
        self._page.on("pageerror", lambda error: errors.append(str(error)))
        self._page.on("console", lambda message: errors.append(message.text) if message.type in ("error", "warning", "assert") else None)
        self._page.on("request", lambda request: loaded.append(request.url))
        self._page.goto(address)
        return self._page

    def open_report(self, path, window, dark=False, mobile=False):
        """A report, once all of it is drawn."""
        page = self.open(path.resolve().as_uri(), window, dark, mobile)
        # A selector: the page's security policy forbids what wait_for_function evaluates.
        page.wait_for_selector("html[data-drawn=all]", state="attached")
        self.settle()
        return page

    def settle(self):
        """Waits until what was begun is drawn."""
        self._page.evaluate(SETTLED)

    def picture(self, clip=None):
        """The page from top to bottom, or `clip` (x, y, width, height in px of the page)."""
        box = clip and dict(zip(("x", "y", "width", "height"), clip))
        return Image.open(io.BytesIO(self._page.screenshot(full_page=True, clip=box))).convert("RGB")
