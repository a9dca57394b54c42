"""`linecontact explore`: a page in the browser on which sliders move the scene."""

from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import ClassVar

from linecontact.solver import LAYERS, MeasuredIndenter, Scene, Status, TabulatedLayer, solve

from ..scenes import kinds, making
from ..scenes.making import Given, make_scene
from ..terminal import console
from ..terminal.options import one_of, refused

_NUM_POINTS = 2**14


@dataclass(frozen=True)
class Options(making.Options):
    """Move a scene by sliders, on a page in the browser: thickness, Poisson's ratio, load, and the indenter's numbers.

    The page is served to this machine only, by this process, until Ctrl-C. It shows indenter and surface, contact
    pressure and patches, and the contact area over the load and over the thickness, each answer with its error and its
    milliseconds. A link and a command line on the page repeat the scene that it shows.
    """

    num_points: int | None = None
    """Grid points, at least 4, like 16384 or 2^14; default 2^14, for a file four or more to a value."""
    layer: str = one_of(LAYERS, next(iter(LAYERS)))
    """Layer, any but file, a table that no slider can move; each one and its options are described below."""
    precision: ClassVar[str] = Scene.precision
    accuracy: float | None = refused()
    """None: the grid is that of num_points."""
    port: int = 5006
    """Port on 127.0.0.1 at which the page is served; 0: any that is free."""
    browser: bool = False
    """Open the page in a browser."""


def command(options: Options, given: Given) -> int:
    """Serve the page until Ctrl-C, which is passed on."""
    if not 0 <= options.port < 2**16:
        raise ValueError(f"port is {options.port}; allowed: an integer from 0 to 65535")
    try:
        import bokeh  # noqa: F401
    except ModuleNotFoundError:
        way = "`pip install -e '.[explore]'` inside the repository"
        raise ValueError(f"bokeh is missing; allowed: explore after {way}") from None
    from ..explore import start

    if options.layer == TabulatedLayer.name:
        raise ValueError(f"layer is {options.layer}; allowed: one that sliders can move, which a table is not")
    words, scan = given[kinds.title("profile", MeasuredIndenter.name)], None
    if options.accuracy is not None:
        raise ValueError(f"accuracy is {options.accuracy}; allowed: none, the grid is that of num_points")
    if options.profile != MeasuredIndenter.name and options.num_points is None:
        options = replace(options, num_points=_NUM_POINTS)
    if options.profile == MeasuredIndenter.name and "profile_file" in words:
        scan = start.Scan.of(words["profile_file"], words)
    begin = start.Start(make_scene(options, given), scan)
    with console.errors.status("Preparing the page") if console.errors.is_terminal else nullcontext():
        from ..explore import server

        # compiling and planning are done before the first page
        if solve(begin.first).status is Status.INTERRUPTED:
            raise KeyboardInterrupt
    with server.served(begin, options.port) as (address, loop):
        print(f"{address} shows the page, on this machine only, until Ctrl-C", flush=True)
        if options.browser:
            server.open_browser(address)
        server.answer_requests(loop)
