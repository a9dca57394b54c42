"""The README's commands at their real size, on a terminal and without one, beside a process that keeps a core busy."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from pages import ROOT, command_lines

pty = pytest.importorskip("pty", reason="needs a pseudo-terminal")
pytestmark = pytest.mark.once

PATIENCE = 300  # seconds for what takes up to fifteen on an idle machine
COMMANDS = [
    found[0] for line in command_lines(ROOT / "README.md") if (found := re.findall(r"\blinecontact \w.*", line))
]
SERVER = "the page, on this machine only"


@pytest.fixture(scope="module", autouse=True)
def busy():
    """A core has something else to do, as on any machine that is used."""
    process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    yield
    process.kill()
    process.wait()


def begin(command, folder, output):
    """A command in a folder, by this environment's program."""
    shutil.copytree(ROOT / "docs" / "examples", folder / "docs" / "examples")
    environment = {
        **os.environ,
        "TERM": "xterm",
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    }
    allowed = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.default_int_handler)}
    return subprocess.Popen(
        command, shell=True, cwd=folder, env=environment, stdin=output, stdout=output, stderr=output, **allowed
    )


def finish(process, output):
    """All that a process says until it ends; the server is told to once it serves."""
    said, told, deadline = b"", False, time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        try:
            part = os.read(output, 4096)
        except OSError:  # of a terminal whose last program has ended
            part = b""
        said += part
        if SERVER.encode() in said and not told:
            told = True
            process.send_signal(signal.SIGINT)
        if not part:
            break
    return process.wait(PATIENCE), said.decode()


def run(command, folder, terminal):
    ours, theirs = pty.openpty() if terminal else os.pipe()
    process = begin(f"exec {command}", folder, theirs)
    os.close(theirs)
    try:
        return finish(process, ours)
    finally:
        os.close(ours)


def test_the_readme_has_commands():
    assert len(COMMANDS) == 6
    assert sum("explore" in command for command in COMMANDS) == 1


@pytest.mark.parametrize("terminal", [True, False], ids=["terminal", "pipe"])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_readme(command, terminal, tmp_path):
    status, said = run(command, tmp_path, terminal)
    assert status == (130 if "explore" in command else 0), said
    assert "Traceback" not in said
    assert "a bug" not in said
