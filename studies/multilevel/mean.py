"""A mean over random surfaces in Python."""

import math
from dataclasses import replace
from typing import Any

from linecontact.solver import Scene, checks
from linecontact.solver.strategy.grids import check_memory

from ..files.records import warnings_in
from . import samples
from .allocation import FIRST_GRIDS, PILOT, Wanted, levels, state
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

    scene: with an indenter that has a seed, which tells one ensemble from another; its grid is the finest that may be
        used.
    standard_error: of the mean, 1e-60 and more, in the unit of the observable; if `relative`, over the mean and at
        most 1.
    observable: 'kappa', 'contact-area', 'peak-pressure', 'approach' or 'mean-gap'. max_seconds, max_samples: time of
        solving [s], and solves, that may be planned.

    Returns an `Estimate`: the mean, its standard error, an estimate of the finest grid's error (the bias), and the
    contribution of each grid. Where the finest grid is the scene's, the bias may be more than a third of the standard
    error. M. B. Giles, Operations Research 56, 607 (2008). Raises `ValueError`, also where the standard error is out of
    reach, which is known from the first surfaces.
    """
    if not isinstance(observable, str):
        raise checks.refusal("observable", observable, f"one of {', '.join(samples.OBSERVABLES)}")
    wanted = check_wanted([observable], standard_error, relative, max_seconds, max_samples)
    if not isinstance(scene, Scene):
        raise checks.refusal("scene", scene, "a Scene")
    check_scene(scene)
    check_memory(scene.num_points)
    sizes, seed = levels(scene), scene.indenter.seed  # type: ignore[attr-defined]
    rows: list[dict[str, Any]] = []
    while (now := state(rows, sizes, wanted, seed)).batches:
        rows += [row for batch in now.batches for row in samples.rows(scene, batch)]
    if now.out_of_reach:
        raise ValueError(f"standard_error is {standard_error:g}: {now.out_of_reach}")
    return replace(now.estimates[wanted.observables[0]], warnings=warnings_in(samples.on_finest(rows)))


def check_wanted(
    observables: list[str], standard_error: object, relative: bool, max_seconds: object, max_samples: object
) -> Wanted:
    """The request, checked. Raises `ValueError`."""
    names = [name.strip().replace("_", "-") for name in observables]
    for i, name in enumerate(names):
        checks.choice("observable", name, tuple(samples.OBSERVABLES))
        if name in names[:i]:
            raise ValueError(f"observable holds {name} a second time; allowed: each once")
    allowed, most = "a number of 1e-60 and more, in the unit of the observable", math.inf
    if standard_error is None:
        raise ValueError(f"standard_error is missing; allowed: {allowed}")
    if not isinstance(relative, bool):
        raise checks.refusal("relative", relative, "True or False")
    if relative:
        allowed, most = "1e-60 to 1, over the mean", 1.0
    fewest = PILOT * FIRST_GRIDS
    return Wanted(
        tuple(names),
        checks.real("standard_error", standard_error, allowed, math.nextafter(1e-60, 0), most),
        bool(relative),
        checks.real("max_seconds", max_seconds, "a time > 0 [s]", 0, infinite=True),
        checks.integer("max_samples", max_samples, f"an integer from {fewest} to 2^40", fewest, 2**40),
    )


def check_scene(scene: Scene) -> None:
    """Raise `ValueError` for a scene of which there are no random surfaces."""
    if not hasattr(scene.indenter, "seed"):
        name = scene.indenter.to_dict().get("profile", type(scene.indenter).__name__)
        raise ValueError(f"profile is {name}; allowed: one with a seed, like rough")
    checks.integer("seed", scene.indenter.seed, "an integer from 0 to 2^63 - 1", 0, 2**63 - 1)
    if scene.pressure == 0:
        raise ValueError("pressure is 0; allowed: a pressure > 0, which presses the surfaces together")
    if scene.approach is not None:
        raise ValueError(f"approach is {scene.approach:g}; allowed: a scene with a pressure")
