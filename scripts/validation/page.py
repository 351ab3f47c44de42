"""The report in headless Chromium."""

import subprocess
import sys

from .commands import ROOT, program
from .report import Printed


def tables(_options):
    command = [sys.executable, ROOT / "scripts/check_report.py", program()]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    title = "Size, first paint (limit 1 s), drawing and look of reports."
    return [Printed(done.stdout, title, "`scripts/check_report.py target/debug/touchcal`", done.returncode != 0)]
