"""What the command-line tool prints on a terminal, which is narrower than its lines and no pager."""

import fcntl
import os
import pty
import struct
import subprocess
import termios
from pathlib import Path


def on_terminal(command: Path, *arguments: str, cwd: Path, columns: int = 60) -> str:
    """What is printed to a terminal of so many columns."""
    ours, its = pty.openpty()
    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    with subprocess.Popen([command, *arguments], cwd=cwd, stdout=its, stderr=subprocess.DEVNULL):
        os.close(its)
        printed = b""
        while True:
            try:
                part = os.read(ours, 1 << 16)
            except OSError:  # Linux: the other end is closed.
                part = b""
            if not part:
                break
            printed += part
    os.close(ours)
    return printed.decode().replace("\r\n", "\n")


def test_a_page_of_the_manual_is_not_printed(command: Path, tmp_path: Path) -> None:
    said = on_terminal(command, "man", cwd=tmp_path)
    assert "touchcal man | man -l -" in said and said.count("\n") == 1
    piped = subprocess.run([command, "man"], capture_output=True, text=True, check=True).stdout
    assert ".TH touchcal 1" in piped


def test_advice_is_wrapped(command: Path, sockets: Path) -> None:
    """Directions that are not identifiable have advice, longer than the terminal is wide."""
    lines = on_terminal(command, "inspect", "problem.toml", cwd=sockets).splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("          -> "))
    following = lines[at + 1]
    assert following.startswith("             ") and following[13] != " ", following
    assert all(len(line) <= 60 for line in lines[at : at + 2])
