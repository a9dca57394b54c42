"""`linecontact info`: what this installation consists of, and where it keeps its caches."""

import os
import platform
import sys
from dataclasses import dataclass

import warp as wp
from linecontact import kernels
from linecontact.kernels import tuning
from linecontact.solver import provenance
from linecontact.solver.transforms import planned, wisdom

from ..terminal import console
from ..terminal.tables import Whole


@dataclass(frozen=True)
class Options:
    """Versions, threads, caches and devices."""


def command(_: Options) -> int:
    """Print it all as a table; returns the exit status."""
    kernels.load()
    table = Whole(title="linecontact", show_header=False)
    rows = {
        **provenance.provenance(),
        "FFTW": planned.library(),
        "threads": f"FFTW 1 by default (--threads), Warp 1; {len(os.sched_getaffinity(0))} cores usable"
        if hasattr(os, "sched_getaffinity")
        else str(os.cpu_count()),
        "instruction sets": kernels.instructions() or "unknown",
        "flags of the kernels": ", ".join(f"{module} {name}" for module, name in tuning.chosen().items()),
        "Warp kernel cache": str(wp.config.kernel_cache_dir),
        "FFTW wisdom": f"{wisdom.wisdom_file()} ({'present' if wisdom.wisdom_file().exists() else 'none yet'})",
        "devices": ", ".join(str(device) for device in wp.get_devices()) + " (only cpu is used)",
        "interpreter": f"{sys.executable}, {platform.machine()}",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    console.Output().print(table)
    return 0
