"""linecontact: how large is the true contact of a thin elastic layer under a rigid indenter?

    from linecontact import Layer, PowerIndenter, Scene, solve

    scene = Scene(Layer(thickness=0.1, poisson_ratio=0.25), PowerIndenter(exponent=2), pressure=2e-3, num_points=2**14)
    solution = solve(scene)      # or solve(scene, accuracy=1e-4): as cheap as that accuracy allows
    print(solution)              # contact area and its error, patches, warnings, each with its unit
    solution.plot("run.pdf")     # heights, pressure, contact patches
    solution.save("run.h5")      # for linecontact.load

Layer, indenter and scene:

    Layer             an elastic layer bonded to a rigid base, or a half-space
    SlidingLayer      an elastic layer on a rigid base without friction
    CoatedHalfSpace   an elastic layer bonded to an elastic half-space
    TabulatedLayer    any layer, by a table of its stiffness K(q)
    PowerIndenter     one asperity: sharp, Hertzian (a parabola), blunt
    RoughIndenter     a random self-affine surface
    MeasuredIndenter  heights given point by point
    read_scan         a measured scan from a file, with its units
    Scene             a layer, an indenter, the mean pressure and the grid

The answer:

    solve             solves a scene
    Solution          the results, how they were found, and their warnings
    Observables       contact area, kappa, approach and other measured numbers
    PatchTable        where each contact patch is, and its load
    Certificate       how wrong the solution can be
    Status            how the solve ended
    contact_stiffness the change of the load with the approach, for a small one
    curve             solves a scene for several values of one of its numbers
    ensemble_mean     a mean over random surfaces, to a standard error
    plot              draws a solution, also one that was read from its file
    save, load        write a solution to an HDF5 file, read it back

Each has its own help, for instance help(linecontact.solve). Lengths share one unit of length, pressures one unit of
pressure; both are yours. On the command line `linecontact --help` lists the commands: solve one scene, run a
whole study, plot or export a stored file. The README and the pages in docs/ tell the rest, docs/results.md how to look
at results.

The names are imported when the first of them is used.
"""

import importlib
from typing import TYPE_CHECKING, Any

from .locks import IMPORTING

if TYPE_CHECKING:
    from .solver import (
        Certificate,
        CoatedHalfSpace,
        Layer,
        MeasuredIndenter,
        Observables,
        PatchTable,
        PowerIndenter,
        RoughIndenter,
        Scene,
        SlidingLayer,
        Solution,
        Status,
        TabulatedLayer,
    )
    from .solver.solve import solve
    from .solver.strategy.linearised import contact_stiffness
    from .studies.curve.columns import curve
    from .studies.figures.solution import plot
    from .studies.files.solution_files import load, save
    from .studies.multilevel.mean import ensemble_mean
    from .studies.scans.reading import read_scan

    __version__: str

_ELSEWHERE = {
    "curve": "linecontact.studies.curve.columns",
    "ensemble_mean": "linecontact.studies.multilevel.mean",
    "load": "linecontact.studies.files.solution_files",
    "plot": "linecontact.studies.figures.solution",
    "read_scan": "linecontact.studies.scans.reading",
    "save": "linecontact.studies.files.solution_files",
}
"""Modules of the names that are not those of `linecontact.solver`."""

__all__ = [
    "Certificate",
    "CoatedHalfSpace",
    "Layer",
    "MeasuredIndenter",
    "Observables",
    "PatchTable",
    "PowerIndenter",
    "RoughIndenter",
    "Scene",
    "SlidingLayer",
    "Solution",
    "Status",
    "TabulatedLayer",
    "__version__",
    "contact_stiffness",
    "curve",
    "ensemble_mean",
    "load",
    "plot",
    "read_scan",
    "save",
    "solve",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _version()
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with IMPORTING:
        from .help_texts import with_fields

        module = importlib.import_module(_ELSEWHERE.get(name, "linecontact.solver"))
    return with_fields(getattr(module, name))


def __dir__() -> list[str]:
    return __all__


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("linecontact")
    except PackageNotFoundError:
        return "unknown"
