"""Figures, always drawn from a stored file and put beside it as PNG and PDF."""

import io
from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from ..edge_curve import figures as edge_curve
from ..extremes import figures as extremes
from ..figures import solution
from ..figures.style import STYLE, NothingToDraw
from ..files import hdf5, writing
from ..iterations import figures as iterations
from ..kernel_benchmark import figures as kernels
from ..peers import figures as peers
from ..power_profiles import figures as asperity
from ..rough_surfaces import figures as rough
from ..tradeoff import figures as tradeoff

__all__ = ["NothingToDraw", "draw"]

_DRAWINGS: dict[str, Callable[[Path], dict[str, Figure]]] = {
    **dict.fromkeys(("sharp", "hertz", "blunt"), asperity.draw),
    "rough": rough.draw,
    "iterations": iterations.draw,
    "edge-curve": edge_curve.draw,
    "kernels": kernels.draw,
    "peers": peers.draw,
    "tradeoff": tradeoff.draw,
    "extremes": extremes.draw,
    "soak": extremes.soak,
    "solution": solution.draw,
}


def draw(path: Path) -> list[Path]:
    """Draw everything that a stored file has figures for; returns the files. Raises `writing.StoreError`."""
    kind = hdf5.file_kind(path)
    if kind not in _DRAWINGS:
        raise writing.StoreError(f"file {path} is of kind {kind!r}; allowed: {', '.join(_DRAWINGS)}")
    files = []
    with plt.rc_context(STYLE), writing.expecting(path):
        for suffix, figure in _DRAWINGS[kind](path).items():
            for extension in ("png", "pdf"):
                image = io.BytesIO()
                figure.savefig(image, format=extension)
                files.append(path.with_name(f"{path.stem}{suffix}.{extension}"))
                writing.write_bytes(files[-1], image.getvalue())
            plt.close(figure)
    return files
