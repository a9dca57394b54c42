"""Where a result came from: version, commit, libraries, machine."""

import os
import platform
import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


@cache
def package_version() -> str:
    """Version of the installed linecontact, 'unknown' if it is not installed."""
    try:
        return version("linecontact")
    except PackageNotFoundError:
        return "unknown"


@cache
def provenance() -> dict[str, str]:
    """Version, commit (with '+dirty'), library versions, processor and system, all as text."""
    found = {"version": package_version(), "commit": _commit(), "python": platform.python_version()}
    found |= {name: version(name) for name in ("warp-lang", "numpy", "pyfftw", "h5py")}
    return found | {"processor": _processor(), "cores": str(os.cpu_count()), "system": platform.platform()}


def _commit() -> str:
    """Commit of the checkout that this package runs from, 'none' outside one."""
    folder = Path(__file__).resolve().parent.parent
    if not (folder / ".git").exists():
        return "none"

    def git(*arguments: str) -> str:
        return subprocess.run(
            ["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True, timeout=10
        ).stdout.strip()

    try:
        return git("rev-parse", "--short=12", "HEAD") + ("+dirty" if git("status", "--porcelain") else "")
    except (OSError, subprocess.SubprocessError):
        return "none"


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
