"""No transforms go past the room of transforms, as the source of all modules is read."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ON_THEIR_OWN = (
    "studies/peers/areas.py",
    "studies/peers/solvers.py",
    "studies/kernel_benchmark/shipped.py",
    "studies/kernel_benchmark/transforms.py",
)
"""Checks, which share no code with what they check, surfaces of areas, and libraries beside each other."""


def transforms_by_hand(source):
    """Lines on which a module uses a library's Fourier transforms."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            base = "." + (getattr(node, "module", None) or "")
            names = [f"{base}.{alias.name}." for alias in node.names]
        elif isinstance(node, ast.Attribute):
            names = [f".{ast.unparse(node)}."]
        else:
            continue
        if any(part in name for name in names for part in (".fft.", ".pyfftw.")):
            found.add(node.lineno)
    return sorted(found)


@pytest.mark.parametrize(
    "source",
    [
        "np.fft.rfft(x)",
        "import numpy.fft",
        "from numpy import fft",
        "from numpy.fft import rfft as transform",
        "import scipy.fft",
        "import pyfftw",
        "from ..transforms.plain import pyfftw",
        "pyfftw.FFTW(a, b)",
        "def f():\n    from pyfftw.interfaces import numpy_fft",
    ],
)
def test_transforms_by_hand_are_found(source):
    assert transforms_by_hand(source)
    assert not transforms_by_hand("from ..transforms.plain import rfft\nversion('pyfftw')\nrfft(x)\nplain.irfft(x, n)")


def test_all_transforms_go_through_one_room():
    by_hand = {
        file.relative_to(ROOT).as_posix()
        for folder in ("solver", "studies")
        for file in (ROOT / folder).rglob("*.py")
        if transforms_by_hand(file.read_text())
    }
    room = {name for name in by_hand if name.startswith("solver/transforms/")}
    assert room
    assert by_hand - room == set(ON_THEIR_OWN)
