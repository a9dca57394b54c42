"""A mean over random surfaces in Python."""

import math
from typing import Any

from linecontact.solver import Scene, checks

from . import samples
from .allocation import Wanted, grid_sizes, state
from .estimator import Estimate

MOST_SAMPLES = 2**20
"""Solves that may be planned, if nothing else is said."""


def ensemble_mean(
    scene: Scene,
    standard_error: float,
    *,
    observable: str = "kappa",
    relative: bool = False,
    max_seconds: float = math.inf,
    max_samples: int = MOST_SAMPLES,
) -> Estimate:
    """The mean of an observable over random surfaces, to a standard error, by multilevel Monte Carlo.

    scene: with an indenter that has a seed, the first of those that are taken; its grid is the finest that may be used.
    standard_error: of the mean, > 0, in the unit of the observable; if `relative`, over the mean and below 1.
    observable: 'kappa', 'contact-area', 'peak-pressure', 'approach' or 'mean-gap'. max_seconds, max_samples: time of
        solving [s], and solves, that may be planned.

    Returns the mean, its standard error, the bias of the finest grid, and what each grid has added. M. B. Giles,
    Operations Research 56, 607 (2008). Raises `ValueError`, also where the standard error is out of reach, which is
    known from the first surfaces.
    """
    wanted = check_wanted([observable], standard_error, relative, max_seconds, max_samples)
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {scene!r}; allowed: a Scene")
    check_scene(scene)
    sizes, seed = grid_sizes(scene), scene.indenter.seed  # type: ignore[attr-defined]
    rows: list[dict[str, Any]] = []
    while (now := state(rows, sizes, wanted, seed)).batches:
        rows += [row for batch in now.batches for row in samples.rows(scene, batch)]
    if now.out_of_reach:
        raise ValueError(f"standard_error is {standard_error:g}: {now.out_of_reach}")
    return now.estimates[observable]


def check_wanted(
    observables: list[str], standard_error: object, relative: bool, max_seconds: object, max_samples: object
) -> Wanted:
    """What was asked for, checked. Raises `ValueError`."""
    for name in observables:
        checks.choice("observable", name, tuple(samples.OBSERVABLES))
    if standard_error is None:
        raise ValueError("standard_error is missing; allowed: a number > 0, in the unit of the observable")
    allowed, most = ("a number > 0 and at most 1, over the mean", 1.0) if relative else ("a number > 0", math.inf)
    return Wanted(
        tuple(dict.fromkeys(observables)),
        checks.real("standard_error", standard_error, allowed, 0, most),
        bool(relative),
        checks.real("max_seconds", max_seconds, "a time > 0 [s]", 0, infinite=True),
        checks.integer("max_samples", max_samples, "an integer from 1 to 2^40", 1, 2**40),
    )


def check_scene(scene: Scene) -> None:
    """Raise `ValueError` for a scene of which there are no random surfaces."""
    if not hasattr(scene.indenter, "seed"):
        name = scene.indenter.to_dict().get("profile", type(scene.indenter).__name__)
        raise ValueError(f"profile is {name}; allowed: one with a seed, like rough")
    checks.integer("seed", scene.indenter.seed, "an integer from 0 to 2^40", 0, 2**40)
    if scene.approach is not None:
        raise ValueError(f"approach is {scene.approach:g}; allowed: a scene with a pressure")
