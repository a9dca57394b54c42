"""Where a result came from: version, commit, libraries, machine."""

import os
import platform
import subprocess
from functools import cache
from importlib.metadata import version
from pathlib import Path

from .. import __version__
from ..kernels import processor


@cache
def provenance() -> dict[str, str]:
    """Version, commit (with '+dirty'), library versions, processor and system, all as text."""
    found = {"version": __version__, "commit": _commit(), "python": platform.python_version()}
    found |= {name: version(name) for name in ("warp-lang", "numpy", "pyfftw", "h5py")}
    return found | {"processor": processor(), "cores": str(os.cpu_count()), "system": platform.platform()}


def _commit() -> str:
    """Commit of the checkout that this package runs from, 'none' outside one."""
    folder = Path(__file__).resolve().parent.parent
    if not (folder / ".git").exists():
        return "none"

    command = ["git", "--no-optional-locks", "-C", str(folder), "status", "--porcelain=v2", "--branch"]
    try:
        said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout.splitlines()
        commit = next(line.split()[-1][:12] for line in said if line.startswith("# branch.oid"))
    except (OSError, subprocess.SubprocessError, StopIteration):
        return "none"
    return commit + ("" if all(line.startswith(("#", "?")) for line in said) else "+dirty")  # "?": not the project's
