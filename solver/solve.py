"""From a scene to a certified solution."""

from collections.abc import Mapping

import numpy as np

from ..kernels import BACKENDS
from . import checks
from .arrays import Array64
from .methods import DEFAULT, METHODS, ExecutionConfig, MethodKind, Progress
from .one_thread import on_one_thread
from .scene import Scene
from .solution import Solution
from .strategy.errors import DEFAULT_QUANTITY
from .strategy.report import nothing_touches, without_contact
from .strategy.run import Run
from .strategy.to_accuracy import check_accuracy, solve_to_accuracy
from .strategy.to_approach import solve_to_approach
from .strategy.to_tolerance import solve_to_tolerance
from .transforms.device import DEVICES, borrowed, check_device, check_settings


@on_one_thread()
def solve(
    scene: Scene,
    *,
    accuracy: float | None = None,
    accuracy_of: str = DEFAULT_QUANTITY,
    method: str | None = None,
    nested: bool | None = None,
    tolerance: float | None = None,
    max_iterations: int | None = None,
    initial: Array64 | None = None,
    threads: int = 1,
    planning: str = "estimate",
    backend: str = "warp",
    device: str = "cpu",
    progress: Progress | None = None,
) -> Solution:
    """Solve a scene.

    accuracy: the relative error wanted, 1e-9 to 0.1 (dimensionless). Model, method, grid and tolerance are then chosen
        for it and must not be given; the scene's grid is the finest allowed, its precision must be the default. See
        `Solution.choices` and `Status.INACCURATE`. A scene whose approach is given takes neither this nor an initial
        displacement.
    accuracy_of: what the accuracy is wanted of, one of `QUANTITIES`: 'contact-area', 'kappa' (both between sub-grid
        edges), 'peak-pressure' or 'approach'. It concerns that alone.
    method: one of `METHODS`, by default `DEFAULT`.
    nested: start from the solution on coarser grids; by default for the active set only, and not with `initial`.
    tolerance: rms net force on free nodes over the mean pressure at which to stop, 1e-14 to 0.5 (dimensionless); by
        default `default_tolerance`, or what rounding leaves if that is more.
    max_iterations: at least 1, all grids, hand-over included; default by method. Where an approach is given, of each
        of the solves that it takes.
    initial: displacement to start from, shape (N,) [length], for instance a neighbour's solution.
    threads: of the transforms; where other programs keep the cores busy, two take many times as long as one.
    planning: FFTW's effort, 'estimate', 'measure' or 'patient'; what it finds is kept at once.
    backend: 'warp', or 'numpy' for the reference kernels.
    device: where the method works: 'cpu', or 'cuda' for a GPU, with a method whose `MethodKind.devices` names it. There
        threads and planning, which are FFTW's, concern the certificate alone, which is computed on the CPU.
    progress: called about ten times a second with (iteration, residual).

    A solve that fails to converge returns, too: see `Solution.status` and `Solution.reason`. So does one that Ctrl-C
    interrupts while it iterates; before the first iteration `KeyboardInterrupt` is passed on. Raises `ValueError`.
    """
    config = _config(scene, nested, threads, planning, backend, device, progress)
    chosen = {"method": method, "nested": nested, "tolerance": tolerance, "initial": initial}
    accuracy = _check_goal(scene, accuracy, accuracy_of, chosen | {"max_iterations": max_iterations}, device)
    kind = DEFAULT if accuracy else _kind(method, config)
    if max_iterations is not None:
        max_iterations = checks.integer("max_iterations", max_iterations, "an integer from 1 to 2^53", 1, 2**53)
    run = Run(scene, kind, config)
    if nothing_touches(scene):
        return without_contact(run)
    if accuracy:
        return solve_to_accuracy(run, accuracy, accuracy_of)

    def under_load(scene: Scene) -> Solution:
        return solve_to_tolerance(Run(scene, kind, config, limit=max_iterations), nested, tolerance, initial)

    with borrowed(device):
        return under_load(scene) if scene.approach is None else solve_to_approach(scene, under_load)


def _config(
    scene: object,
    nested: object,
    threads: int,
    planning: str,
    backend: str,
    device: str,
    progress: Progress | None,
) -> ExecutionConfig:
    """The configuration that was asked for. Raises `ValueError`, also for no scene and a bad `nested`."""
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {scene!r}; allowed: a Scene")
    if not (nested is None or isinstance(nested, bool | np.bool_)):
        raise ValueError(f"nested is {nested!r}; allowed: True, False or None")
    if not (progress is None or callable(progress)):
        raise ValueError(f"progress is {progress!r}; allowed: a function of an iteration and a residual, or None")
    threads, planning = check_settings(threads, planning)
    backend, device = checks.choice("backend", backend, BACKENDS), checks.choice("device", device, DEVICES)
    return ExecutionConfig(threads=threads, planning=planning, backend=backend, device=device, progress=progress)


def _check_goal(
    scene: Scene, accuracy: float | None, of: str, chosen: Mapping[str, object], device: str
) -> float | None:
    """The accuracy, if one is asked for. Raises `ValueError`, also where one of its choices is given, too."""
    if scene.approach is not None and not (accuracy is None and chosen["initial"] is None):
        given = f"accuracy is {accuracy!r}" if chosen["initial"] is None else "initial is given"
        raise ValueError(f"{given}; allowed: none for a scene with an approach")
    accuracy = check_accuracy(accuracy, of)
    if accuracy is not None:
        for name, value in chosen.items():
            if value is not None:
                raise ValueError(f"{name} is {value!r}; allowed: without accuracy only, which chooses it")
        if device != "cpu":
            raise ValueError(f"device is {device!r}; allowed with an accuracy: cpu alone, for the active set")
    return accuracy


def _kind(method: str | None, config: ExecutionConfig) -> MethodKind:
    """The method of that name. Raises `ValueError`, also for a device that it cannot work on, or that is not there."""
    kind = METHODS[checks.choice("method", DEFAULT.name if method is None else method, tuple(METHODS))]
    if not isinstance(kind, MethodKind):
        raise ValueError(f"method {method} is {kind!r} in METHODS; allowed: a MethodKind")
    if config.device not in kind.devices:
        able = ", ".join(other.name for other in METHODS.values() if config.device in other.devices)
        allowed = f"{', '.join(kind.devices)} for method {kind.name}, or one of the methods {able}"
        raise ValueError(f"device is {config.device!r}; allowed: {allowed}")
    if config.device != "cpu" and config.backend != "warp":
        raise ValueError(f"backend is {config.backend!r}; allowed: warp, on device {config.device}")
    check_device(config.device)
    return kind
