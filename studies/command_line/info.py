"""`linecontact info`: the parts of this installation, and where it keeps its caches."""

import platform
import sys
from dataclasses import dataclass

import warp as wp
from linecontact import kernels
from linecontact.solver import provenance
from linecontact.solver.transforms import plain, wisdom
from linecontact.solver.transforms.device import check_device, gpu_libraries

from ..runner.executors import usable_cores
from ..terminal import console
from ..terminal.tables import Whole


@dataclass(frozen=True)
class Options:
    """Versions, threads, caches and devices."""


def _gpus() -> list[str]:
    """Each GPU that Warp finds; of the one that --device cuda takes whether it can be used, or the missing part."""
    found = [f"{device} {device.name}" for device in wp.get_cuda_devices()]
    if found:
        try:
            check_device("cuda")
            found[0] += f" (--device cuda, {gpu_libraries()})"
        except ValueError as error:
            found[0] += f" ({error})"
    return found or ["no GPU with a driver for --device cuda"]


def command(_: Options) -> int:
    """Print it all as a table; returns the exit status."""
    kernels.load()
    table = Whole(title="linecontact", show_header=False)
    rows = {
        **provenance.provenance(),
        "FFTW": plain.library(),
        "threads": f"transforms 1 by default (--threads), kernels 1; {usable_cores()} cores usable",
        "instruction sets": kernels.instructions() or "unknown",
        "kernel flags": kernels.flags(),
        "Warp kernel cache": str(wp.config.kernel_cache_dir),
        "FFTW wisdom": f"{wisdom.wisdom_file()} ({'present' if wisdom.wisdom_file().exists() else 'none yet'})",
        "devices": ", ".join(["cpu (by default)", *_gpus()]),
        "interpreter": f"{sys.executable}, {platform.machine()}",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    console.Output().print(table)
    return 0
